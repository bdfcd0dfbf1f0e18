//! How photons and the visible points that they reach find each other: the passes that index
//! one or the other, and the pass that adds photons to points.

mod grid;
pub mod kd_tree;
mod tree;

use std::time::{Duration, Instant};

use bytemuck::Pod;
use goblet_host::{Device, Frame, Pass};
use grid::HashGrid;
use tree::KdTree;

use crate::kernels::Specialization;
use crate::render::buffers::Buffers;
use crate::render::counters::{Counted, Tally};
use crate::render::iteration::{Stage, finished};
use crate::render::options::LookupKind;
use crate::render::pacing::{Pace, Schedule};
use crate::render::renderer::RenderError;

/// One way or the other; both give the same sums.
pub enum Lookup {
    /// A hash grid.
    Grid(Box<HashGrid>),
    /// A kd-tree.
    Tree(Box<KdTree>),
}

impl Lookup {
    /// Compiles the passes and allocates the index.
    ///
    /// # Errors
    /// Out of memory, or the driver refuses a kernel.
    pub fn new(
        device: &Device,
        buffers: &Buffers,
        kind: LookupKind,
        specialization: &Specialization,
        workgroup_size: u32,
    ) -> goblet_host::Result<Self> {
        Ok(match kind {
            LookupKind::HashGrid => Self::Grid(HashGrid::new(device, buffers, specialization, workgroup_size)?.into()),
            LookupKind::KdTree => Self::Tree(KdTree::new(device, buffers, specialization, workgroup_size)?.into()),
        })
    }

    /// Runs the passes once over nothing, since drivers may leave compilation to the first
    /// dispatch.
    pub fn warm_up(&self, frame: &mut Frame<'_>) {
        match self {
            Self::Grid(grid) => grid.warm_up(frame),
            Self::Tree(tree) => tree.warm_up(frame),
        }
    }

    /// Indexes the visible points, which are `new` or have other radii only. The grid is over
    /// photons, and built when there are some.
    ///
    /// # Errors
    /// The device fails.
    pub fn build(&mut self, on: Stage<'_>, new: bool) -> Result<(), RenderError> {
        match self {
            Self::Grid(_) => Ok(()),
            Self::Tree(tree) => tree.build(on, new),
        }
    }

    /// Adds `recorded` photons to the points that they reach.
    ///
    /// # Errors
    /// The device fails, or the driver ends the pass early.
    pub fn gather(&self, on: Stage<'_>, recorded: u32, schedule: &mut Schedule) -> Result<Tally, RenderError> {
        match self {
            Self::Grid(grid) => grid.gather(on, recorded, &mut schedule.paces.gather),
            Self::Tree(tree) => tree.gather(on, recorded, schedule),
        }
    }

    /// Time that the host, rather than the device, has spent on indices so far.
    pub fn host_time(&self) -> Duration {
        match self {
            Self::Grid(_) => Duration::ZERO,
            Self::Tree(tree) => tree.host_time(),
        }
    }
}

/// Dispatches the pass that adds photons until no invocation is unfinished. `push` is told the
/// first of them, and whether to go on from where the dispatch before has stopped.
fn deposit<Push: Pod>(
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
