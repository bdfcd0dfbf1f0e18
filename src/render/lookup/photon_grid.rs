//! The hash grid over photons: its arrays, and the passes that sort photons into cells.

use std::mem::offset_of;

use bytemuck::Zeroable;
use goblet_host::{Buffer, Device, Frame, Pass, Texels};

use crate::kernels::{
    Cell, GridCount, GridExtent, GridFill, GridReserve, GridSize, GridSizePush, PhotonRecord, Specialization,
};
use crate::render::buffers::{Buffers, Sizes, device_arrays};

device_arrays! {
    /// The grid's arrays, for the largest number of photons that a batch may record.
    pub struct PhotonGridArrays(sizes) {
        cells: Buffer<Cell>[sizes.recorded.next_power_of_two()],
        grid_extent: Buffer<GridExtent>[1_u32],
        grid_filled: Buffer<u32>[1_u32],
        grid_photons: Texels<PhotonRecord>[sizes.recorded],
    }
}

/// A hash grid over photons, and the passes that build it.
pub struct PhotonGrid {
    pub(super) arrays: PhotonGridArrays,
    size: Pass<GridSizePush>,
    count: Pass<()>,
    reserve: Pass<()>,
    fill: Pass<()>,
}

impl PhotonGrid {
    /// The number of kernels.
    pub const KERNELS: u32 = 4;

    /// Compiles the passes and allocates the grid, for photons that are gathered on discs of up to a radius.
    ///
    /// # Errors
    /// The device has too little memory, or the driver refuses a kernel.
    pub fn new(
        device: &Device,
        (photons, max_radius2): (&Texels<PhotonRecord>, &Buffer<u32>),
        (buffers, sizes): (&Buffers, &Sizes),
        specialization: &Specialization,
        workgroup_size: u32,
    ) -> goblet_host::Result<Self> {
        let counters = &buffers.counters;
        let arrays = PhotonGridArrays::allocate(device, sizes)?;
        let PhotonGridArrays { cells, grid_extent, grid_filled, grid_photons } = &arrays;
        macro_rules! pass {
            ($($kernel:tt)*) => { device.pass(&$($kernel)*, specialization, workgroup_size)? };
        }
        Ok(Self {
            size: pass!(GridSize { counters, grid_extent, max_radius2 }),
            count: pass!(GridCount { photons, max_radius2, grid_extent, cells }),
            reserve: pass!(GridReserve { grid_filled, cells, grid_extent }),
            fill: pass!(GridFill { photons, max_radius2, grid_extent, cells, grid_photons }),
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
    }

    /// Records the commands that sort the photons of a batch into cells. The device has counted the photons;
    /// `most` is a bound of their number.
    pub fn record_build(&self, push: GridSizePush, most: u64, frame: &mut Frame<'_>) {
        let PhotonGridArrays { cells, grid_extent, grid_filled, .. } = &self.arrays;
        frame.clear(grid_filled);
        frame.clear_first(cells, most.next_power_of_two().min(cells.len()));
        frame.dispatch(&self.size, push, 1);
        frame.dispatch_indirect(&self.count, (), grid_extent, offset_of!(GridExtent, by_photon));
        frame.dispatch_indirect(&self.reserve, (), grid_extent, offset_of!(GridExtent, by_cell));
        frame.dispatch_indirect(&self.fill, (), grid_extent, offset_of!(GridExtent, by_photon));
    }
}
