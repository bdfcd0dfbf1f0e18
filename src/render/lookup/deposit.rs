//! How the gather passes are dispatched.

use std::time::Instant;

use bytemuck::Pod;
use goblet_host::Pass;

use crate::kernels::{PassFeatures, RenderFeatures, Specialization};
use crate::render::counters::{Counted, Tally};
use crate::render::error::RenderError;
use crate::render::pacing::Pace;
use crate::render::stage::{Stage, finished};

/// Dispatches the pass that adds photons until all invocations are finished, and returns its counts. `push`
/// makes the push constants from the first invocation of a dispatch and a flag: 1 if the dispatch continues
/// the invocations that the previous dispatch left unfinished, 0 if it starts them.
///
/// # Errors
/// The device fails, the driver ends the pass early, or the caller gives the iteration up.
pub(super) fn deposit<Push: Pod>(
    on: Stage<'_>,
    (name, pass): (&'static str, &Pass<Push>),
    invocations: u64,
    pace: &mut Pace,
    push: impl Fn(u32, u32) -> Push,
) -> Result<Tally, RenderError> {
    let mut total = Tally::default();
    let (mut first, mut resumed) = (0, 0);
    while first < invocations {
        on.may_go_on()?;
        let count = pace.next(invocations - first);
        let start = Instant::now();
        let counters = on.run_counted(|frame| frame.dispatch(pass, push(first as u32, resumed), count))?;
        finished(&counters, name, "a smaller radius")?;
        total.add(Counted::Gathering, &counters);
        resumed = u32::from(counters.unfinished > 0);
        if counters.unfinished == 0 {
            pace.observe(count, start.elapsed());
            first += count;
        }
    }
    Ok(total)
}

/// Returns what the pass that adds photons of caustics is specialised to, from what the one for all photons is. Radii
/// do not follow from caustics alone.
pub(super) fn of_caustics(specialization: &Specialization) -> Specialization {
    Specialization {
        pass: PassFeatures { gathers_caustics: true, ..specialization.pass },
        render: RenderFeatures { has_data_radii: false, ..specialization.render },
        ..*specialization
    }
}
