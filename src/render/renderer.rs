//! Iterations over a scene on a device.

mod aside;
mod inspect;

use std::sync::Arc;
use std::time::{Duration, Instant};

pub use aside::Aside;
use goblet_host::{Device, DeviceKind};

use crate::base::room;
use crate::gpu_scene::camera::{View, pack_camera};
use crate::gpu_scene::pack::{RenderSpace, RevolutionSolver, pack};
use crate::image::estimate::{Estimate, Sum};
use crate::image::file;
use crate::image::film::Image;
use crate::kernels::{MaterialFeatures, PassFeatures, PixelState, SceneFeatures, Specialization};
use crate::render::buffers::{Buffers, Sizes};
use crate::render::checkpoint::{Checkpoint, CheckpointError, MadeBy};
use crate::render::counters::Tally;
use crate::render::error::RenderError;
use crate::render::identity::Identity;
use crate::render::iteration;
use crate::render::memory::MemoryNeed;
use crate::render::options::{LookupKind, Options, Resolved};
use crate::render::pacing::Schedule;
use crate::render::passes::Passes;
use crate::render::progress::Progress;
use crate::render::radius::{FirstRadius, GlobalShrink};
use crate::render::sequence::Sequence;
use crate::render::settings::Settings;
use crate::render::stage::Stage;
use crate::render::unsampled::{Noise, of_one_photon, photons_matter};
use crate::scene::Scene;

/// A render in progress. It may move to another thread, and several renderers may share a device: each
/// then waits for the dispatches of the others.
pub struct Renderer {
    device: Arc<Device>,
    /// What `restart` keeps of a scene.
    base: Base,
    /// What the kernels are compiled for.
    compiled: Compiled,
    settings: Settings,
    exposure: f64,
    identity: Identity,
    /// Sizes that the buffers were made for.
    sizes: Sizes,
    buffers: Buffers,
    passes: Passes,
    progress: Progress,
    warnings: Vec<String>,
    build_time: Duration,
    compile_time: Duration,
}

const _: () = {
    const fn is_send<T: Send>() {}
    is_send::<Renderer>();
};

/// What does not depend on the camera or on options.
#[derive(Clone, Copy)]
struct Base {
    space: RenderSpace,
    mean_power: f64,
    has_surfaces: bool,
    features: SceneFeatures,
    material_features: MaterialFeatures,
    is_plane: bool,
}

/// What only a new renderer can have otherwise.
#[derive(Clone, Copy, PartialEq)]
struct Compiled {
    specialization: Specialization,
    lookup: LookupKind,
    workgroup_size: u32,
    solver: RevolutionSolver,
    max_depth: u32,
    seed: u32,
}

impl Base {
    fn resolve(&self, scene: &Scene, options: &Options) -> Result<(Resolved, View), RenderError> {
        let resolved = options.resolve(scene, self.space.radius / self.space.scale)?;
        let view = pack_camera(&scene.camera, &scene.film, resolved.window.full, &self.space.from_world());
        Ok((resolved, view))
    }

    fn compiled(&self, device: &Device, options: &Options, resolved: &Resolved, view: &View) -> Compiled {
        Compiled {
            specialization: Specialization {
                scene: self.features,
                material: self.material_features,
                camera: view.features(),
                render: options.features(resolved),
                pass: PassFeatures { is_resumable: false },
            },
            // The grid's points look at photons together. Trees ask for no more than any device has.
            lookup: if device.info().has_shuffle { options.lookup } else { LookupKind::KdTree },
            workgroup_size: resolved.workgroup_size,
            solver: options.revolution_solver,
            max_depth: resolved.max_depth,
            seed: resolved.seed,
        }
    }

    fn settings(&self, options: &Options, resolved: &Resolved, view: &View) -> Settings {
        Settings {
            resolution: resolved.resolution,
            window: resolved.window,
            photons: resolved.photons,
            eye_paths: resolved.eye_paths,
            alpha: resolved.alpha,
            radius_schedule: options.radius_schedule,
            pixel_width: view.pixel_width,
            is_parallel: view.is_parallel(),
            radius_per_length: resolved.radius_in_pixels * view.pixel_width,
            sequence: resolved.sequence,
            mean_power: self.mean_power,
            // What all lights would make of the inside of a sphere as large as the scene.
            unit: if self.mean_power > 0.0 { self.mean_power.log2().ceil().exp2() } else { 1.0 },
            contribution: options.contribution,
            has_photons: self.mean_power > 0.0 && self.has_surfaces,
            photons_matter: photons_matter(options, resolved.max_depth, self.is_plane),
        }
    }

    fn progress(&self, device: &Device, options: &Options, resolved: &Resolved, view: &View) -> Progress {
        Progress {
            done: 0,
            halves: [0; 2],
            first_radius: resolved
                .radius
                .map(|radius| FirstRadius::constant(radius * self.space.scale))
                .or(view.is_parallel().then(|| FirstRadius::constant(resolved.radius_in_pixels * view.pixel_width))),
            response: None,
            seen: None,
            shrink: GlobalShrink::new(resolved.alpha),
            schedule: Schedule::new(options.batch_size, resolved.photons, device.info().kind, options.responsive),
            tally: Tally::default(),
        }
    }
}

impl Renderer {
    /// Prepares a scene for rendering: builds the hierarchy, uploads, compiles.
    ///
    /// # Errors
    /// The scene is beyond what can be rendered, an option is out of range, or the device has not
    /// enough memory.
    pub fn new(device: Arc<Device>, scene: &Scene, options: &Options) -> Result<Self, RenderError> {
        let start = Instant::now();
        let packed = pack(scene, options.revolution_solver)?;
        let base = Base {
            space: packed.space,
            mean_power: packed.mean_power,
            has_surfaces: !packed.arrays.primitives.is_empty(),
            features: packed.features,
            material_features: packed.material_features,
            is_plane: scene.is_plane(),
        };
        let (resolved, view) = base.resolve(scene, options)?;
        let identity = Identity::new(scene, &packed, &view, options, &resolved);
        let compiled = base.compiled(&device, options, &resolved, &view);
        let sizes = Sizes::new(resolved.resolution, resolved.photons, resolved.max_depth);
        let memory = MemoryNeed::new(&packed, &sizes, compiled.lookup);
        memory.check(&device)?;
        // Drivers and compilers end the process where the host has no memory left.
        let on_host = if device.info().kind == DeviceKind::Cpu { memory.total() } else { 0 };
        room::check("a render of this size", on_host + file::host_bytes(resolved.resolution))?;
        let gpu_scene = packed.arrays.upload(&device, &packed.info(resolved.max_depth, resolved.seed))?;
        let buffers = Buffers::new(&device, &sizes, &view)?;
        let build_time = start.elapsed();

        let start = Instant::now();
        let Compiled { specialization, lookup, workgroup_size, .. } = &compiled;
        let passes = Passes::new(&device, gpu_scene, &buffers, &sizes, *lookup, specialization, *workgroup_size)?;
        Ok(Self {
            settings: base.settings(options, &resolved, &view),
            progress: base.progress(&device, options, &resolved, &view),
            exposure: scene.film.exposure,
            base,
            compiled,
            identity,
            sizes,
            buffers,
            passes,
            warnings: packed.contacts.warnings(),
            build_time,
            compile_time: start.elapsed(),
            device,
        })
    }

    /// Begins again with another camera, film or options, and without building or compiling
    /// anything; the image is that of a new renderer. All else of the scene must be as it was.
    /// False, and nothing changes, where only a new renderer can: it needs other kernels, or more
    /// pixels than this one was made for.
    ///
    /// # Errors
    /// An option is out of range, or the device fails.
    pub fn restart(&mut self, scene: &Scene, options: &Options) -> Result<bool, RenderError> {
        let (resolved, view) = self.base.resolve(scene, options)?;
        let compiled = self.base.compiled(&self.device, options, &resolved, &view);
        if compiled != self.compiled || !self.sizes.fit(resolved.resolution) {
            return Ok(false);
        }
        self.buffers.set_view(&self.device, &view)?;
        self.buffers.clear(&self.device)?;
        self.identity.set_view(scene, &view, options, &resolved);
        self.settings = self.base.settings(options, &resolved, &view);
        self.exposure = scene.film.exposure;
        let paces = self.progress.schedule.paces;
        self.progress = self.base.progress(&self.device, options, &resolved, &view);
        if options.responsive {
            self.progress.schedule.paces = paces;
        }
        Ok(true)
    }

    /// Runs one iteration.
    ///
    /// # Errors
    /// The device fails; earlier iterations are not lost while it still answers.
    pub fn step(&mut self) -> Result<(), RenderError> {
        self.step_unless(&|| false).map(|_| ())
    }

    /// Runs one iteration, unless `gives_up` says between two dispatches that it is not wanted:
    /// then all is as if it had not begun. Whether it is done. [`Options::responsive`] keeps
    /// dispatches short.
    ///
    /// # Errors
    /// As [`Renderer::step`].
    pub fn step_unless(&mut self, gives_up: &dyn Fn() -> bool) -> Result<bool, RenderError> {
        let tally = self.progress.tally;
        let stage = Stage { device: &self.device, buffers: &self.buffers, settings: &self.settings, gives_up };
        let outcome = iteration::run(&mut self.passes, stage, &mut self.progress);
        let Err(error) = outcome else { return Ok(true) };
        // Its photons are not in the image, and its visible points may not be complete.
        self.progress.tally = tally;
        self.progress.seen = None;
        let clear = || {
            let mut frame = self.device.frame()?;
            self.buffers.clear_flux(&mut frame);
            frame.run()
        };
        let cleared = clear();
        match error {
            RenderError::GivenUp => Ok(cleared.map(|()| false)?),
            // A device that has failed may well fail again.
            error => Err(error),
        }
    }

    /// The sums over the iterations so far.
    ///
    /// # Errors
    /// The device fails.
    pub fn estimate(&self) -> Result<Estimate, RenderError> {
        let pixels = self.settings.pixels();
        room::check("the image", pixels * size_of::<[Sum; 4]>() as u64)?;
        let [red, green, blue, second] = self.buffers.sums().map(|sums| self.device.read_first_texels(sums, pixels));
        Ok(Estimate {
            resolution: self.settings.resolution,
            window: self.settings.window,
            unit: self.settings.unit * self.exposure,
            halves: self.progress.halves,
            radiance: [red?, green?, blue?],
            second_half: second?,
        })
    }

    /// How far the noise of the image is known; `estimate` is that of the iterations so far.
    ///
    /// # Errors
    /// The device fails.
    pub fn noise(&mut self, estimate: &Estimate) -> Result<Noise, RenderError> {
        let of_halves = estimate.relative_error();
        let photons = self.photons();
        if !self.settings.photons_matter || photons == 0 {
            return Ok(Noise { of_halves, of_one_photon: 0.0 });
        }
        if self.progress.response.is_none() {
            // After a checkpoint: what follows must not depend on where that was.
            let stage =
                Stage { device: &self.device, buffers: &self.buffers, settings: &self.settings, gives_up: &|| false };
            self.passes.eye.measure(stage, &mut self.progress)?;
        }
        let response = self.progress.response.unwrap_or_default();
        let flux = self.settings.mean_power / photons as f64;
        Ok(Noise { of_halves, of_one_photon: of_one_photon(response, flux, self.settings.unit, estimate) })
    }

    /// The relative error of the image so far, as far as it is known: [`Noise::relative_error`].
    ///
    /// # Errors
    /// The device fails.
    pub fn relative_error(&mut self) -> Result<Option<f64>, RenderError> {
        let estimate = self.estimate()?;
        Ok(self.noise(&estimate)?.relative_error())
    }

    /// The image after the iterations so far; black before the first.
    ///
    /// # Errors
    /// The device fails.
    pub fn resolve(&self) -> Result<Image, RenderError> {
        Ok(self.estimate()?.image())
    }

    /// All that a later run needs to go on from here; `scene` is the scene's name, for people.
    ///
    /// # Errors
    /// The device fails.
    pub fn checkpoint(&self, scene: &str) -> Result<Checkpoint, RenderError> {
        let shard = self.settings.sequence.shard;
        room::check("the checkpoint", self.settings.pixels() * size_of::<([Sum; 4], PixelState)>() as u64)?;
        Ok(Checkpoint {
            identity: self.identity.clone(),
            scene: scene.to_owned(),
            made_by: MadeBy::new(&self.device),
            shards: shard.count,
            done: [(shard.index, self.progress.done)].into(),
            first_radius: self.progress.first_radius,
            tally: self.progress.tally,
            estimate: self.estimate()?,
            states: self.device.read_first_texels(&self.buffers.pixel_states, self.settings.pixels())?,
        })
    }

    /// Goes on from where another render of the same scene with the same options was.
    ///
    /// # Errors
    /// The checkpoint is of another render; the error names a difference.
    pub fn resume(&mut self, checkpoint: &Checkpoint) -> Result<(), CheckpointError> {
        self.identity.check(&checkpoint.identity)?;
        checkpoint.check_form(self.settings.resolution, self.settings.unit * self.exposure)?;
        let done = checkpoint.done_by(self.settings.sequence.shard)?;
        for (texels, sums) in self.buffers.sums().into_iter().zip(checkpoint.estimate.sums()) {
            self.device.write_texels(texels, sums)?;
        }
        self.device.write_texels(&self.buffers.pixel_states, &checkpoint.states)?;
        self.progress.done = done;
        self.progress.halves = checkpoint.estimate.halves;
        self.progress.first_radius = checkpoint.first_radius;
        self.progress.seen = None;
        self.progress.tally = checkpoint.tally;
        Ok(())
    }

    /// What of the scene rays cannot decide, one line each.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Iterations finished.
    pub fn iterations(&self) -> u32 {
        self.progress.done
    }

    /// Which iterations it is made of.
    pub fn sequence(&self) -> Sequence {
        self.settings.sequence
    }

    /// Photons emitted by the iterations so far.
    pub fn photons(&self) -> u64 {
        self.settings.wanted_photons() * u64::from(self.progress.done)
    }

    /// Eye paths traced for the iterations so far.
    pub fn eye_paths(&self) -> u64 {
        let rounds = self.progress.done.div_ceil(self.settings.sequence.round_length);
        self.settings.pixels() * u64::from(self.settings.eye_paths) * u64::from(rounds)
    }

    /// What happened to photon and eye paths.
    pub fn tally(&self) -> &Tally {
        &self.progress.tally
    }

    /// The smallest and largest radius of a visible point in the last iteration, scene
    /// units; 0 if there is none.
    ///
    /// # Errors
    /// The device fails.
    pub fn radius_range(&self) -> Result<[f64; 2], RenderError> {
        let squares = self.device.read_first_texels(&self.buffers.visible_radii2, self.settings.pixels())?;
        let squares = squares.into_iter().map(f64::from).filter(|radius2| *radius2 > 0.0);
        let [least, most] = squares.fold([f64::INFINITY, 0.0], |[least, most], r2| [r2.min(least), r2.max(most)]);
        Ok([least.min(most), most].map(|radius2| radius2.sqrt() / self.base.space.scale))
    }

    /// Time to build the hierarchy and to upload.
    pub fn build_time(&self) -> Duration {
        self.build_time
    }

    /// Time to compile the kernels.
    pub fn compile_time(&self) -> Duration {
        self.compile_time
    }

    /// Time that the host has spent on kd-trees over visible points, to read the points and to
    /// write the nodes included; 0 with a hash grid, which is the device's work alone.
    pub fn kd_build_time(&self) -> Duration {
        self.passes.index_host_time()
    }

    /// The device it runs on.
    pub fn device(&self) -> &Device {
        &self.device
    }
}
