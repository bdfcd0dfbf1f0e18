//! The photon pass: emits and traces photons, and records where they meet diffuse surfaces,
//! `shaders/passes/photon.comp`.

use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

use bytemuck::Zeroable;
use goblet_host::{Frame, Pass};

use super::path::{PathKernels, PathPass, Start};
use crate::kernels::PhotonPush;
use crate::render::counters::Counted;
use crate::render::error::RenderError;
use crate::render::progress::Progress;
use crate::render::radius::RadiusSchedule;
use crate::render::sequence::IterationIndex;
use crate::render::stage::Stage;

/// The photon pass.
pub struct PhotonPass {
    pass: PathPass<PhotonPush>,
    kernels: Arc<PathKernels>,
}

impl PhotonPass {
    pub(super) fn new(pass: Pass<PhotonPush>, kernels: Arc<PathKernels>) -> Self {
        Self { pass: PathPass::new(pass, kernels.workgroup_size), kernels }
    }

    pub(super) fn warm_up(&self, frame: &mut Frame<'_>) {
        frame.dispatch(self.pass.plain(), Zeroable::zeroed(), 1);
    }

    /// Traces the photons of a batch, by their numbers in the iteration. Returns the number of
    /// records, or `None` if the record buffer has no room for them; then the schedule has
    /// smaller batches.
    ///
    /// # Errors
    /// The device fails, or the caller gives the iteration up.
    pub fn run(
        &mut self,
        on: Stage<'_>,
        index: IterationIndex,
        batch: Range<u64>,
        progress: &mut Progress,
    ) -> Result<Option<u32>, RenderError> {
        // A disc that found many photons is smaller in the next iteration, in which a sequence
        // that spreads its points evenly has fewer for it: the image would get darker. So the
        // iterations that share visible points, and whose radii depend on earlier ones, have a
        // sequence each.
        let (stream, iterations_before) = match on.settings.radius_schedule {
            RadiusSchedule::Adaptive => (index.step, index.turn.into()),
            RadiusSchedule::Global => (0, index.iteration_of_half),
        };
        let before = on.settings.photons.wrapping_mul(iterations_before);
        let count = batch.end - batch.start;
        let stride = count.div_ceil(progress.schedule.per_invocation());
        let capacity = on.buffers.photons.len();
        let push = |Start { offset, resumed, spread }| PhotonPush {
            before_low: before as u32,
            before_high: (before >> 32) as u32,
            half_of_rounds: index.half,
            stream,
            first: batch.start as u32,
            end: batch.end as u32,
            stride: stride as u32,
            capacity: capacity as u32,
            offset,
            resumed,
            spread,
        };
        let start = Instant::now();
        let resumable = || self.kernels.photon(on.device, on.buffers, true)?.finish();
        let counters = self.pass.run(on, stride, &mut progress.schedule.paces.photon, resumable, push)?;
        if u64::from(counters.recorded) > capacity && progress.schedule.overflowed() {
            return Ok(None);
        }
        progress.schedule.observe(count, start.elapsed());
        progress.tally.add(Counted::Photon, &counters);
        Ok(Some(counters.recorded))
    }
}
