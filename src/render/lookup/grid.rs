//! The hash grid over photons.

use bytemuck::Zeroable;
use goblet_host::{Device, Frame, Pass};

use super::deposit::deposit;
use crate::kernels::{
    Cell, GatherGrid, GatherGridPush, GridCount, GridCountPush, GridFill, GridFillPush, GridPlace, GridReserve,
    GridReservePush, POINTS, PhotonRecord, Specialization,
};
use crate::render::buffers::{Buffers, Sizes, device_arrays, invocations_by_tile};
use crate::render::counters::Tally;
use crate::render::error::RenderError;
use crate::render::pacing::Pace;
use crate::render::stage::Stage;

device_arrays! {
    /// The grid's arrays, for the largest number of photons that a batch may record.
    pub struct GridArrays(sizes) {
        cells: Buffer<Cell>[sizes.recorded.next_power_of_two()],
        grid_filled: Buffer<u32>[1_u32],
        grid_photons: Texels<PhotonRecord>[sizes.recorded],
        places: Buffer<GridPlace>[sizes.by_tile / u64::from(POINTS)],
    }
}

/// A hash grid, and the passes that build and use it.
pub struct HashGrid {
    arrays: GridArrays,
    count: Pass<GridCountPush>,
    reserve: Pass<GridReservePush>,
    fill: Pass<GridFillPush>,
    gather: Pass<GatherGridPush>,
}

impl HashGrid {
    /// Compiles the passes and allocates the grid.
    ///
    /// # Errors
    /// The device has too little memory, or the driver refuses a kernel.
    pub fn new(
        device: &Device,
        buffers: &Buffers,
        sizes: &Sizes,
        specialization: &Specialization,
        workgroup_size: u32,
    ) -> goblet_host::Result<Self> {
        let Buffers { photons, visible_points, visible_radii2, max_radius2, .. } = buffers;
        let Buffers { flux_red, flux_green, flux_blue, flux_counts, counters, .. } = buffers;
        let arrays = GridArrays::allocate(device, sizes)?;
        let GridArrays { cells, grid_filled, grid_photons, places } = &arrays;
        macro_rules! pass {
            ($($kernel:tt)*) => { device.pass(&$($kernel)*, specialization, workgroup_size)? };
        }
        Ok(Self {
            count: pass!(GridCount { photons, max_radius2, cells }),
            reserve: pass!(GridReserve { grid_filled, cells }),
            fill: pass!(GridFill { photons, max_radius2, cells, grid_photons }),
            gather: pass!(GatherGrid {
                visible_points,
                visible_radii2,
                max_radius2,
                cells,
                grid_photons,
                counters,
                places,
                flux_red,
                flux_green,
                flux_blue,
                flux_counts
            }),
            arrays,
        })
    }

    /// Runs each pass once without work, because a driver may compile a kernel at its first dispatch.
    pub fn warm_up(&self, frame: &mut Frame<'_>) {
        frame.dispatch(&self.count, Zeroable::zeroed(), 1);
        frame.dispatch(&self.reserve, Zeroable::zeroed(), 1);
        frame.dispatch(&self.fill, Zeroable::zeroed(), 1);
        frame.dispatch(&self.gather, Zeroable::zeroed(), 1);
    }

    /// Sorts the `recorded` photons of a batch into cells.
    ///
    /// # Errors
    /// The device fails.
    pub fn build(&self, on: Stage<'_>, recorded: u32) -> Result<(), RenderError> {
        let cell_count = self.cell_count(recorded);
        let cell_mask = cell_count - 1;
        let mut frame = on.device.frame()?;
        frame.clear(&self.arrays.grid_filled);
        frame.clear_first(&self.arrays.cells, cell_count.into());
        frame.dispatch(&self.count, GridCountPush { recorded, cell_mask }, recorded.into());
        frame.dispatch(&self.reserve, GridReservePush { cell_count }, cell_count.into());
        frame.dispatch(&self.fill, GridFillPush { recorded, cell_mask }, recorded.into());
        Ok(frame.run()?)
    }

    /// Adds each of the `recorded` photons in the grid to the visible points on whose discs it lies.
    ///
    /// # Errors
    /// The device fails, the driver ends the pass early, or the caller gives the iteration up.
    pub fn gather(&self, on: Stage<'_>, recorded: u32, pace: &mut Pace) -> Result<Tally, RenderError> {
        let cell_mask = self.cell_count(recorded) - 1;
        let [width, height] = on.settings.resolution;
        let push = |offset, resumed| GatherGridPush { width, height, cell_mask, resumed, offset };
        let invocations = invocations_by_tile([width, height]) / u64::from(POINTS);
        deposit(on, ("gather_grid", &self.gather), invocations, pace, push)
    }

    /// Returns the number of cells of a grid over `recorded` photons: the number of photons rounded up to a
    /// power of two, since more cells would be empty.
    fn cell_count(&self, recorded: u32) -> u32 {
        u64::from(recorded).next_power_of_two().min(self.arrays.cells.len()) as u32
    }
}
