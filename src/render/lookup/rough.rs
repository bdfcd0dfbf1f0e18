//! The photons on rough surfaces: their grid, and the pass that gathers them at the rough points of eye paths
//! (`shaders/passes/gather_rough.comp`). It is used with both lookups, the hash grid and the kd-tree.

use bytemuck::Zeroable;
use goblet_host::{Device, Frame, Pass};

use super::deposit::deposit;
use super::photon_grid::{PhotonGrid, PhotonGridArrays};
use crate::kernels::{GatherRough, GatherRoughPush, GpuScene, GridSizePush, PassFeatures, RoughPlace, Specialization};
use crate::render::buffers::{Buffers, Sizes, device_arrays};
use crate::render::error::RenderError;
use crate::render::progress::Progress;
use crate::render::radius::RoughRadii;
use crate::render::stage::Stage;

device_arrays! {
    /// The arrays of the pass.
    pub struct RoughArrays(sizes) {
        /// The bits of the largest squared radius, which is an f32.
        rough_radius2: Buffer<u32>[1_u32],
        rough_places: Buffer<RoughPlace>[sizes.pixels],
    }
}

/// The grid over photons on rough surfaces, and the pass that gathers them.
pub struct RoughGather {
    grid: PhotonGrid,
    gather: Pass<GatherRoughPush>,
}

impl RoughGather {
    /// Compiles the passes and allocates the grid.
    ///
    /// # Errors
    /// The device has too little memory, or the driver refuses a kernel.
    pub fn new(
        device: &Device,
        scene: &GpuScene,
        (buffers, sizes): (&Buffers, &Sizes),
        specialization: &Specialization,
        workgroup_size: u32,
    ) -> goblet_host::Result<Self> {
        let Buffers { rough_points, rough_photons, counters, flux_red, flux_green, flux_blue, .. } = buffers;
        let RoughArrays { rough_radius2: max_radius2, rough_places: places } = &RoughArrays::allocate(device, sizes)?;
        let pass = PassFeatures { sorts_rough: true, ..specialization.pass };
        let sorting = Specialization { pass, ..*specialization };
        let grid = PhotonGrid::new(device, (rough_photons, max_radius2), (buffers, sizes), &sorting, workgroup_size)?;
        let PhotonGridArrays { cells, grid_extent, grid_photons, .. } = &grid.arrays;
        let scene = scene.bindings();
        let kernel = GatherRough {
            scene,
            rough_points,
            grid_extent,
            cells,
            grid_photons,
            counters,
            places,
            flux_red,
            flux_green,
            flux_blue,
        };
        Ok(Self { gather: device.pass(&kernel, specialization, workgroup_size)?, grid })
    }

    /// The number of kernels.
    pub const KERNELS: u32 = PhotonGrid::KERNELS + 1;

    /// Returns the bytes of the arrays, without allocating them.
    pub fn bytes(sizes: &Sizes) -> u64 {
        if sizes.gathers_rough { PhotonGridArrays::bytes(sizes) + RoughArrays::bytes(sizes) } else { 0 }
    }

    /// Runs each pass once without work, because a driver may compile a kernel at its first dispatch.
    pub fn warm_up(&self, frame: &mut Frame<'_>) {
        self.grid.warm_up(frame);
        frame.dispatch(&self.gather, Zeroable::zeroed(), 1);
    }

    /// Sorts the `recorded` photons of a batch into cells. The counters must be those of the photon pass.
    ///
    /// # Errors
    /// The device fails.
    pub fn build(&self, on: Stage<'_>, recorded: u32, radii: &RoughRadii) -> Result<(), RenderError> {
        let mut frame = on.device.frame()?;
        self.record_build(on, recorded.into(), radii, &mut frame);
        Ok(frame.run()?)
    }

    /// Records the commands that do so; `most` is a bound of the number of photons.
    pub fn record_build(&self, on: Stage<'_>, most: u64, radii: &RoughRadii, frame: &mut Frame<'_>) {
        let push = GridSizePush { capacity: on.buffers.photons.len() as u32, radius2: radii.largest2() as f32 };
        self.grid.record_build(push, most, frame);
    }

    /// Adds the photons in the grid to the rough points on whose discs they lie.
    ///
    /// # Errors
    /// The device fails, the driver ends the pass early, or the caller gives the iteration up.
    pub fn gather(&self, on: Stage<'_>, radii: &RoughRadii, progress: &mut Progress) -> Result<(), RenderError> {
        let push = |offset, resumed| Self::push(on, radii, offset, resumed);
        let pace = &mut progress.schedule.paces.rough;
        let gathered = deposit(on, ("gather_rough", &self.gather), on.settings.pixels(), pace, push)?;
        progress.tally.merge(&gathered);
        Ok(())
    }

    /// Records the commands that do so in one dispatch; the counters tell whether it has finished.
    pub fn record_gather(&self, on: Stage<'_>, radii: &RoughRadii, frame: &mut Frame<'_>) {
        frame.dispatch(&self.gather, Self::push(on, radii, 0, 0), on.settings.pixels());
    }

    fn push(on: Stage<'_>, radii: &RoughRadii, offset: u32, resumed: u32) -> GatherRoughPush {
        let [per_length, least, most, shrink] = radii.values();
        let (pixel_count, radius2) = (on.settings.pixels() as u32, radii.largest2() as f32);
        GatherRoughPush { pixel_count, resumed, offset, per_length, least, most, shrink, radius2 }
    }
}
