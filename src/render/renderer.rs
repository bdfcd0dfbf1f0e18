//! The renderer of a scene on a device: construction, iterations, images and checkpoints.

mod aside;
mod inspect;
mod noise;
mod prepared;
mod restart;
mod trial;

use std::sync::Arc;
use std::time::Duration;

pub use aside::Aside;
use goblet_host::Device;
pub use prepared::Prepared;

use crate::base::host_memory;
use crate::gpu_scene::camera::{View, pack_camera};
use crate::gpu_scene::pack::{RenderSpace, RevolutionSolver};
use crate::image::estimate::{Estimate, Sum};
use crate::image::film::Image;
use crate::image::layers::{Groups, LayerForm, Layers};
use crate::kernels::{MaterialFeatures, PixelState, SceneFeatures, Specialization};
use crate::render::activity::{Activity, Observer};
use crate::render::buffers::{Buffers, Sizes};
use crate::render::checkpoint::{Checkpoint, CheckpointError, MadeBy, To};
use crate::render::counters::Tally;
use crate::render::counts::Choice;
use crate::render::device::device_features;
use crate::render::error::RenderError;
use crate::render::frame::Frame;
use crate::render::guide::guidance::Guidance;
use crate::render::guide::lights::GuideLights;
use crate::render::identity::Identity;
use crate::render::iteration;
use crate::render::layers::LayerArrays;
use crate::render::options::{Dispersion, LookupKind, Options, Resolved};
use crate::render::pacing::Schedule;
use crate::render::passes::Passes;
use crate::render::progress::Progress;
use crate::render::radius::{FirstRadius, GlobalShrink};
use crate::render::sequence::Sequence;
use crate::render::settings::Settings;
use crate::render::specialize::specialization;
use crate::render::stage::Stage;
use crate::render::unsampled::photons_matter;
use crate::scene::Scene;

/// A render in progress. A renderer may move to another thread. Several renderers may share a device; each
/// then waits for the dispatches of the others.
pub struct Renderer {
    device: Arc<Device>,
    /// Values of the scene that `restart` keeps.
    base: Base,
    /// Settings that the kernels are compiled for.
    compiled: Compiled,
    settings: Settings,
    exposure: f64,
    identity: Identity,
    /// Sizes that the buffers were allocated for.
    sizes: Sizes,
    buffers: Buffers,
    passes: Passes,
    lights: GuideLights,
    progress: Progress,
    warnings: Vec<String>,
    /// The choice of a trial, if one was asked for.
    choice: Option<Choice>,
    /// Who is told what the render does.
    observer: Observer,
    build_time: Duration,
    compile_time: Duration,
}

const _: () = {
    const fn is_send<T: Send>() {}
    is_send::<Renderer>();
};

/// Values of the scene that depend neither on the camera nor on options.
#[derive(Clone, Copy)]
struct Base {
    space: RenderSpace,
    mean_power: f64,
    has_surfaces: bool,
    features: SceneFeatures,
    material_features: MaterialFeatures,
    is_plane: bool,
}

/// Settings that are fixed at construction: to change them takes a new renderer.
#[derive(Clone, Copy, PartialEq)]
struct Compiled {
    specialization: Specialization,
    lookup: LookupKind,
    workgroup_size: u32,
    solver: RevolutionSolver,
    dispersion: Dispersion,
    max_depth: u32,
    seed: u32,
    layers: Groups,
}

impl Base {
    fn resolve(&self, scene: &Scene, options: &Options) -> Result<(Resolved, View), RenderError> {
        let resolved = options.resolve(scene, self.space.radius / self.space.scale)?;
        let view = pack_camera(&scene.camera, &scene.film, resolved.window.full, &self.space.from_world());
        Ok((resolved, view))
    }

    fn compiled(&self, device: &Device, options: &Options, resolved: &Resolved, view: &View) -> Compiled {
        Compiled {
            specialization: specialization(
                self.features,
                self.material_features,
                view,
                options,
                resolved,
                device_features(device.info(), resolved.workgroup_size),
            ),
            // The gather pass of the grid needs shuffles within a subgroup; the pass of the tree runs on any
            // device.
            lookup: if device.info().subgroups.has_shuffle { options.lookup } else { LookupKind::KdTree },
            workgroup_size: resolved.workgroup_size,
            solver: options.revolution_solver,
            dispersion: options.dispersion,
            max_depth: resolved.max_depth,
            seed: resolved.seed,
            layers: resolved.layers,
        }
    }

    fn settings(&self, scene: &Scene, options: &Options, resolved: &Resolved, view: &View) -> Settings {
        Settings {
            resolution: resolved.resolution,
            window: resolved.window,
            photons: resolved.photons,
            eye_paths: resolved.eye_paths,
            guidance: if options.is_guided() { options.guidance } else { Guidance::Off },
            alpha: resolved.alpha,
            radius_schedule: options.radius_schedule,
            pixel_width: view.pixel_width,
            is_parallel: view.is_parallel(),
            radius_per_length: resolved.radius_in_pixels * view.pixel_width,
            sequence: resolved.sequence,
            mean_power: self.mean_power,
            // The radiance inside a sphere as large as the scene with all lights in it, as a power of two.
            unit: if self.mean_power > 0.0 { self.mean_power.log2().ceil().exp2() } else { 1.0 },
            white_balance: scene.film.white_balance.map(|balance| balance.matrix),
            contribution: options.contribution,
            has_photons: self.mean_power > 0.0 && self.has_surfaces,
            photons_matter: photons_matter(options, resolved.max_depth, self.is_plane),
            layers: self.layer_form(scene, resolved),
            frame: Frame::new(&scene.camera, 1.0 / self.space.scale),
        }
    }

    fn layer_form(&self, scene: &Scene, resolved: &Resolved) -> LayerForm {
        if resolved.layers.is_empty() {
            return LayerForm::default();
        }
        let world_from_render = self.space.from_world().inverse();
        LayerForm {
            groups: resolved.layers,
            of_film: scene.film.gbuffer.is_some(),
            system: scene.film.gbuffer.unwrap_or_default(),
            camera_from_render: scene.camera.world_from_camera.inverse() * world_from_render,
            world_from_render,
            photons: resolved.photons,
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
            guide: None,
            lights_are_learned: false,
            seen: None,
            shrink: GlobalShrink::new(resolved.alpha),
            schedule: Schedule::new(
                options.batch_size,
                resolved.photons,
                device.info().kind,
                options.responsive,
                options.submission,
            ),
            tally: Tally::default(),
        }
    }
}

impl Renderer {
    /// Runs one iteration.
    ///
    /// # Errors
    /// The device fails. Earlier iterations are kept as long as the device still responds.
    pub fn step(&mut self) -> Result<(), RenderError> {
        self.step_unless(&|| false).map(|_| ())
    }

    /// Runs one iteration, and calls `gives_up` between dispatches. If `gives_up` returns true, the iteration
    /// ends and leaves no trace. Returns whether the iteration was finished. [`Options::responsive`] keeps
    /// dispatches short.
    ///
    /// # Errors
    /// The same as for [`Renderer::step`].
    pub fn step_unless(&mut self, gives_up: &dyn Fn() -> bool) -> Result<bool, RenderError> {
        let tally = self.progress.tally;
        let stage = Stage {
            device: &self.device,
            buffers: &self.buffers,
            settings: &self.settings,
            lights: &self.lights,
            observer: &self.observer,
            gives_up,
        };
        self.observer.tell(Activity::Rendering);
        let outcome = iteration::run(&mut self.passes, stage, &mut self.progress);
        let Err(error) = outcome else { return Ok(true) };
        // The photons of the iteration are not in the image, and its visible points may be incomplete.
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
            // Clearing may have failed too, on a device that has failed: the first error is returned.
            error => Err(error),
        }
    }

    /// Returns the sums over the iterations so far.
    ///
    /// # Errors
    /// The device fails.
    pub fn estimate(&self) -> Result<Estimate, RenderError> {
        let pixels = self.settings.pixels();
        let form = self.settings.layers;
        host_memory::check("the image", pixels * (1 + form.groups.len()) as u64 * size_of::<[Sum; 4]>() as u64)?;
        let [red, green, blue, second] =
            self.buffers.sums.each_ref().map(|sums| self.device.read_first_texels(sums, pixels));
        Ok(Estimate {
            resolution: self.settings.resolution,
            window: self.settings.window,
            unit: self.settings.unit * self.exposure,
            white_balance: self.settings.white_balance,
            halves: self.progress.halves,
            radiance: [red?, green?, blue?],
            second_half: second?,
            layers: Layers {
                form,
                sums: self.layers().map_or(Ok(Vec::new()), |layers| layers.read(&self.device, pixels))?,
            },
        })
    }

    /// Returns the identity, the radius that visible points start with, and the camera as files describe it.
    pub(crate) fn facts(&self) -> (&Identity, Option<FirstRadius>, Option<Frame>) {
        (&self.identity, self.progress.first_radius, self.settings.frame)
    }

    fn layers(&self) -> Option<&LayerArrays> {
        self.passes.layers.as_ref().map(|passes| &passes.arrays)
    }

    /// Returns the image after the iterations so far; it is black before the first iteration.
    ///
    /// # Errors
    /// The device fails.
    pub fn resolve(&self) -> Result<Image, RenderError> {
        Ok(self.estimate()?.image())
    }

    /// Returns a checkpoint, from which a later run can continue. `scene` is the scene's name, for messages.
    ///
    /// # Errors
    /// The device fails.
    pub fn checkpoint(&self, scene: &str) -> Result<Checkpoint, RenderError> {
        let shard = self.settings.sequence.shard;
        let of_layers = self.settings.layers.groups.len() * size_of::<[Sum; 4]>();
        let of_pixel = (size_of::<([Sum; 4], PixelState)>() + of_layers) as u64;
        host_memory::check("the checkpoint", self.settings.pixels() * of_pixel)?;
        Ok(Checkpoint {
            identity: self.identity.clone(),
            scene: scene.to_owned(),
            made_by: MadeBy::new(&self.device),
            shards: shard.count,
            done: [(shard.index, self.progress.done)].into(),
            first_radius: self.progress.first_radius,
            frame: self.settings.frame,
            tally: self.progress.tally,
            estimate: self.estimate()?,
            states: self.device.read_first_texels(&self.buffers.pixel_states, self.settings.pixels())?,
        })
    }

    /// Continues a render of the same scene with the same options from a checkpoint.
    ///
    /// # Errors
    /// The checkpoint is of another render (the error names a difference), or the device fails.
    pub fn resume(&mut self, checkpoint: &Checkpoint) -> Result<(), CheckpointError> {
        self.identity.check(&checkpoint.identity, To::Render)?;
        let Settings { resolution, unit, white_balance, layers, .. } = self.settings;
        checkpoint.check_form(resolution, unit * self.exposure, white_balance, &layers)?;
        let done = checkpoint.done_by(self.settings.sequence.shard)?;
        for (texels, sums) in self.buffers.sums.iter().zip(checkpoint.estimate.sums()) {
            self.device.write_texels(texels, sums)?;
        }
        if let Some(layers) = self.layers() {
            layers.write(&self.device, &checkpoint.estimate.layers.sums)?;
        }
        self.device.write_texels(&self.buffers.pixel_states, &checkpoint.states)?;
        self.progress.done = done;
        self.progress.halves = checkpoint.estimate.halves;
        self.progress.first_radius = checkpoint.first_radius;
        self.progress.seen = None;
        self.progress.tally = checkpoint.tally;
        Ok(())
    }

    /// Returns warnings about surfaces in contact whose order rays cannot decide, one line each.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Returns the number of finished iterations.
    pub fn iterations(&self) -> u32 {
        self.progress.done
    }

    /// Returns the sequence of iterations of the render.
    pub fn sequence(&self) -> Sequence {
        self.settings.sequence
    }

    /// Returns the number of photons that the iterations so far have emitted.
    pub fn photons(&self) -> u64 {
        self.settings.wanted_photons() * u64::from(self.progress.done)
    }

    /// Returns the number of eye paths that were traced for the iterations so far.
    pub fn eye_paths(&self) -> u64 {
        let rounds = self.progress.done.div_ceil(self.settings.sequence.round_length);
        self.settings.pixels() * u64::from(self.settings.eye_paths) * u64::from(rounds)
    }

    /// Returns the counts of how photon paths and eye paths ended.
    pub fn tally(&self) -> &Tally {
        &self.progress.tally
    }

    /// Returns the smallest and the largest radius of a visible point in the last iteration, in scene units;
    /// 0 if there is no visible point.
    ///
    /// # Errors
    /// The device fails.
    pub fn radius_range(&self) -> Result<[f64; 2], RenderError> {
        let squares = self.device.read_first_texels(&self.buffers.visible_radii2, self.settings.pixels())?;
        let squares = squares.into_iter().map(f64::from).filter(|radius2| *radius2 > 0.0);
        let [least, most] = squares.fold([f64::INFINITY, 0.0], |[least, most], r2| [r2.min(least), r2.max(most)]);
        Ok([least.min(most), most].map(|radius2| radius2.sqrt() / self.base.space.scale))
    }

    /// Returns the time that building the hierarchy and uploading the scene took.
    pub fn build_time(&self) -> Duration {
        self.build_time
    }

    /// Returns the time that compiling the kernels took.
    pub fn compile_time(&self) -> Duration {
        self.compile_time
    }

    /// Returns the time that the host has spent on kd-trees over visible points, including the transfer of
    /// points and nodes; 0 with a hash grid, which the device builds alone.
    pub fn kd_build_time(&self) -> Duration {
        self.passes.index_host_time()
    }

    /// Tells another observer what the render does from now on.
    pub fn set_observer(&mut self, observer: Observer) {
        self.observer = observer;
    }

    /// Returns the device of the render.
    pub fn device(&self) -> &Device {
        &self.device
    }
}
