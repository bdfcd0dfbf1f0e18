//! Iterations over a scene on a device.

use std::rc::Rc;
use std::time::{Duration, Instant};

use goblet_host::{Device, Instance};

use crate::buffers::{Buffers, Sizes};
use crate::checkpoint::{Checkpoint, CheckpointError, MadeBy};
use crate::estimate::Estimate;
use crate::film::Image;
use crate::identity::Identity;
use crate::iteration::{Passes, Progress, Settings, Stage};
use crate::kernels::{REQUIREMENTS, Specialization};
use crate::options::{DirectLight, LookupKind, Options};
use crate::pack::{PackError, pack};
use crate::radius::{FirstRadius, GlobalShrink};
use crate::scene::Scene;
use crate::schedule::Schedule;
use crate::sequence::Sequence;
use crate::tally::Tally;
use crate::upload::GpuScene;
use crate::view::pack_camera;

/// Why a renderer cannot be made or cannot go on.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// The scene cannot be rendered.
    #[error(transparent)]
    Scene(#[from] PackError),
    /// An option is out of range for this scene.
    #[error("{0}")]
    Option(String),
    /// The driver ended a kernel before it was done.
    #[error("the driver limits the loops of a kernel, and the {pass} pass of this scene needs more: expected {remedy}")]
    Interrupted {
        /// The pass.
        pass: &'static str,
        /// What would help.
        remedy: &'static str,
    },
    /// The device failed or is not enough.
    #[error(transparent)]
    Device(#[from] goblet_host::Error),
}

/// Opens the device that `selector` names, or the first that fits; with `validation`, every
/// Vulkan call is checked.
///
/// # Errors
/// There is no such device, or it lacks what goblet needs.
pub fn open_device(selector: Option<&str>, validation: bool) -> goblet_host::Result<Device> {
    Instance::new(validation)?.open(selector, &REQUIREMENTS)
}

/// A render in progress.
pub struct Renderer {
    device: Rc<Device>,
    resolution: [u32; 2],
    settings: Settings,
    exposure: f64,
    identity: Identity,
    buffers: Buffers,
    passes: Passes,
    progress: Progress,
    build_time: Duration,
    compile_time: Duration,
    /// Scene units per render unit.
    scene_unit: f64,
}

impl Renderer {
    /// Prepares a scene for rendering: builds the hierarchy, uploads, compiles.
    ///
    /// # Errors
    /// The scene has nothing to render, an option is out of range, or the device has not
    /// enough memory.
    pub fn new(device: Rc<Device>, scene: &Scene, options: &Options) -> Result<Self, RenderError> {
        let start = Instant::now();
        let packed = pack(scene, options.revolution_solver)?;
        let scene_unit = 1.0 / packed.space.scale;
        let resolved = options.resolve(scene, packed.space.radius * scene_unit)?;

        let sizes = Sizes::new(resolved.resolution, resolved.photons, resolved.max_depth);
        let view = pack_camera(&scene.camera, &scene.film, resolved.full_resolution, &packed.space.from_world());
        let identity = Identity::new(scene, &packed, &view, options, &resolved);
        let gpu_scene = GpuScene::new(&device, &packed, resolved.max_depth, resolved.seed)?;
        let buffers = Buffers::new(&device, sizes, &view)?;
        let build_time = start.elapsed();

        let start = Instant::now();
        let specialization = Specialization {
            direct_nee: options.direct == DirectLight::Nee,
            low_discrepancy_pairs: options.sampler.low_discrepancy_pairs(),
            cell_scale: resolved.cell_scale as f32,
            ..view.specialize(packed.specialization)
        };
        // The grid's points look at photons together. Trees ask for no more than any device has.
        let lookup = if device.info().has_shuffle { options.lookup } else { LookupKind::KdTree };
        let passes = Passes::new(&device, &gpu_scene, &buffers, lookup, &specialization, resolved.workgroup_size)?;
        let footprint = resolved.radius_in_pixels * view.pixel_width;
        Ok(Self {
            resolution: resolved.resolution,
            settings: Settings {
                pixels: resolved.pixels,
                photons: resolved.photons,
                eye_paths: resolved.eye_paths,
                alpha: resolved.alpha,
                radius_schedule: options.radius_schedule,
                radius_per_length: footprint,
                sequence: resolved.sequence,
                mean_power: packed.mean_power,
                // What all lights would make of the inside of a sphere as large as the scene.
                unit: packed.mean_power.log2().ceil().exp2(),
            },
            exposure: scene.film.exposure,
            identity,
            buffers,
            passes,
            progress: Progress {
                done: 0,
                first_radius: resolved
                    .radius
                    .map(|radius| FirstRadius::constant(radius / scene_unit))
                    .or(view.is_parallel().then(|| FirstRadius::constant(footprint))),
                seen: None,
                shrink: GlobalShrink::new(resolved.alpha),
                schedule: Schedule::new(options.batch_size, resolved.photons, device.info().kind),
                tally: Tally::default(),
            },
            build_time,
            compile_time: start.elapsed(),
            scene_unit,
            device,
        })
    }

    /// Runs one iteration.
    ///
    /// # Errors
    /// The device fails; earlier iterations are not lost while it still answers.
    pub fn step(&mut self) -> Result<(), RenderError> {
        let tally = self.progress.tally;
        let stage = Stage { device: &self.device, buffers: &self.buffers, settings: &self.settings };
        let outcome = self.passes.run(stage, &mut self.progress);
        if outcome.is_err() {
            // Its photons are not in the image.
            self.progress.tally = tally;
        }
        outcome
    }

    /// The sums over the iterations so far.
    ///
    /// # Errors
    /// The device fails.
    pub fn estimate(&self) -> Result<Estimate, RenderError> {
        let Buffers { sum_red, sum_green, sum_blue, sum_second, .. } = &self.buffers;
        let [red, green, blue] = [sum_red, sum_green, sum_blue].map(|sums| self.device.read_texels(sums));
        Ok(Estimate {
            resolution: self.resolution,
            unit: self.settings.unit * self.exposure,
            halves: self.settings.sequence.halves(self.progress.done),
            radiance: [red?, green?, blue?],
            second_half: self.device.read_texels(sum_second)?,
        })
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
        Ok(Checkpoint {
            identity: self.identity.clone(),
            scene: scene.to_owned(),
            made_by: MadeBy::new(&self.device),
            shards: shard.count,
            done: [(shard.index, self.progress.done)].into(),
            first_radius: self.progress.first_radius,
            tally: self.progress.tally,
            estimate: self.estimate()?,
            states: self.device.read_texels(&self.buffers.pixel_states)?,
        })
    }

    /// Goes on from where another render of the same scene with the same options was.
    ///
    /// # Errors
    /// The checkpoint is of another render; the error names a difference.
    pub fn resume(&mut self, checkpoint: &Checkpoint) -> Result<(), CheckpointError> {
        self.identity.check(&checkpoint.identity)?;
        checkpoint.check_form(self.resolution, self.settings.unit * self.exposure)?;
        let done = checkpoint.done_by(self.settings.sequence.shard)?;
        for (texels, sums) in self.buffers.sums().into_iter().zip(checkpoint.estimate.sums()) {
            self.device.write_texels(texels, sums)?;
        }
        self.device.write_texels(&self.buffers.pixel_states, &checkpoint.states)?;
        self.progress.done = done;
        self.progress.first_radius = checkpoint.first_radius;
        self.progress.seen = None;
        self.progress.tally = checkpoint.tally;
        Ok(())
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
        self.settings.photons * u64::from(self.progress.done)
    }

    /// What happened to them.
    pub fn tally(&self) -> &Tally {
        &self.progress.tally
    }

    /// The smallest and largest radius of a visible point in the last iteration, scene
    /// units; 0 if there is none.
    ///
    /// # Errors
    /// The device fails.
    pub fn radius_range(&self) -> Result<[f64; 2], RenderError> {
        let squares = self.device.read_texels(&self.buffers.visible_radii2)?;
        let squares = squares.into_iter().map(f64::from).filter(|radius2| *radius2 > 0.0);
        let [least, most] = squares.fold([f64::INFINITY, 0.0], |[least, most], r2| [r2.min(least), r2.max(most)]);
        Ok([least.min(most).sqrt() * self.scene_unit, most.sqrt() * self.scene_unit])
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
