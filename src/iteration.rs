//! One iteration of stochastic progressive photon mapping (Hachisuka and Jensen 2009),
//! as the passes that the device runs in order.

use std::ops::Range;
use std::time::Instant;

use bytemuck::Zeroable;
use goblet_host::{Device, Pass};

use crate::buffers::{Buffers, Sizes};
use crate::kernels::{
    Accumulate, AccumulatePush, Counters, Eye, EyePush, GridCount, GridCountPush, GridFill, GridFillPush, GridReserve,
    GridReservePush, Photon, PhotonPush, Resolve, ResolvePush, Specialization, Update, UpdatePush,
};
use crate::renderer::RenderError;
use crate::schedule::Schedule;
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

/// How far a render is.
#[derive(Clone, Debug)]
pub struct Progress {
    /// Iterations finished.
    pub iteration: u32,
    /// How the next one's photons are cut into batches.
    pub schedule: Schedule,
    /// What happened so far.
    pub tally: Tally,
}

/// Visible points of the fullest cell times photons of an invocation, at most.
const MAX_CANDIDATES: u32 = 1 << 13;

/// Whether no invocation was ended early.
fn finished(counters: &Counters, pass: &'static str, remedy: &'static str) -> Result<(), RenderError> {
    if counters.interrupted == 0 { Ok(()) } else { Err(RenderError::Interrupted { pass, remedy }) }
}

impl Passes {
    /// Runs the next iteration.
    ///
    /// # Errors
    /// The device fails, or the driver cannot finish a pass.
    pub fn run(
        &self,
        device: &Device,
        buffers: &Buffers,
        settings: &Settings,
        progress: &mut Progress,
    ) -> Result<(), RenderError> {
        let pixels = settings.sizes.pixels;
        let pixel_count = pixels as u32;
        let cell_mask = settings.sizes.cells as u32 - 1;
        let mut frame = device.frame()?;
        frame.clear(&buffers.counters);
        frame.clear(&buffers.grid_info);
        frame.clear(&buffers.cells);
        frame.dispatch(&self.eye, EyePush { iteration: progress.iteration, pixel_count, two: 2 }, pixels);
        frame.dispatch(&self.grid_count, GridCountPush { pixel_count, cell_mask }, pixels);
        frame.dispatch(&self.grid_reserve, GridReservePush { cell_count: cell_mask + 1 }, settings.sizes.cells);
        frame.dispatch(&self.grid_fill, GridFillPush { pixel_count, cell_mask }, pixels);
        frame.run()?;
        let counters = device.read(&buffers.counters)?[0];
        finished(&counters, "eye", "a smaller maximum depth")?;
        progress.tally.add(&counters);
        let fullest_cell = device.read(&buffers.grid_info)?[0].most;

        let mut first = 0;
        while first < settings.photons {
            let end = progress.schedule.end(first, settings.photons);
            let start = Instant::now();
            let recorded = self.trace(device, buffers, settings, progress, first..end)?;
            let mut frame = device.frame()?;
            frame.clear(&buffers.counters);
            // Loops are counted, as in `trace`; a photon may meet all points of eight cells.
            let per_invocation =
                (MAX_CANDIDATES / fullest_cell.max(1)).clamp(1, progress.schedule.per_invocation() as u32);
            let stride = recorded.div_ceil(per_invocation);
            let push = AccumulatePush { recorded, stride, cell_mask, two: 2 };
            frame.dispatch(&self.accumulate, push, stride.into());
            if end == settings.photons {
                frame.dispatch(&self.update, UpdatePush { pixel_count, alpha: settings.alpha }, pixels);
            }
            frame.run()?;
            let counters = device.read(&buffers.counters)?[0];
            finished(&counters, "accumulate", "a smaller radius")?;
            progress.tally.add(&counters);
            progress.schedule.observe(end - first, start.elapsed());
            first = end;
        }
        progress.iteration += 1;
        Ok(())
    }

    /// Traces some of an iteration's photons; how many records they left. Where the driver
    /// ends invocations early, their photons are traced again, fewer by each.
    fn trace(
        &self,
        device: &Device,
        buffers: &Buffers,
        settings: &Settings,
        progress: &mut Progress,
        batch: Range<u64>,
    ) -> Result<u32, RenderError> {
        let before = u64::from(progress.iteration) * settings.photons;
        loop {
            let stride = (batch.end - batch.start).div_ceil(progress.schedule.per_invocation());
            let push = PhotonPush {
                before_low: before as u32,
                before_high: (before >> 32) as u32,
                first: batch.start as u32,
                end: batch.end as u32,
                stride: stride as u32,
                two: 2,
            };
            let mut frame = device.frame()?;
            frame.clear(&buffers.counters);
            frame.dispatch(&self.photon, push, stride);
            frame.run()?;
            let counters = device.read(&buffers.counters)?[0];
            let all = finished(&counters, "photon", "a smaller maximum depth");
            if all.is_ok() || !progress.schedule.interrupted() {
                progress.tally.add(&counters);
                return all.map(|()| counters.recorded);
            }
        }
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
