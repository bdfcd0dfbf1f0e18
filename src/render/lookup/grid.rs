//! The hash grid over photons.

use bytemuck::Zeroable;
use goblet_host::{Buffer, Device, Frame, Pass};

use super::deposit;
use crate::kernels::{
    Cell, GatherGrid, GatherGridPush, GridCount, GridCountPush, GridFill, GridFillPush, GridPlace, GridReserve,
    GridReservePush, POINTS, Specialization,
};
use crate::render::buffers::{Buffers, invocations_by_tile};
use crate::render::counters::Tally;
use crate::render::iteration::Stage;
use crate::render::pacing::Pace;
use crate::render::renderer::RenderError;

/// A hash grid, and the passes that build and use it.
pub struct HashGrid {
    cells: Buffer<Cell>,
    filled: Buffer<u32>,
    count: Pass<GridCountPush>,
    reserve: Pass<GridReservePush>,
    fill: Pass<GridFillPush>,
    gather: Pass<GatherGridPush>,
}

impl HashGrid {
    /// Compiles the passes and allocates the grid for as many photons as a batch may record.
    ///
    /// # Errors
    /// Out of memory, or the driver refuses a kernel.
    pub fn new(
        device: &Device,
        buffers: &Buffers,
        specialization: &Specialization,
        workgroup_size: u32,
    ) -> goblet_host::Result<Self> {
        let Buffers { photons, visible_points, visible_radii2, max_radius2, .. } = buffers;
        let Buffers { flux_red, flux_green, flux_blue, flux_counts, counters, .. } = buffers;
        let cells = device.buffer("cells", photons.len().next_power_of_two())?;
        let grid_filled = device.buffer("grid_filled", 1)?;
        let grid_photons = &device.texels("grid_photons", photons.len())?;
        let places = &device.buffer::<GridPlace>("places", buffers.most_by_tile / u64::from(POINTS))?;
        macro_rules! pass {
            ($($kernel:tt)*) => { device.pass(&$($kernel)*, specialization, workgroup_size)? };
        }
        Ok(Self {
            count: pass!(GridCount { photons, max_radius2, cells: &cells }),
            reserve: pass!(GridReserve { grid_filled: &grid_filled, cells: &cells }),
            fill: pass!(GridFill { photons, max_radius2, cells: &cells, grid_photons }),
            gather: pass!(GatherGrid {
                visible_points,
                visible_radii2,
                max_radius2,
                cells: &cells,
                grid_photons,
                counters,
                places,
                flux_red,
                flux_green,
                flux_blue,
                flux_counts
            }),
            filled: grid_filled,
            cells,
        })
    }

    /// Runs the passes once over nothing, since drivers may leave compilation to the first
    /// dispatch.
    pub fn warm_up(&self, frame: &mut Frame<'_>) {
        frame.dispatch(&self.count, Zeroable::zeroed(), 1);
        frame.dispatch(&self.reserve, Zeroable::zeroed(), 1);
        frame.dispatch(&self.fill, Zeroable::zeroed(), 1);
        frame.dispatch(&self.gather, Zeroable::zeroed(), 1);
    }

    /// Indexes `recorded` photons, and adds them to the points that they reach.
    ///
    /// # Errors
    /// The device fails, or the driver ends the pass early.
    pub fn gather(&self, on: Stage<'_>, recorded: u32, pace: &mut Pace) -> Result<Tally, RenderError> {
        // No more cells than photons: the others would be empty.
        let cell_count = u64::from(recorded).next_power_of_two().min(self.cells.len()) as u32;
        let cell_mask = cell_count - 1;
        let mut frame = on.device.frame()?;
        frame.clear(&self.filled);
        frame.clear_first(&self.cells, cell_count.into());
        frame.dispatch(&self.count, GridCountPush { recorded, cell_mask }, recorded.into());
        frame.dispatch(&self.reserve, GridReservePush { cell_count }, cell_count.into());
        frame.dispatch(&self.fill, GridFillPush { recorded, cell_mask }, recorded.into());
        frame.run()?;

        let [width, height] = on.settings.resolution;
        let push = |offset, resumed| GatherGridPush { width, height, cell_mask, resumed, offset, two: 2 };
        deposit(on, ("gather_grid", &self.gather), invocations_by_tile([width, height]) / u64::from(POINTS), pace, push)
    }
}
