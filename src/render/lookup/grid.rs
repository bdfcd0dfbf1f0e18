//! The hash grid over photons.

use std::mem::offset_of;

use bytemuck::Zeroable;
use goblet_host::{Buffer, Device, Frame, Pass};

use super::deposit::{deposit, of_caustics};
use crate::kernels::{
    Cell, GatherGrid, GatherGridPush, GridCount, GridExtent, GridFill, GridPlace, GridReserve, GridSize, GridSizePush,
    POINTS, PhotonRecord, Specialization,
};
use crate::render::buffers::{Buffers, Sizes, device_arrays, invocations_by_tile};
use crate::render::counters::Tally;
use crate::render::error::RenderError;
use crate::render::layers::CausticFlux;
use crate::render::pacing::Pace;
use crate::render::stage::Stage;

device_arrays! {
    /// The grid's arrays, for the largest number of photons that a batch may record.
    pub struct GridArrays(sizes) {
        cells: Buffer<Cell>[sizes.recorded.next_power_of_two()],
        grid_extent: Buffer<GridExtent>[1_u32],
        grid_filled: Buffer<u32>[1_u32],
        grid_photons: Texels<PhotonRecord>[sizes.recorded],
        places: Buffer<GridPlace>[sizes.by_tile / u64::from(POINTS)],
    }
}

/// A hash grid, and the passes that build and use it.
pub struct HashGrid {
    arrays: GridArrays,
    size: Pass<GridSizePush>,
    count: Pass<()>,
    reserve: Pass<()>,
    fill: Pass<()>,
    gather: Pass<GatherGridPush>,
    /// The same for photons of caustics alone.
    gather_caustics: Option<Pass<GatherGridPush>>,
}

impl HashGrid {
    /// Compiles the passes and allocates the grid.
    ///
    /// # Errors
    /// The device has too little memory, or the driver refuses a kernel.
    pub fn new(
        device: &Device,
        (buffers, caustics): (&Buffers, Option<&CausticFlux>),
        sizes: &Sizes,
        specialization: &Specialization,
        workgroup_size: u32,
    ) -> goblet_host::Result<Self> {
        let Buffers { photons, visible_points, visible_radii2, max_radius2, .. } = buffers;
        let Buffers { flux_red, flux_green, flux_blue, flux_counts, counters, .. } = buffers;
        let arrays = GridArrays::allocate(device, sizes)?;
        let GridArrays { cells, grid_extent, grid_filled, grid_photons, places } = &arrays;
        macro_rules! pass {
            ($($kernel:tt)*) => { device.pass(&$($kernel)*, specialization, workgroup_size)? };
        }
        let gather = |[flux_red, flux_green, flux_blue, flux_counts]: [&Buffer<u32>; 4],
                      specialization: &Specialization| {
            let kernel = GatherGrid {
                visible_points,
                visible_radii2,
                max_radius2,
                grid_extent,
                cells,
                grid_photons,
                counters,
                places,
                flux_red,
                flux_green,
                flux_blue,
                flux_counts,
            };
            device.pass(&kernel, specialization, workgroup_size)
        };
        Ok(Self {
            size: pass!(GridSize { counters, grid_extent }),
            count: pass!(GridCount { photons, max_radius2, grid_extent, cells }),
            reserve: pass!(GridReserve { grid_filled, cells, grid_extent }),
            fill: pass!(GridFill { photons, max_radius2, grid_extent, cells, grid_photons }),
            gather: gather([flux_red, flux_green, flux_blue, flux_counts], specialization)?,
            gather_caustics: caustics
                .map(|caustics| gather(caustics.each_ref(), &of_caustics(specialization)))
                .transpose()?,
            arrays,
        })
    }

    /// Runs each pass once without work, because a driver may compile a kernel at its first dispatch.
    pub fn warm_up(&self, frame: &mut Frame<'_>) {
        // No photon has room, so that the grid is empty.
        frame.dispatch(&self.size, Zeroable::zeroed(), 1);
        frame.dispatch(&self.count, (), 1);
        frame.dispatch(&self.reserve, (), 1);
        frame.dispatch(&self.fill, (), 1);
        self.gathers().for_each(|gather| frame.dispatch(gather, Zeroable::zeroed(), 1));
    }

    /// Records the commands that sort the photons of a batch into cells. The device has counted the photons;
    /// `most` is a bound of their number.
    pub fn record_build(&self, on: Stage<'_>, most: u64, frame: &mut Frame<'_>) {
        let GridArrays { cells, grid_extent, grid_filled, .. } = &self.arrays;
        frame.clear(grid_filled);
        frame.clear_first(cells, most.next_power_of_two().min(cells.len()));
        frame.dispatch(&self.size, GridSizePush { capacity: on.buffers.photons.len() as u32 }, 1);
        frame.dispatch_indirect(&self.count, (), grid_extent, offset_of!(GridExtent, by_photon));
        frame.dispatch_indirect(&self.reserve, (), grid_extent, offset_of!(GridExtent, by_cell));
        frame.dispatch_indirect(&self.fill, (), grid_extent, offset_of!(GridExtent, by_photon));
    }

    /// Sorts the `recorded` photons of a batch into cells. The counters must be those of the photon pass.
    ///
    /// # Errors
    /// The device fails.
    pub fn build(&self, on: Stage<'_>, recorded: u32) -> Result<(), RenderError> {
        let mut frame = on.device.frame()?;
        self.record_build(on, recorded.into(), &mut frame);
        Ok(frame.run()?)
    }

    /// Adds the photons in the grid to the visible points on whose discs they lie.
    ///
    /// # Errors
    /// The device fails, the driver ends the pass early, or the caller gives the iteration up.
    pub fn gather(&self, on: Stage<'_>, pace: &mut Pace) -> Result<Tally, RenderError> {
        let push = |offset, resumed| Self::push(on, offset, resumed);
        let mut tally = Tally::default();
        for gather in self.gathers() {
            tally.merge(&deposit(on, ("gather_grid", gather), Self::invocations(on), pace, push)?);
        }
        Ok(tally)
    }

    /// The pass that gathers all photons, and the one that gathers those of caustics.
    fn gathers(&self) -> impl Iterator<Item = &Pass<GatherGridPush>> {
        [&self.gather].into_iter().chain(&self.gather_caustics)
    }

    /// Records the commands that do the same in one dispatch each; the counters tell whether it has finished.
    pub fn record_gather(&self, on: Stage<'_>, frame: &mut Frame<'_>) {
        self.gathers().for_each(|gather| frame.dispatch(gather, Self::push(on, 0, 0), Self::invocations(on)));
    }

    fn push(on: Stage<'_>, offset: u32, resumed: u32) -> GatherGridPush {
        let [width, height] = on.settings.resolution;
        GatherGridPush { width, height, resumed, offset }
    }

    fn invocations(on: Stage<'_>) -> u64 {
        invocations_by_tile(on.settings.resolution) / u64::from(POINTS)
    }
}
