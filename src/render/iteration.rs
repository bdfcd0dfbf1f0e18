//! One iteration of progressive photon mapping (Hachisuka and others 2008, Hachisuka and
//! Jensen 2009, Knaus and Zwicker 2011), as the passes that the device runs in order.

use std::ops::Range;
use std::time::{Duration, Instant};

use bytemuck::{Pod, Zeroable};
use goblet_host::{Device, Frame, Pass};

use crate::image::film::{LUMINANCE, Window};
use crate::kernels::{Counters, EyePush, GpuScene, PhotonPush, Radius, RadiusPush, Specialization, Update, UpdatePush};
use crate::render::buffers::{Buffers, invocations_by_tile};
use crate::render::counters::{Counted, Tally};
use crate::render::lookup::Lookup;
use crate::render::options::{Contribution, LookupKind};
use crate::render::pacing::{Pace, Schedule};
use crate::render::path_pass::{PathKernels, PathPass, Start};
use crate::render::radius::{FirstRadius, GlobalShrink, RadiusSchedule};
use crate::render::renderer::RenderError;
use crate::render::sequence::{Place, Sequence, Shard};
use crate::render::unsampled::response;

/// The passes, compiled for a scene and bound to its buffers.
pub struct Passes {
    eye: PathPass<EyePush>,
    radius: Pass<RadiusPush>,
    lookup: Lookup,
    photon: PathPass<PhotonPush>,
    update: Pass<UpdatePush>,
    path_kernels: PathKernels,
}

/// What an iteration needs to know.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// Width and height of the image.
    pub resolution: [u32; 2],
    /// Where it lies in what the camera sees.
    pub window: Window,
    /// Photons to emit.
    pub photons: u64,
    /// Eye paths of a pixel.
    pub eye_paths: u32,
    /// Share of an iteration's photons that a pixel keeps (Hachisuka 2008, eq. 5).
    pub alpha: f64,
    /// Who decides how radii shrink.
    pub radius_schedule: RadiusSchedule,
    /// Width of a pixel at distance 1, or at any where rays are parallel; render units.
    pub pixel_width: f64,
    /// Rays of the camera are parallel.
    pub is_parallel: bool,
    /// Radius of a visible point at distance 1, where radii follow the footprints of pixels.
    pub radius_per_length: f64,
    /// The iterations.
    pub sequence: Sequence,
    /// Mean flux of a photon times the number of photons, W.
    pub mean_power: f64,
    /// Unit of the sums, W/(m² sr).
    pub unit: f64,
    /// Which light the image has.
    pub contribution: Contribution,
    /// Whether there is a light, and a surface for its photons to meet.
    pub has_photons: bool,
    /// Photons may bring light that eye paths do not.
    pub photons_matter: bool,
}

impl Settings {
    /// Photons to emit: none where they would bring nothing, or nobody wants to see it.
    pub fn wanted_photons(&self) -> u64 {
        if self.has_photons && self.contribution != Contribution::Direct { self.photons } else { 0 }
    }

    /// The first of all iterations, of whichever shard.
    fn first_place(&self) -> Place {
        Sequence { shard: Shard::WHOLE, ..self.sequence }.place(0)
    }

    /// Pixels of the image.
    pub fn pixels(&self) -> u64 {
        self.resolution.map(u64::from).iter().product()
    }
}

/// Where an iteration runs.
#[derive(Clone, Copy)]
pub struct Stage<'a> {
    /// The device.
    pub device: &'a Device,
    /// Its memory.
    pub buffers: &'a Buffers,
    /// The render.
    pub settings: &'a Settings,
    /// Asked between dispatches: whether the iteration is not wanted any more.
    pub gives_up: &'a dyn Fn() -> bool,
}

/// How far a render is.
#[derive(Clone, Debug)]
pub struct Progress {
    /// Iterations finished.
    pub done: u32,
    /// The same, by half: [`Place::half`].
    pub halves: [u64; 2],
    /// The radius that visible points start with, once it is known.
    pub first_radius: Option<FirstRadius>,
    /// Of the first of all rounds, once it is known: [`response`].
    pub response: Option<f64>,
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

impl Stage<'_> {
    /// Whether the caller still wants the iteration.
    ///
    /// # Errors
    /// It does not.
    pub fn may_go_on(&self) -> Result<(), RenderError> {
        if (self.gives_up)() { Err(RenderError::GivenUp) } else { Ok(()) }
    }

    /// Runs a pass, in as many dispatches as its pace asks for; what was counted meanwhile.
    /// `push` is told the first invocation of each.
    ///
    /// # Errors
    /// The device fails, or the caller gives the iteration up.
    pub fn run_paced<Push: Pod>(
        &self,
        pass: &Pass<Push>,
        invocations: u64,
        pace: &mut Pace,
        push: impl Fn(u32) -> Push,
    ) -> Result<Counters, RenderError> {
        let mut first = 0;
        while first < invocations {
            self.may_go_on()?;
            let count = pace.next(invocations - first);
            let start = Instant::now();
            let mut frame = self.device.frame()?;
            if first == 0 {
                frame.clear(&self.buffers.counters);
            }
            frame.dispatch(pass, push(first as u32), count);
            frame.run()?;
            pace.observe(count, start.elapsed());
            first += count;
        }
        Ok(self.device.read(&self.buffers.counters)?[0])
    }

    /// Runs what `record` records; what was counted meanwhile.
    ///
    /// # Errors
    /// The device fails.
    pub fn run_counted(&self, record: impl FnOnce(&mut Frame<'_>)) -> goblet_host::Result<Counters> {
        let mut frame = self.device.frame()?;
        frame.clear(&self.buffers.counters);
        record(&mut frame);
        frame.run()?;
        Ok(self.device.read(&self.buffers.counters)?[0])
    }
}

impl Progress {
    /// Learns from the visible points of the first of all rounds, which are on the device: the
    /// radius that follows the footprints of pixels, and how bright photons are there.
    fn measure(&mut self, on: Stage<'_>) -> Result<(), RenderError> {
        let Settings { pixel_width, is_parallel, radius_per_length, .. } = *on.settings;
        let throughputs = on.device.read_first_texels(&on.buffers.visible_throughputs, on.settings.pixels())?;
        let lengths = throughputs.iter().map(|throughput| throughput[3]);
        let radius = self.first_radius.get_or_insert_with(|| FirstRadius::from_footprints(radius_per_length, lengths));
        self.response = Some(response(throughputs.into_iter(), pixel_width, is_parallel, radius.least.into()));
        Ok(())
    }
}

impl Passes {
    /// Runs the next iteration.
    ///
    /// # Errors
    /// The device fails, or the driver cannot finish a pass.
    pub fn run(&mut self, on: Stage<'_>, progress: &mut Progress) -> Result<(), RenderError> {
        let settings = on.settings;
        let place = settings.sequence.place(progress.done);
        let new_points = progress.seen != Some(place.round);
        if new_points {
            self.look(on, place, progress)?;
        }
        self.shrink(on, place, progress)?;
        self.lookup.build(on, new_points)?;

        let photons = settings.wanted_photons();
        let mut first = 0;
        while first < photons {
            let end = progress.schedule.end(first, photons);
            let start = Instant::now();
            let Some(recorded) = self.trace(on, place, first..end, progress)? else {
                continue; // with a smaller batch
            };
            progress.schedule.observe(end - first, start.elapsed());
            let deposited = self.lookup.gather(on, recorded, &mut progress.schedule)?;
            progress.tally.merge(&deposited);
            first = end;
        }
        self.update(on, place, progress)?;
        progress.done += 1;
        progress.halves[place.half as usize] += 1;
        Ok(())
    }

    /// Finds the visible points of a round, and the radius that they start with. Where nobody
    /// has given one, the first of all rounds decides, so that every shard has the same.
    fn look(&mut self, on: Stage<'_>, place: Place, progress: &mut Progress) -> Result<(), RenderError> {
        let first = on.settings.first_place();
        if progress.first_radius.is_none() && place.round != first.round {
            self.measure(on, progress)?;
        }
        let seen = self.trace_eye_paths(on, place, &mut progress.schedule)?;
        if progress.response.is_none() && place.round == first.round {
            progress.measure(on)?;
        }
        if place.step == 0 {
            // Else they were counted before a checkpoint.
            progress.tally.merge(&seen);
        }
        progress.seen = Some(place.round);
        Ok(())
    }

    /// Traces the eye paths of the first of all rounds, which then are on the device, and learns
    /// from them.
    ///
    /// # Errors
    /// As [`Passes::run`].
    pub fn measure(&mut self, on: Stage<'_>, progress: &mut Progress) -> Result<(), RenderError> {
        progress.seen = None;
        self.trace_eye_paths(on, on.settings.first_place(), &mut progress.schedule)?;
        progress.measure(on)
    }

    /// Traces all eye paths of a round.
    fn trace_eye_paths(&mut self, on: Stage<'_>, place: Place, schedule: &mut Schedule) -> Result<Tally, RenderError> {
        let Place { turn, half: half_of_rounds, .. } = place;
        let paths = on.settings.eye_paths;
        let push = |Start { offset, resumed, spread }| EyePush {
            turn,
            half_of_rounds,
            paths,
            offset,
            resumed,
            spread,
            two: 2,
        };
        let invocations = invocations_by_tile(on.settings.resolution);
        let resumable = || self.path_kernels.eye(on.device, on.buffers, true)?.finish();
        let counters = self.eye.run(on, invocations, &mut schedule.paces.eye, resumable, push)?;
        let mut tally = Tally::default();
        tally.add(Counted::Eye, &counters);
        Ok(tally)
    }

    /// Gives visible points their radius for this iteration.
    fn shrink(&self, on: Stage<'_>, place: Place, progress: &mut Progress) -> Result<(), RenderError> {
        let Stage { device, buffers, settings, .. } = on;
        // `look` has found one.
        let first_radius = progress.first_radius.unwrap_or_else(|| FirstRadius::constant(1.0));
        let rounds_are_long = settings.sequence.round_length > 1;
        let step = if rounds_are_long { u64::from(place.step) } else { place.iteration };
        let shrink = match settings.radius_schedule {
            RadiusSchedule::Adaptive => 1.0,
            RadiusSchedule::Global => progress.shrink.at(step),
        };
        // Statistics are of one round's visible points, or of all rounds alike.
        let begins = progress.done == 0 || (rounds_are_long && place.step == 0);
        let push = first_radius.push(settings.pixels() as u32, shrink, begins);
        let mut frame = device.frame()?;
        frame.clear(&buffers.max_radius2);
        frame.dispatch(&self.radius, push, settings.pixels());
        frame.run()?;
        Ok(())
    }

    /// Traces some of an iteration's photons; how many records they left, or nothing if that
    /// was more than there is room for.
    fn trace(
        &mut self,
        on: Stage<'_>,
        place: Place,
        batch: Range<u64>,
        progress: &mut Progress,
    ) -> Result<Option<u32>, RenderError> {
        // A disc that found many photons is smaller in the next iteration, in which a sequence
        // that spreads its points evenly has fewer for it: the image would get darker. So the
        // iterations that share visible points and look back have a sequence each.
        let (stream, iterations_before) = match on.settings.radius_schedule {
            RadiusSchedule::Adaptive => (place.step, place.turn.into()),
            RadiusSchedule::Global => (0, place.iteration_of_half),
        };
        let before = on.settings.photons.wrapping_mul(iterations_before);
        let stride = (batch.end - batch.start).div_ceil(progress.schedule.per_invocation());
        let push = |Start { offset, resumed, spread }| PhotonPush {
            before_low: before as u32,
            before_high: (before >> 32) as u32,
            half_of_rounds: place.half,
            stream,
            first: batch.start as u32,
            end: batch.end as u32,
            stride: stride as u32,
            capacity: on.buffers.photons.len() as u32,
            offset,
            resumed,
            spread,
            two: 2,
        };
        let resumable = || self.path_kernels.photon(on.device, on.buffers, true)?.finish();
        let counters = self.photon.run(on, stride, &mut progress.schedule.paces.photon, resumable, push)?;
        if u64::from(counters.recorded) > on.buffers.photons.len() && progress.schedule.overflowed() {
            return Ok(None);
        }
        progress.tally.add(Counted::Photon, &counters);
        Ok(Some(counters.recorded))
    }

    /// Adds the iteration to the image.
    fn update(&self, on: Stage<'_>, place: Place, progress: &mut Progress) -> Result<(), RenderError> {
        let settings = on.settings;
        let alpha = match settings.radius_schedule {
            RadiusSchedule::Adaptive => settings.alpha,
            RadiusSchedule::Global => 1.0,
        };
        let flux_scale = settings.mean_power / (settings.photons as f64 * std::f64::consts::PI * settings.unit);
        let push = UpdatePush {
            luminance: LUMINANCE.map(|weight| weight as f32),
            pixel_count: settings.pixels() as u32,
            alpha: alpha as f32,
            per_unit: (1.0 / settings.unit) as f32,
            flux_scale: flux_scale as f32,
            half_of_rounds: place.half,
        };
        let counters = on.run_counted(|frame| {
            if settings.contribution == Contribution::Photons {
                frame.clear_texels(&on.buffers.visible_radiances);
            }
            frame.dispatch(&self.update, push, settings.pixels());
        })?;
        progress.tally.add(Counted::Update, &counters);
        Ok(())
    }

    /// Compiles the passes for a scene and runs each once over nothing, since drivers
    /// may leave compilation to the first dispatch.
    ///
    /// # Errors
    /// The driver refuses a kernel.
    pub fn new(
        device: &Device,
        scene: GpuScene,
        buffers: &Buffers,
        lookup: LookupKind,
        specialization: &Specialization,
        workgroup_size: u32,
    ) -> goblet_host::Result<Self> {
        let Buffers { max_radius2, pixel_states, counters, .. } = buffers;
        let Buffers { visible_radii2, visible_throughputs, visible_radiances, .. } = buffers;
        let Buffers { flux_red, flux_green, flux_blue, flux_counts, .. } = buffers;
        let Buffers { sum_red, sum_green, sum_blue, sum_second, .. } = buffers;
        macro_rules! pass {
            ($($kernel:tt)*) => { device.pass(&$($kernel)*, specialization, workgroup_size)? };
        }
        let path_kernels = PathKernels { scene, specialization: *specialization, workgroup_size };
        // These two take the longest, at the same time.
        let eye = path_kernels.eye(device, buffers, false)?;
        let photon = path_kernels.photon(device, buffers, false)?;
        let passes = Self {
            radius: pass!(Radius { visible_radii2, visible_throughputs, pixel_states, max_radius2 }),
            lookup: Lookup::new(device, buffers, lookup, specialization, workgroup_size)?,
            update: pass!(Update {
                visible_radii2,
                visible_throughputs,
                visible_radiances,
                pixel_states,
                sum_red,
                sum_green,
                sum_blue,
                sum_second,
                counters,
                flux_red,
                flux_green,
                flux_blue,
                flux_counts
            }),
            photon: PathPass::new(photon.finish()?, workgroup_size),
            eye: PathPass::new(eye.finish()?, workgroup_size),
            path_kernels,
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
        frame.dispatch(self.eye.plain(), Zeroable::zeroed(), 1);
        frame.dispatch(&self.radius, Zeroable::zeroed(), 1);
        self.lookup.warm_up(&mut frame);
        frame.dispatch(self.photon.plain(), Zeroable::zeroed(), 1);
        frame.dispatch(&self.update, Zeroable::zeroed(), 1);
        frame.run()
    }
}
