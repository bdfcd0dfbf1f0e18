//! How photons and the visible points that they reach find each other: the passes that index
//! one or the other, and the pass that adds photons to points.

mod grid;
pub mod kd_tree;
mod tree;

use std::time::{Duration, Instant};

use bytemuck::Pod;
use goblet_host::{Device, Frame, Pass};
use grid::{GridArrays, HashGrid};
use tree::{KdTree, TreeArrays};

use crate::kernels::Specialization;
use crate::render::buffers::{Buffers, Sizes};
use crate::render::counters::{Counted, Tally};
use crate::render::error::RenderError;
use crate::render::options::LookupKind;
use crate::render::pacing::Pace;
use crate::render::progress::Progress;
use crate::render::stage::{Stage, finished};

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
        sizes: &Sizes,
        kind: LookupKind,
        specialization: &Specialization,
        workgroup_size: u32,
    ) -> goblet_host::Result<Self> {
        Ok(match kind {
            LookupKind::HashGrid => {
                Self::Grid(HashGrid::new(device, buffers, sizes, specialization, workgroup_size)?.into())
            }
            LookupKind::KdTree => {
                Self::Tree(KdTree::new(device, buffers, sizes, specialization, workgroup_size)?.into())
            }
        })
    }

    /// Bytes of the index, before it is allocated.
    pub fn bytes(kind: LookupKind, sizes: &Sizes) -> u64 {
        match kind {
            LookupKind::HashGrid => GridArrays::bytes(sizes),
            LookupKind::KdTree => TreeArrays::bytes(sizes),
        }
    }

    /// Runs the passes once over nothing, since drivers may leave compilation to the first
    /// dispatch.
    pub fn warm_up(&self, frame: &mut Frame<'_>) {
        match self {
            Self::Grid(grid) => grid.warm_up(frame),
            Self::Tree(tree) => tree.warm_up(frame),
        }
    }

    /// Indexes the visible points, where the index is over them: `new` ones, or those of the last
    /// call with other radii.
    ///
    /// # Errors
    /// The device fails.
    pub fn index_points(&mut self, on: Stage<'_>, new: bool) -> Result<(), RenderError> {
        match self {
            Self::Grid(_) => Ok(()),
            Self::Tree(tree) => tree.build(on, new),
        }
    }

    /// Indexes the `recorded` photons of a batch, where the index is over them.
    ///
    /// # Errors
    /// The device fails.
    pub fn index_photons(&self, on: Stage<'_>, recorded: u32) -> Result<(), RenderError> {
        match self {
            Self::Grid(grid) => grid.build(on, recorded),
            Self::Tree(_) => Ok(()),
        }
    }

    /// Adds the `recorded` photons of a batch to the visible points on whose discs they are.
    ///
    /// # Errors
    /// The device fails, or the driver ends the pass early.
    pub fn gather(&self, on: Stage<'_>, recorded: u32, progress: &mut Progress) -> Result<(), RenderError> {
        let gathered = match self {
            Self::Grid(grid) => grid.gather(on, recorded, &mut progress.schedule.paces.gather),
            Self::Tree(tree) => tree.gather(on, recorded, &mut progress.schedule),
        }?;
        progress.tally.merge(&gathered);
        Ok(())
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
