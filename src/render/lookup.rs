//! The search for the photons on the disc of each visible point: the passes that index photons or visible
//! points, and the pass that adds photons to visible points.

mod deposit;
mod grid;
pub mod kd_tree;
mod photon_grid;
mod rough;
mod tree;

use std::time::Duration;

use goblet_host::{Device, Frame};
use grid::HashGrid;
use photon_grid::PhotonGrid;
pub use rough::RoughGather;
use tree::{KdTree, TreeArrays};

use crate::kernels::Specialization;
use crate::render::buffers::{Buffers, Sizes};
use crate::render::error::RenderError;
use crate::render::layers::CausticFlux;
use crate::render::options::LookupKind;
use crate::render::progress::Progress;
use crate::render::stage::Stage;

/// An index with its passes. Both kinds give the same sums.
pub enum Lookup {
    /// A hash grid over the photons of a batch.
    Grid(Box<HashGrid>),
    /// A kd-tree over the visible points.
    Tree(Box<KdTree>),
}

impl Lookup {
    /// Compiles the passes and allocates the index. Photons of caustics are summed once more, if there are arrays
    /// for them.
    ///
    /// # Errors
    /// The device has too little memory, or the driver refuses a kernel.
    pub fn new(
        device: &Device,
        buffers: (&Buffers, Option<&CausticFlux>),
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

    /// Returns the number of kernels that [`Lookup::new`] compiles.
    pub fn kernels(kind: LookupKind, has_caustics: bool) -> u32 {
        let of_index = match kind {
            LookupKind::HashGrid => PhotonGrid::KERNELS,
            LookupKind::KdTree => 1,
        };
        of_index + 1 + u32::from(has_caustics)
    }

    /// Returns the bytes that the index takes, without allocating it.
    pub fn bytes(kind: LookupKind, sizes: &Sizes) -> u64 {
        match kind {
            LookupKind::HashGrid => HashGrid::bytes(sizes),
            LookupKind::KdTree => TreeArrays::bytes(sizes),
        }
    }

    /// Runs each pass once without work, because a driver may compile a kernel at its first dispatch.
    pub fn warm_up(&self, frame: &mut Frame<'_>) {
        match self {
            Self::Grid(grid) => grid.warm_up(frame),
            Self::Tree(tree) => tree.warm_up(frame),
        }
    }

    /// Indexes the visible points; a grid needs nothing. `new` says whether the points are new, or the points
    /// of the last call with other radii.
    ///
    /// # Errors
    /// The device fails.
    pub fn index_points(&mut self, on: Stage<'_>, new: bool) -> Result<(), RenderError> {
        match self {
            Self::Grid(_) => Ok(()),
            Self::Tree(tree) => tree.build(on, new),
        }
    }

    /// Indexes the `recorded` photons of a batch; a tree needs nothing.
    ///
    /// # Errors
    /// The device fails.
    pub fn index_photons(&self, on: Stage<'_>, recorded: u32) -> Result<(), RenderError> {
        match self {
            Self::Grid(grid) => grid.build(on, recorded),
            Self::Tree(_) => Ok(()),
        }
    }

    /// Adds each of the `recorded` photons of a batch to the visible points on whose discs it lies.
    ///
    /// # Errors
    /// The device fails, the driver ends the pass early, or the caller gives the iteration up.
    pub fn gather(&self, on: Stage<'_>, recorded: u32, progress: &mut Progress) -> Result<(), RenderError> {
        let gathered = match self {
            Self::Grid(grid) => grid.gather(on, &mut progress.schedule.paces.gather),
            Self::Tree(tree) => tree.gather(on, recorded, &mut progress.schedule),
        }?;
        progress.tally.merge(&gathered);
        Ok(())
    }

    /// Returns the grid, which the device builds without the host.
    pub fn grid(&self) -> Option<&HashGrid> {
        match self {
            Self::Grid(grid) => Some(grid),
            Self::Tree(_) => None,
        }
    }

    /// Returns the time that the host has spent on indices so far.
    pub fn host_time(&self) -> Duration {
        match self {
            Self::Grid(_) => Duration::ZERO,
            Self::Tree(tree) => tree.host_time(),
        }
    }
}
