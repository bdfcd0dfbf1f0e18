//! The hash grid over visible points.

use bytemuck::Zeroable;
use goblet_host::{Buffer, Device, Frame, Pass};

use super::{MAX_INVOCATIONS, deposit};
use crate::buffers::Buffers;
use crate::iteration::Stage;
use crate::kernels::{
    AccumulateGrid, AccumulateGridPush, Cell, GridCount, GridCountPush, GridFill, GridFillPush, GridPlace, GridReserve,
    GridReservePush, Specialization,
};
use crate::renderer::RenderError;
use crate::tally::Tally;

/// A hash grid, and the passes that build and use it.
pub struct HashGrid {
    cells: Buffer<Cell>,
    count: Pass<GridCountPush>,
    reserve: Pass<GridReservePush>,
    fill: Pass<GridFillPush>,
    accumulate: Pass<AccumulateGridPush>,
}

impl HashGrid {
    /// Compiles the passes and allocates the grid for as many points as there are pixels.
    ///
    /// # Errors
    /// Out of memory, or the driver refuses a kernel.
    pub fn new(
        device: &Device,
        buffers: &Buffers,
        specialization: &Specialization,
        workgroup_size: u32,
    ) -> goblet_host::Result<Self> {
        let pixels = buffers.visible_positions.len();
        let cells = device.buffer("cells", pixels.next_power_of_two())?;
        let grid_positions = &device.buffer("grid_positions", pixels)?;
        let grid_owners = &device.buffer("grid_owners", pixels)?;
        let Buffers { visible_positions, visible_normals, grid_info, counters, .. } = buffers;
        let Buffers { photon_positions, photon_weights, flux_low, flux_high, .. } = buffers;
        macro_rules! pass {
            ($($kernel:tt)*) => { device.pass(&$($kernel)*, specialization, workgroup_size)? };
        }
        let places = &device.buffer::<GridPlace>("places", MAX_INVOCATIONS.into())?;
        Ok(Self {
            count: pass!(GridCount { visible_positions, grid_info, cells: &cells }),
            reserve: pass!(GridReserve { grid_info, cells: &cells }),
            fill: pass!(GridFill {
                visible_positions,
                visible_normals,
                grid_info,
                cells: &cells,
                grid_positions,
                grid_owners
            }),
            accumulate: pass!(AccumulateGrid {
                photon_positions,
                photon_weights,
                grid_info,
                cells: &cells,
                grid_positions,
                grid_owners,
                flux_low,
                flux_high,
                counters,
                places
            }),
            cells,
        })
    }

    /// Runs the passes once over nothing, since drivers may leave compilation to the first
    /// dispatch.
    pub fn warm_up(&self, frame: &mut Frame<'_>) {
        frame.dispatch(&self.count, Zeroable::zeroed(), 1);
        frame.dispatch(&self.reserve, Zeroable::zeroed(), 1);
        frame.dispatch(&self.fill, Zeroable::zeroed(), 1);
        frame.dispatch(&self.accumulate, Zeroable::zeroed(), 1);
    }

    /// Indexes the visible points.
    ///
    /// # Errors
    /// The device fails.
    pub fn build(&self, on: Stage<'_>) -> Result<(), RenderError> {
        let pixels = on.buffers.visible_positions.len();
        let cells = self.cells.len();
        let (pixel_count, cell_count) = (pixels as u32, cells as u32);
        let mut frame = on.device.frame()?;
        frame.clear(&self.cells);
        frame.dispatch(&self.count, GridCountPush { pixel_count, cell_mask: cell_count - 1 }, pixels);
        frame.dispatch(&self.reserve, GridReservePush { cell_count }, cells);
        frame.dispatch(&self.fill, GridFillPush { pixel_count, cell_mask: cell_count - 1 }, pixels);
        frame.run()?;
        Ok(())
    }

    /// Adds `recorded` photons to the points that they reach, every `stride`-th by one
    /// invocation.
    ///
    /// # Errors
    /// The device fails, or the driver ends the pass early.
    pub fn accumulate(&self, on: Stage<'_>, recorded: u32, stride: u32) -> Result<Tally, RenderError> {
        let cell_mask = self.cells.len() as u32 - 1;
        let push = |resumed| AccumulateGridPush { recorded, stride, cell_mask, resumed, two: 2 };
        deposit(on, ("accumulate_grid", &self.accumulate), stride, push)
    }
}
