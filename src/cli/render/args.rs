//! Arguments of `goblet render`.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;

use super::display_server::Address;
use crate::cli::SceneMemory;
use crate::cli::values::{aov, exposure, output_path, seconds};
use crate::image::exposure::Exposure;
use crate::render::aov::{Aov, groups};
use crate::render::options::Options;
use crate::render::options::request::Request;
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

    /// Exposure of PNGs in stops, or auto
    ///
    /// A stop doubles the brightness. With auto, the geometric mean of the luminance of all pixels that are not
    /// black becomes 0.18, middle grey. EXRs keep the radiance as it is.
    #[arg(long, value_name = "STOPS|auto", value_parser = exposure, default_value = "0", allow_negative_numbers = true)]
    pub exposure: Exposure,

    /// Further channels of EXR outputs
    #[arg(long, value_parser = aov(), value_name = "NAME", ignore_case = true)]
    pub aov: Vec<&'static Aov>,

    /// Write the times of the render into EXRs, as pbrt does
    ///
    /// renderTimeSeconds is the time of the iterations, goblet.totalSeconds includes reading the scene and compiling
    /// the kernels. Without this option, the same render gives the same file.
    #[arg(long)]
    pub record_times: bool,

    /// Show the image in tev while it is rendered
    ///
    /// Needs tev, or another viewer with its protocol, that listens there; tev's port is 14158.
    /// The viewer gets the image and the channels of --aov up to four times a second.
    #[arg(long, value_name = "HOST:PORT", value_parser = Address::parse)]
    pub display_server: Option<Address>,

    /// How to render, and for how long.
    #[command(flatten)]
    pub request: Request,

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
    #[arg(long, value_name = "INDEX|NAME", help_heading = "Device", display_order = 0)]
    pub device: Option<String>,

    /// Turn the Vulkan validation layers on
    #[arg(long, help_heading = "Device")]
    pub validate: bool,

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
    /// Returns the options of the request together with the shard and the layers.
    pub fn options(&self) -> Options {
        let (shard, layers) = (self.shard.unwrap_or_default(), groups(&self.aov));
        Options { shard, layers, ..self.request.options.clone() }
    }
}
