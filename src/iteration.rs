//! One iteration of stochastic progressive photon mapping (Hachisuka and Jensen 2009),
//! as the passes that the device runs in order.

use std::ops::Range;
use std::time::Instant;

use bytemuck::Zeroable;
use goblet_host::{Device, DeviceKind, Frame, Pass};

use crate::buffers::{Buffers, Sizes};
use crate::kernels::{
    Accumulate, AccumulatePush, Eye, EyePush, GridCount, GridCountPush, GridFill, GridFillPush, GridReserve,
    GridReservePush, Photon, PhotonPush, Resolve, ResolvePush, Specialization, Update, UpdatePush,
};
use crate::schedule::BatchSize;
use crate::tally::Tally;
use crate::upload::GpuScene;

/// The passes, compiled for a scene and bound to its buffers.
pub struct Passes {
    eye: Pass<EyePush>,
    grid_count: Pass<GridCountPush>,
    grid_reserve: Pass<GridReservePush>,
    grid_fill: Pass<GridFillPush>,
    photon: Pass<PhotonPush>,
    accumulate: Pass<AccumulatePush>,
    update: Pass<UpdatePush>,
    resolve: Pass<ResolvePush>,
}

/// What an iteration needs to know.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// Photons to emit.
    pub photons: u64,
    /// Share of an iteration's photons that a pixel keeps (Hachisuka 2008, eq. 5).
    pub alpha: f32,
    /// Sizes of the buffers.
    pub sizes: Sizes,
}

impl Passes {
    /// Runs iteration number `iteration`, from 0, and adds what happened to `tally`.
    ///
    /// # Errors
    /// The device fails.
    pub fn run(
        &self,
        device: &Device,
        buffers: &Buffers,
        settings: &Settings,
        batch_size: &mut BatchSize,
        iteration: u32,
        tally: &mut Tally,
    ) -> goblet_host::Result<()> {
        let pixels = settings.sizes.pixels;
        let pixel_count = pixels as u32;
        let cell_mask = settings.sizes.cells as u32 - 1;
        let mut frame = device.frame()?;
        frame.clear(&buffers.counters);
        frame.clear(&buffers.grid_info);
        frame.clear(&buffers.cells);
        frame.dispatch(&self.eye, EyePush { iteration, pixel_count }, pixels);
        frame.dispatch(&self.grid_count, GridCountPush { pixel_count, cell_mask }, pixels);
        frame.dispatch(&self.grid_reserve, GridReservePush { cell_count: cell_mask + 1 }, settings.sizes.cells);
        frame.dispatch(&self.grid_fill, GridFillPush { pixel_count, cell_mask }, pixels);
        frame.run()?;

        let mut first = 0;
        while first < settings.photons {
            let end = batch_size.end(first, settings.photons);
            let start = Instant::now();
            let mut frame = device.frame()?;
            if first > 0 {
                frame.clear(&buffers.counters);
            }
            self.photon_batch(&mut frame, device, settings, iteration, first..end);
            if end == settings.photons {
                frame.dispatch(&self.update, UpdatePush { pixel_count, alpha: settings.alpha }, pixels);
            }
            frame.run()?;
            batch_size.observe(end - first, start.elapsed());
            tally.add(&device.read(&buffers.counters)?[0]);
            first = end;
        }
        Ok(())
    }

    /// Traces some of an iteration's photons and adds them up.
    fn photon_batch(
        &self,
        frame: &mut Frame<'_>,
        device: &Device,
        settings: &Settings,
        iteration: u32,
        batch: Range<u64>,
    ) {
        // SIMD lanes of a CPU want many photons each, to start the next where a path ends;
        // a GPU wants many invocations.
        let per_invocation = if device.info().kind == DeviceKind::Cpu { 32 } else { 2 };
        let stride = (batch.end - batch.start).div_ceil(per_invocation);
        let before = u64::from(iteration) * settings.photons;
        let push = PhotonPush {
            before_low: before as u32,
            before_high: (before >> 32) as u32,
            first: batch.start as u32,
            end: batch.end as u32,
            stride: stride as u32,
        };
        frame.dispatch(&self.photon, push, stride);
        let push = AccumulatePush { stride: stride as u32, cell_mask: settings.sizes.cells as u32 - 1 };
        frame.dispatch(&self.accumulate, push, stride);
    }

    /// Writes the current estimate to `buffers.image`. `emitted` is the number of
    /// photons of all iterations so far, `mean_power` the power of all lights.
    ///
    /// # Errors
    /// The device fails.
    pub fn resolve(
        &self,
        device: &Device,
        pixels: u64,
        iterations: u32,
        emitted: u64,
        mean_power: f64,
    ) -> goblet_host::Result<()> {
        let push = ResolvePush {
            pixel_count: pixels as u32,
            direct_scale: (1.0 / f64::from(iterations)) as f32,
            flux_scale: (mean_power / (emitted as f64 * std::f64::consts::PI)) as f32,
        };
        let mut frame = device.frame()?;
        frame.dispatch(&self.resolve, push, pixels);
        frame.run()
    }

    /// Compiles the passes for a scene and runs each once over nothing, since drivers
    /// may leave compilation to the first dispatch.
    ///
    /// # Errors
    /// The driver refuses a kernel.
    pub fn new(
        device: &Device,
        scene: &GpuScene,
        buffers: &Buffers,
        specialization: &Specialization,
        workgroup_size: u32,
    ) -> goblet_host::Result<Self> {
        let scene = scene.bindings();
        let Buffers { camera, counters, grid_info, cells, grid_positions, grid_owners, .. } = buffers;
        let Buffers { visible_positions, visible_normals, visible_throughputs, .. } = buffers;
        let Buffers { photon_positions, photon_weights, flux_low, flux_high, .. } = buffers;
        let Buffers { pixel_flux, pixel_photons, pixel_direct, image, .. } = buffers;
        macro_rules! pass {
            ($($kernel:tt)*) => { device.pass(&$($kernel)*, specialization, workgroup_size)? };
        }
        let passes = Self {
            eye: pass!(Eye {
                scene,
                camera,
                visible_positions,
                visible_normals,
                visible_throughputs,
                pixel_flux,
                pixel_direct,
                grid_info,
                counters
            }),
            grid_count: pass!(GridCount { visible_positions, visible_throughputs, grid_info, cells }),
            grid_reserve: pass!(GridReserve { grid_info, cells }),
            grid_fill: pass!(GridFill {
                visible_positions,
                visible_normals,
                visible_throughputs,
                grid_info,
                cells,
                grid_positions,
                grid_owners
            }),
            photon: pass!(Photon { scene, photon_positions, photon_weights, counters }),
            accumulate: pass!(Accumulate {
                photon_positions,
                photon_weights,
                grid_info,
                cells,
                grid_positions,
                grid_owners,
                flux_low,
                flux_high,
                counters
            }),
            update: pass!(Update { visible_throughputs, flux_low, flux_high, pixel_flux, pixel_photons }),
            resolve: pass!(Resolve { pixel_flux, pixel_direct, image }),
        };
        passes.warm_up(device)?;
        Ok(passes)
    }

    fn warm_up(&self, device: &Device) -> goblet_host::Result<()> {
        let mut frame = device.frame()?;
        frame.dispatch(&self.eye, Zeroable::zeroed(), 1);
        frame.dispatch(&self.grid_count, Zeroable::zeroed(), 1);
        frame.dispatch(&self.grid_reserve, Zeroable::zeroed(), 1);
        frame.dispatch(&self.grid_fill, Zeroable::zeroed(), 1);
        frame.dispatch(&self.photon, Zeroable::zeroed(), 1);
        frame.dispatch(&self.accumulate, Zeroable::zeroed(), 1);
        frame.dispatch(&self.update, Zeroable::zeroed(), 1);
        frame.dispatch(&self.resolve, Zeroable::zeroed(), 1);
        frame.run()
    }
}
