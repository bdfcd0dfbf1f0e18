//! The hash grid over photons.

use bytemuck::Zeroable;
use goblet_host::{Buffer, Device, Frame, Pass};

use super::deposit::{deposit, of_caustics};
use super::photon_grid::{PhotonGrid, PhotonGridArrays};
use crate::kernels::{GatherGrid, GatherGridPush, GridPlace, GridSizePush, POINTS, Specialization};
use crate::render::buffers::{Buffers, Sizes, device_arrays, invocations_by_tile};
use crate::render::counters::Tally;
use crate::render::error::RenderError;
use crate::render::layers::CausticFlux;
use crate::render::pacing::Pace;
use crate::render::stage::Stage;

device_arrays! {
    /// The arrays of the gather pass.
    pub struct GatherArrays(sizes) {
        places: Buffer<GridPlace>[sizes.by_tile / u64::from(POINTS)],
    }
}

/// A hash grid, and the passes that use it.
pub struct HashGrid {
    photons: PhotonGrid,
    gather: Pass<GatherGridPush>,
    /// The same for photons of caustics alone.
    gather_caustics: Option<Pass<GatherGridPush>>,
}

impl HashGrid {
    /// Returns the bytes of the arrays, without allocating them.
    pub fn bytes(sizes: &Sizes) -> u64 {
        PhotonGridArrays::bytes(sizes) + GatherArrays::bytes(sizes)
    }

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
        let GatherArrays { places } = &GatherArrays::allocate(device, sizes)?;
        let grid = PhotonGrid::new(device, (photons, max_radius2), (buffers, sizes), specialization, workgroup_size)?;
        let PhotonGridArrays { cells, grid_extent, grid_photons, .. } = &grid.arrays;
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
            gather: gather([flux_red, flux_green, flux_blue, flux_counts], specialization)?,
            gather_caustics: caustics
                .map(|caustics| gather(caustics.each_ref(), &of_caustics(specialization)))
                .transpose()?,
            photons: grid,
        })
    }

    /// Runs each pass once without work, because a driver may compile a kernel at its first dispatch.
    pub fn warm_up(&self, frame: &mut Frame<'_>) {
        self.photons.warm_up(frame);
        self.gathers().for_each(|gather| frame.dispatch(gather, Zeroable::zeroed(), 1));
    }

    /// Records the commands that sort the photons of a batch into cells. The device has counted the photons;
    /// `most` is a bound of their number.
    pub fn record_build(&self, on: Stage<'_>, most: u64, frame: &mut Frame<'_>) {
        // Only photons on rough surfaces are sorted by a radius that the host knows.
        let push = GridSizePush { capacity: on.buffers.photons.len() as u32, radius2: 0.0 };
        self.photons.record_build(push, most, frame);
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
