//! Iterations over a scene on a device.

use std::rc::Rc;
use std::time::{Duration, Instant};

use goblet_host::{Device, Instance};

use crate::buffers::{Buffers, Sizes};
use crate::film::Image;
use crate::iteration::{Passes, Progress, Settings};
use crate::kernels::REQUIREMENTS;
use crate::pack::{PackError, RevolutionSolver, pack};
use crate::scene::Scene;
use crate::schedule::Schedule;
use crate::tally::Tally;
use crate::upload::GpuScene;
use crate::view::pack_camera;

/// Photons of one iteration, at most: they are numbered in 32 bits.
const MAX_PHOTONS: u64 = 1 << 31;
/// Pixels of an image, at most.
const MAX_PIXELS: u64 = 1 << 28;
/// Initial radii, in radii of the scene's bounding sphere.
const RADIUS_RANGE: [f64; 2] = [1e-9, 1e4];
/// The initial radius where nobody gives one, in radii of the scene's bounding sphere.
const DEFAULT_RADIUS: f64 = 0.01;

/// What the caller may ask for; `None` takes the scene's own value.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Width and height in pixels.
    pub resolution: Option<[u32; 2]>,
    /// Photons per iteration.
    pub photons: Option<u64>,
    /// Initial radius in scene units.
    pub radius: Option<f64>,
    /// Share of an iteration's photons that a pixel keeps, in (0, 1]; 2/3 by default.
    pub alpha: Option<f64>,
    /// The most segments of a path.
    pub max_depth: Option<u32>,
    /// Seed of every random number.
    pub seed: Option<u32>,
    /// Invocations per workgroup: 32, 64 (default) or 128. Does not change the image.
    pub workgroup_size: Option<u32>,
    /// Photons per batch. Does not change the image.
    pub batch_size: Option<u64>,
    /// How rays meet bodies of revolution.
    pub revolution_solver: RevolutionSolver,
}

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
    mean_power: f64,
    buffers: Buffers,
    passes: Passes,
    progress: Progress,
    build_time: Duration,
    compile_time: Duration,
    /// Scene units per render unit.
    unit: f64,
}

impl Renderer {
    /// Prepares a scene for rendering: builds the hierarchy, uploads, compiles.
    ///
    /// # Errors
    /// The scene has nothing to render, an option is out of range, or the device has not
    /// enough memory.
    pub fn new(device: Rc<Device>, scene: &Scene, options: &Options) -> Result<Self, RenderError> {
        let start = Instant::now();
        let resolution = options.resolution.unwrap_or(scene.film.resolution);
        let pixels = u64::from(resolution[0]) * u64::from(resolution[1]);
        let max_depth = options.max_depth.unwrap_or(scene.integrator.max_depth);
        let photons = options.photons.or(scene.integrator.photons_per_iteration).unwrap_or(pixels);
        check(pixels > 0 && pixels <= MAX_PIXELS, || {
            format!("an image of {pixels} pixels: expected 1 to {MAX_PIXELS}")
        })?;
        check(photons > 0 && photons <= MAX_PHOTONS, || {
            format!("{photons} photons per iteration: expected 1 to {MAX_PHOTONS}")
        })?;
        check(max_depth > 0, || "a maximum depth of 0: expected 1 or more".into())?;
        let solver = options.revolution_solver;
        check(solver.is_valid(), || {
            format!("a revolution solver of {solver:?}: expected {:?} segments", RevolutionSolver::SEGMENTS)
        })?;

        let packed = pack(scene, solver)?;
        let unit = 1.0 / packed.space.scale;
        let size = packed.space.radius * unit;
        let radius = options.radius.or(scene.integrator.radius).unwrap_or(DEFAULT_RADIUS * size);
        let [least, most] = RADIUS_RANGE.map(|bound| bound * size);
        check(radius >= least && radius <= most, || {
            format!("a radius of {radius}: expected {least:e} to {most:e} for a scene of this size")
        })?;
        let alpha = options.alpha.unwrap_or(2.0 / 3.0);
        check(alpha > 0.0 && alpha <= 1.0, || format!("an alpha of {alpha}: expected above 0, up to 1"))?;

        let sizes = Sizes::new(pixels, photons, max_depth);
        let camera = pack_camera(&scene.camera, &scene.film, resolution, &packed.space.from_world());
        let render_radius = radius / unit;
        let seed = options.seed.unwrap_or(scene.integrator.seed);
        let gpu_scene = GpuScene::new(&device, &packed, max_depth, seed)?;
        let buffers = Buffers::new(&device, sizes, camera, (render_radius * render_radius) as f32)?;
        let build_time = start.elapsed();

        let start = Instant::now();
        let workgroup_size = options.workgroup_size.unwrap_or(64);
        let passes = Passes::new(&device, &gpu_scene, &buffers, &packed.specialization, workgroup_size)?;
        Ok(Self {
            resolution,
            settings: Settings { photons, alpha: alpha as f32, sizes },
            mean_power: packed.mean_power,
            buffers,
            passes,
            progress: Progress {
                iteration: 0,
                schedule: Schedule::new(options.batch_size, sizes.max_batch(max_depth), device.info().kind),
                tally: Tally::default(),
            },
            build_time,
            compile_time: start.elapsed(),
            unit,
            device,
        })
    }

    /// Runs one iteration.
    ///
    /// # Errors
    /// The device fails; earlier iterations are not lost while it still answers.
    pub fn step(&mut self) -> Result<(), RenderError> {
        self.passes.run(&self.device, &self.buffers, &self.settings, &mut self.progress)
    }

    /// The image after the iterations so far; black before the first.
    ///
    /// # Errors
    /// The device fails.
    pub fn resolve(&self) -> Result<Image, RenderError> {
        let [width, height] = self.resolution;
        if self.progress.iteration == 0 {
            return Ok(Image::new(width, height));
        }
        self.passes.resolve(
            &self.device,
            self.settings.sizes.pixels,
            self.progress.iteration,
            self.photons(),
            self.mean_power,
        )?;
        let pixels = self.device.read(&self.buffers.image)?;
        let pixels = pixels.into_iter().map(|[r, g, b, _]| [r, g, b]).collect();
        Ok(Image { width, height, pixels })
    }

    /// Iterations finished.
    pub fn iterations(&self) -> u32 {
        self.progress.iteration
    }

    /// Photons emitted by the iterations so far.
    pub fn photons(&self) -> u64 {
        self.settings.photons * u64::from(self.progress.iteration)
    }

    /// What happened to them.
    pub fn tally(&self) -> &Tally {
        &self.progress.tally
    }

    /// The smallest and largest radius of a pixel now, scene units.
    ///
    /// # Errors
    /// The device fails.
    pub fn radius_range(&self) -> Result<[f64; 2], RenderError> {
        let estimates = self.device.read(&self.buffers.pixel_flux)?;
        let squares = estimates.iter().map(|estimate| f64::from(estimate[3]));
        let (least, most) = squares.fold((f64::INFINITY, 0.0), |(least, most), r2| (r2.min(least), r2.max(most)));
        Ok([least.sqrt() * self.unit, most.sqrt() * self.unit])
    }

    /// Time to build the hierarchy and to upload.
    pub fn build_time(&self) -> Duration {
        self.build_time
    }

    /// Time to compile the kernels.
    pub fn compile_time(&self) -> Duration {
        self.compile_time
    }

    /// The device it runs on.
    pub fn device(&self) -> &Device {
        &self.device
    }
}

fn check(holds: bool, message: impl FnOnce() -> String) -> Result<(), RenderError> {
    if holds { Ok(()) } else { Err(RenderError::Option(message())) }
}
