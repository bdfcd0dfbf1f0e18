//! One iteration of progressive photon mapping (Hachisuka and others 2008, Hachisuka and
//! Jensen 2009, Knaus and Zwicker 2011), as the passes that the device runs in order.

use std::ops::Range;
use std::time::{Duration, Instant};

use bytemuck::Zeroable;
use goblet_host::{Device, Pass};

use crate::buffers::Buffers;
use crate::kernels::{
    Counters, Eye, EyePush, Photon, PhotonPush, Radius, RadiusPush, Specialization, Update, UpdatePush,
};
use crate::lookup::Lookup;
use crate::options::LookupKind;
use crate::radius::{FirstRadius, GlobalShrink, RadiusSchedule};
use crate::renderer::RenderError;
use crate::schedule::Schedule;
use crate::sequence::{Place, Sequence, Shard};
use crate::tally::Tally;
use crate::upload::GpuScene;

/// The passes, compiled for a scene and bound to its buffers.
pub struct Passes {
    eye: Pass<EyePush>,
    radius: Pass<RadiusPush>,
    lookup: Lookup,
    photon: Pass<PhotonPush>,
    update: Pass<UpdatePush>,
}

/// What an iteration needs to know.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// Pixels of the image.
    pub pixels: u64,
    /// Photons to emit.
    pub photons: u64,
    /// Share of an iteration's photons that a pixel keeps (Hachisuka 2008, eq. 5).
    pub alpha: f64,
    /// Who decides how radii shrink.
    pub radius_schedule: RadiusSchedule,
    /// Width of a pixel at distance 1.
    pub pixel_width: f64,
    /// The iterations.
    pub sequence: Sequence,
    /// Mean flux of a photon times the number of photons, W.
    pub mean_power: f64,
    /// Unit of the sums, W/(m² sr).
    pub unit: f64,
}

/// How far a render is.
#[derive(Clone, Debug)]
pub struct Progress {
    /// Iterations finished.
    pub done: u32,
    /// The radius that visible points start with, once it is known.
    pub first_radius: Option<FirstRadius>,
    /// The round whose visible points are on the device.
    pub seen: Option<u32>,
    /// How much the global schedule has shrunk squared radii.
    pub shrink: GlobalShrink,
    /// How the next iteration's photons are cut into batches.
    pub schedule: Schedule,
    /// What happened so far.
    pub tally: Tally,
}

/// Whether no invocation was ended early.
pub fn finished(counters: &Counters, pass: &'static str, remedy: &'static str) -> Result<(), RenderError> {
    if counters.interrupted == 0 { Ok(()) } else { Err(RenderError::Interrupted { pass, remedy }) }
}

impl Passes {
    /// Runs the next iteration.
    ///
    /// # Errors
    /// The device fails, or the driver cannot finish a pass.
    pub fn run(
        &mut self,
        device: &Device,
        buffers: &Buffers,
        settings: &Settings,
        progress: &mut Progress,
    ) -> Result<(), RenderError> {
        let place = settings.sequence.place(progress.done);
        let first_radius = self.first_radius(device, buffers, settings, progress)?;
        let new_points = progress.seen != Some(place.round);
        if new_points {
            let counters = self.look(device, buffers, settings, place)?;
            if place.step == 0 {
                progress.tally.add(&counters);
            }
            progress.seen = Some(place.round);
        }
        self.shrink(device, buffers, settings, progress, place, &first_radius)?;
        self.lookup.build(device, buffers, new_points)?;

        let mut first = 0;
        while first < settings.photons {
            let end = progress.schedule.end(first, settings.photons);
            let start = Instant::now();
            let recorded = self.trace(device, buffers, settings, progress, place, first..end)?;
            let per_invocation = progress.schedule.per_invocation();
            let deposited = self.lookup.accumulate(device, buffers, recorded, per_invocation)?;
            progress.tally.merge(&deposited);
            progress.schedule.observe(end - first, start.elapsed());
            first = end;
        }
        self.update(device, buffers, settings, progress, place)?;
        progress.done += 1;
        Ok(())
    }

    /// Finds the visible points of a round.
    fn look(
        &self,
        device: &Device,
        buffers: &Buffers,
        settings: &Settings,
        place: Place,
    ) -> Result<Counters, RenderError> {
        let Place { turn, half: half_of_rounds, .. } = place;
        let mut frame = device.frame()?;
        frame.clear(&buffers.counters);
        frame.dispatch(
            &self.eye,
            EyePush { turn, half_of_rounds, pixel_count: settings.pixels as u32, two: 2 },
            settings.pixels,
        );
        frame.run()?;
        let counters = device.read(&buffers.counters)?[0];
        finished(&counters, "eye", "a smaller maximum depth")?;
        Ok(counters)
    }

    /// The radius that visible points start with. Where nobody has said, the first of all
    /// rounds decides, so that every shard has the same.
    fn first_radius(
        &self,
        device: &Device,
        buffers: &Buffers,
        settings: &Settings,
        progress: &mut Progress,
    ) -> Result<FirstRadius, RenderError> {
        if let Some(known) = progress.first_radius {
            return Ok(known);
        }
        let whole = Sequence { shard: Shard::WHOLE, ..settings.sequence };
        self.look(device, buffers, settings, whole.place(0))?;
        let lengths = device.read(&buffers.visible_throughputs)?.into_iter().map(|throughput| throughput[3]);
        let radius = FirstRadius::from_footprints(settings.pixel_width, lengths);
        progress.first_radius = Some(radius);
        Ok(radius)
    }

    /// Gives visible points their radius for this iteration.
    fn shrink(
        &self,
        device: &Device,
        buffers: &Buffers,
        settings: &Settings,
        progress: &mut Progress,
        place: Place,
        first_radius: &FirstRadius,
    ) -> Result<(), RenderError> {
        let rounds_are_long = settings.sequence.round_length > 1;
        let step = if rounds_are_long { u64::from(place.step) } else { place.iteration };
        let shrink = match settings.radius_schedule {
            RadiusSchedule::Adaptive => 1.0,
            RadiusSchedule::Global => progress.shrink.at(step),
        };
        // Statistics are of one round's visible points, or of all rounds alike.
        let begins = progress.done == 0 || (rounds_are_long && place.step == 0);
        let push = first_radius.push(settings.pixels as u32, shrink, begins);
        let mut frame = device.frame()?;
        frame.clear(&buffers.grid_info);
        frame.dispatch(&self.radius, push, settings.pixels);
        frame.run()?;
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
        place: Place,
        batch: Range<u64>,
    ) -> Result<u32, RenderError> {
        let before = place.iteration_of_half.wrapping_mul(settings.photons);
        loop {
            let stride = (batch.end - batch.start).div_ceil(progress.schedule.per_invocation());
            let push = PhotonPush {
                before_low: before as u32,
                before_high: (before >> 32) as u32,
                half_of_rounds: place.half,
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

    /// Adds the iteration to the image.
    fn update(
        &self,
        device: &Device,
        buffers: &Buffers,
        settings: &Settings,
        progress: &mut Progress,
        place: Place,
    ) -> Result<(), RenderError> {
        let alpha = match settings.radius_schedule {
            RadiusSchedule::Adaptive => settings.alpha,
            RadiusSchedule::Global => 1.0,
        };
        let flux_scale = settings.mean_power / (settings.photons as f64 * std::f64::consts::PI * settings.unit);
        let push = UpdatePush {
            pixel_count: settings.pixels as u32,
            alpha: alpha as f32,
            per_unit: (1.0 / settings.unit) as f32,
            flux_scale: flux_scale as f32,
            half_of_rounds: place.half,
        };
        let mut frame = device.frame()?;
        frame.clear(&buffers.counters);
        frame.dispatch(&self.update, push, settings.pixels);
        frame.run()?;
        progress.tally.add(&device.read(&buffers.counters)?[0]);
        Ok(())
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
        lookup: LookupKind,
        specialization: &Specialization,
        workgroup_size: u32,
    ) -> goblet_host::Result<Self> {
        let scene = scene.bindings();
        let Buffers { camera, counters, grid_info, pixel_states, .. } = buffers;
        let Buffers { visible_positions, visible_normals, visible_throughputs, visible_radiances, .. } = buffers;
        let Buffers { photon_positions, photon_weights, flux_low, flux_high, .. } = buffers;
        let Buffers { sum_red, sum_green, sum_blue, sum_second, .. } = buffers;
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
                visible_radiances,
                counters
            }),
            radius: pass!(Radius { visible_positions, visible_throughputs, pixel_states, grid_info }),
            lookup: Lookup::new(device, buffers, lookup, specialization, workgroup_size)?,
            photon: pass!(Photon { scene, photon_positions, photon_weights, counters }),
            update: pass!(Update {
                visible_positions,
                visible_throughputs,
                visible_radiances,
                flux_low,
                flux_high,
                pixel_states,
                sum_red,
                sum_green,
                sum_blue,
                sum_second,
                counters
            }),
        };
        passes.warm_up(device)?;
        Ok(passes)
    }

    /// Time that the host, rather than the device, has spent on indices of visible points.
    pub fn index_host_time(&self) -> Duration {
        self.lookup.host_time()
    }

    fn warm_up(&self, device: &Device) -> goblet_host::Result<()> {
        let mut frame = device.frame()?;
        frame.dispatch(&self.eye, Zeroable::zeroed(), 1);
        frame.dispatch(&self.radius, Zeroable::zeroed(), 1);
        self.lookup.warm_up(&mut frame);
        frame.dispatch(&self.photon, Zeroable::zeroed(), 1);
        frame.dispatch(&self.update, Zeroable::zeroed(), 1);
        frame.run()
    }
}
