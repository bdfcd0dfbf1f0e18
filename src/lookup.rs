//! How photons find the visible points that they reach: the passes that index the points,
//! and the pass that adds photons to them.

use bytemuck::Zeroable;
use goblet_host::{Buffer, Device, Frame, Pass};

use crate::buffers::Buffers;
use crate::iteration::finished;
use crate::kernels::{
    AccumulateGrid, AccumulateGridPush, Cell, GridCount, GridCountPush, GridFill, GridFillPush, GridPlace, GridReserve,
    GridReservePush, Specialization,
};
use crate::options::LookupKind;
use crate::renderer::RenderError;
use crate::tally::Tally;

/// Invocations of one dispatch that adds photons, at most: each has a place to go on from.
const MAX_INVOCATIONS: u32 = 1 << 18;

/// One way or the other; both give the same sums.
pub enum Lookup {
    /// A hash grid.
    Grid(HashGrid),
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
        match kind {
            LookupKind::HashGrid | LookupKind::KdTree => {
                HashGrid::new(device, buffers, specialization, workgroup_size).map(Self::Grid)
            }
        }
    }

    /// Runs the passes once over nothing, since drivers may leave compilation to the first
    /// dispatch.
    pub fn warm_up(&self, frame: &mut Frame<'_>) {
        match self {
            Self::Grid(grid) => grid.warm_up(frame),
        }
    }

    /// Indexes the visible points, which are `new` or have other radii only.
    ///
    /// # Errors
    /// The device fails.
    pub fn build(&mut self, device: &Device, buffers: &Buffers, new: bool) -> Result<(), RenderError> {
        match self {
            Self::Grid(grid) => grid.build(device, buffers),
        }
    }

    /// Adds `recorded` photons to the points that they reach, at most `per_invocation` by each.
    ///
    /// # Errors
    /// The device fails, or the driver ends the pass early.
    pub fn accumulate(
        &self,
        device: &Device,
        buffers: &Buffers,
        recorded: u32,
        per_invocation: u64,
    ) -> Result<Tally, RenderError> {
        match self {
            Self::Grid(grid) => grid.accumulate(device, buffers, recorded, per_invocation),
        }
    }
}

/// A hash grid, and the passes that build and use it.
pub struct HashGrid {
    cells: Buffer<Cell>,
    count: Pass<GridCountPush>,
    reserve: Pass<GridReservePush>,
    fill: Pass<GridFillPush>,
    accumulate: Pass<AccumulateGridPush>,
    places: Buffer<GridPlace>,
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
        let places = device.buffer("places", MAX_INVOCATIONS.into())?;
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
                places: &places
            }),
            cells,
            places,
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
    pub fn build(&mut self, device: &Device, buffers: &Buffers) -> Result<(), RenderError> {
        let pixels = buffers.visible_positions.len();
        let cells = self.cells.len();
        let (pixel_count, cell_count) = (pixels as u32, cells as u32);
        let mut frame = device.frame()?;
        frame.clear(&self.cells);
        frame.dispatch(&self.count, GridCountPush { pixel_count, cell_mask: cell_count - 1 }, pixels);
        frame.dispatch(&self.reserve, GridReservePush { cell_count }, cells);
        frame.dispatch(&self.fill, GridFillPush { pixel_count, cell_mask: cell_count - 1 }, pixels);
        frame.run()?;
        Ok(())
    }

    /// Adds `recorded` photons to the points that they reach, at most `per_invocation` by each.
    ///
    /// # Errors
    /// The device fails, or the driver ends the pass early.
    pub fn accumulate(
        &self,
        device: &Device,
        buffers: &Buffers,
        recorded: u32,
        per_invocation: u64,
    ) -> Result<Tally, RenderError> {
        let stride = recorded.div_ceil(per_invocation as u32).min(MAX_INVOCATIONS);
        let cell_mask = self.cells.len() as u32 - 1;
        let mut push = AccumulateGridPush { recorded, stride, cell_mask, resumed: 0, two: 2 };
        let mut total = Tally::default();
        loop {
            let mut frame = device.frame()?;
            frame.clear(&buffers.counters);
            frame.dispatch(&self.accumulate, push, stride.into());
            frame.run()?;
            let counters = device.read(&buffers.counters)?[0];
            finished(&counters, "accumulate_grid", "a smaller radius")?;
            total.add(&counters);
            if counters.unfinished == 0 {
                return Ok(total);
            }
            push.resumed = 1;
        }
    }
}
