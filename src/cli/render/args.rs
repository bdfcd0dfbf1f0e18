//! Arguments of `goblet render`.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;

use crate::cli::SceneMemory;
use crate::cli::values::{
    Radius, alpha, aov, cell_scale, eye_paths, output_path, photons, positive_u32, radius, resolution, seconds, seed,
    target_error, workgroup_sizes,
};
use crate::gpu_scene::pack::RevolutionSolver;
use crate::render::aov::Aov;
use crate::render::options::{Contribution, DirectLight, Integrator, LookupKind, Options, Sampler};
use crate::render::radius::RadiusSchedule;
use crate::render::sequence::Shard;

/// Arguments of `goblet render`.
#[derive(Args, Clone, Debug)]
pub struct RenderArgs {
    /// The scene, in pbrt-v4's text format
    #[arg(value_name = "SCENE")]
    pub scene: PathBuf,

    /// Image to write, .exr or .png; repeat it for more than one
    ///
    /// EXR holds the linear radiance and the metadata, PNG a clamped sRGB picture.
    /// Without this option the scene's own film filename is written.
    #[arg(short, long, value_name = "FILE", value_parser = output_path)]
    pub output: Vec<PathBuf>,

    /// Stop after this many iterations [default: the sampler's pixelsamples]
    #[arg(long, value_name = "N", value_parser = positive_u32, help_heading = "Quality")]
    #[arg(allow_negative_numbers = true)]
    pub iterations: Option<u32>,

    /// Stop after this much render time, at the end of an iteration
    ///
    /// With --iterations as well, whichever comes first.
    #[arg(long, value_name = "SECONDS", value_parser = seconds, help_heading = "Quality")]
    #[arg(allow_negative_numbers = true)]
    pub time: Option<Duration>,

    /// Photons emitted per iteration [default: the scene's, else one per pixel]
    #[arg(long, value_name = "P", value_parser = photons, help_heading = "Quality")]
    #[arg(allow_negative_numbers = true)]
    pub photons: Option<u64>,

    /// Eye paths per pixel and iteration [default: 4]
    ///
    /// All bring direct light and smooth edges; the last one brings what photons bring.
    #[arg(long, value_name = "N", value_parser = eye_paths, help_heading = "Quality")]
    #[arg(allow_negative_numbers = true)]
    pub eye_paths: Option<u32>,

    /// Initial gather radius in scene units, or in pixels: 2px [default: the scene's, else 3px]
    ///
    /// Pixels are as wide as they are where they are seen.
    #[arg(long, value_name = "R", value_parser = radius, help_heading = "Quality")]
    #[arg(allow_negative_numbers = true)]
    pub radius: Option<Radius>,

    /// Share of new photons kept when the radius shrinks, above 0 up to 1
    ///
    /// Smaller values shrink the radius faster: less blur, more noise.
    #[arg(long, value_name = "A", value_parser = alpha, help_heading = "Quality")]
    #[arg(allow_negative_numbers = true)]
    pub alpha: Option<f64>,

    /// Stop when the estimated relative error of the image is below this
    ///
    /// The estimate is of noise, not of blur: the root mean square over pixels of standard
    /// error over luminance.
    #[arg(long, value_name = "E", value_parser = target_error, help_heading = "Quality")]
    #[arg(allow_negative_numbers = true)]
    pub target_error: Option<f64>,

    /// The most segments of a light or eye path [default: the scene's]
    #[arg(long, value_name = "D", value_parser = positive_u32, help_heading = "Quality")]
    #[arg(allow_negative_numbers = true)]
    pub max_depth: Option<u32>,

    /// Seed of every random number, 0 to 4294967295 [default: the scene's]
    #[arg(long, value_name = "S", value_parser = seed, help_heading = "Quality")]
    #[arg(allow_negative_numbers = true)]
    pub seed: Option<u32>,

    /// Image size in pixels, such as 640x480 [default: the scene's]
    #[arg(long, value_name = "WxH", value_parser = resolution, help_heading = "Quality")]
    #[arg(allow_hyphen_values = true)]
    pub resolution: Option<[u32; 2]>,

    /// Further channels of EXR outputs
    #[arg(long, value_parser = aov(|_| true), value_name = "NAME")]
    pub aov: Vec<&'static Aov>,

    /// When new eye paths are traced
    #[arg(long, value_enum, default_value_t, help_heading = "Algorithm")]
    pub integrator: Integrator,

    /// With ppm: photons for which eye paths are kept, in whole iterations [default: 16 iterations]
    #[arg(long, value_name = "P", value_parser = photons, help_heading = "Algorithm")]
    #[arg(allow_negative_numbers = true)]
    pub photons_per_round: Option<u64>,

    /// With ppm: stop after this many rounds, whose images are averaged
    #[arg(long, value_name = "N", value_parser = positive_u32, help_heading = "Algorithm")]
    #[arg(allow_negative_numbers = true, conflicts_with = "iterations")]
    pub rounds: Option<u32>,

    /// Who decides how radii shrink
    #[arg(long, value_enum, value_name = "WHO", default_value_t, help_heading = "Algorithm")]
    pub radius_schedule: RadiusSchedule,

    /// Who brings light that comes straight from a light source
    #[arg(long, value_enum, value_name = "WHO", default_value_t, help_heading = "Algorithm")]
    pub direct: DirectLight,

    /// Where random numbers come from
    #[arg(long, value_enum, default_value_t, help_heading = "Algorithm")]
    pub sampler: Sampler,

    /// How photons find visible points; does not change the image
    #[arg(long, value_enum, value_name = "HOW", default_value_t, help_heading = "Algorithm")]
    pub lookup: LookupKind,

    /// Width of the hash grid's cells, in diameters of the largest disc [default: 1]
    ///
    /// Does not change the image.
    #[arg(long, value_name = "X", value_parser = cell_scale, help_heading = "Algorithm")]
    #[arg(allow_negative_numbers = true)]
    pub cell_scale: Option<f64>,

    /// Save the render here, to be resumed or merged
    ///
    /// Written at the end, now and then before it, and when a signal stops the render; a
    /// crash leaves the last one whole.
    #[arg(long, value_name = "FILE", help_heading = "Long renders")]
    pub checkpoint: Option<PathBuf>,

    /// Time between checkpoints
    #[arg(long, value_name = "SECONDS", value_parser = seconds, default_value = "60")]
    #[arg(help_heading = "Long renders", allow_negative_numbers = true, requires = "checkpoint")]
    pub checkpoint_every: Duration,

    /// Go on from a checkpoint of the same scene and options
    ///
    /// The image is the same, bit for bit, as without the stop. --iterations counts those
    /// of the checkpoint, and may ask for more than it was made with.
    #[arg(long, value_name = "FILE", help_heading = "Long renders")]
    pub resume: Option<PathBuf>,

    /// Render every N-th round from the I-th on, counted from 0, for `goblet merge`
    ///
    /// `auto` takes both from the environment of an array job: Slurm, Kubernetes or AWS
    /// Batch. Writes the checkpoint, and an image only with --output.
    #[arg(long, value_name = "I/N|auto", value_parser = crate::cli::shard::parse, help_heading = "Long renders")]
    #[arg(requires = "checkpoint")]
    pub shard: Option<Shard>,

    /// The device, by its index or part of its name in `goblet devices`
    #[arg(long, value_name = "INDEX|NAME", help_heading = "Device")]
    pub device: Option<String>,

    /// Invocations per workgroup; does not change the image
    #[arg(long, value_name = "SIZE", value_parser = workgroup_sizes(), help_heading = "Device")]
    pub workgroup_size: Option<u32>,

    /// Photons per dispatch; does not change the image
    ///
    /// Smaller batches take less memory and keep each dispatch short.
    #[arg(long, value_name = "PHOTONS", value_parser = positive_u32)]
    #[arg(help_heading = "Device", allow_negative_numbers = true)]
    pub batch_size: Option<u32>,

    /// Turn the Vulkan validation layers on
    #[arg(long, help_heading = "Device")]
    pub validate: bool,

    /// How rays meet bodies of revolution.
    #[command(flatten)]
    pub revolution_solver: RevolutionSolver,

    /// How much memory the scene may take.
    #[command(flatten)]
    pub scene_memory: SceneMemory,

    /// Write times, counts and memory of the render as JSON
    #[arg(long, value_name = "FILE")]
    pub stats: Option<PathBuf>,

    /// Print errors only
    #[arg(short, long)]
    pub quiet: bool,
}

impl RenderArgs {
    /// What it says to the renderer.
    pub fn options(&self) -> Options {
        let (radius, radius_in_pixels) = match self.radius {
            Some(Radius::Length(length)) => (Some(length), None),
            Some(Radius::Pixels(pixels)) => (None, Some(pixels)),
            None => (None, None),
        };
        Options {
            resolution: self.resolution,
            photons: self.photons,
            eye_paths: self.eye_paths,
            radius,
            radius_in_pixels,
            alpha: self.alpha,
            max_depth: self.max_depth,
            seed: self.seed,
            integrator: self.integrator,
            photons_per_round: self.photons_per_round,
            radius_schedule: self.radius_schedule,
            direct: self.direct,
            contribution: Contribution::All,
            sampler: self.sampler,
            shard: self.shard.unwrap_or(Shard::WHOLE),
            lookup: self.lookup,
            cell_scale: self.cell_scale,
            workgroup_size: self.workgroup_size,
            batch_size: self.batch_size.map(u64::from),
            responsive: false,
            revolution_solver: self.revolution_solver,
        }
    }
}
