//! Arguments of `goblet render`.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;

use crate::cli::SceneMemory;
use crate::cli::values::{aov, host_and_port, output_path, seconds};
use crate::render::aov::Aov;
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

    /// Further channels of EXR outputs
    #[arg(long, value_parser = aov(|_| true), value_name = "NAME")]
    pub aov: Vec<&'static Aov>,

    /// Show the image while it is rendered, in tev or a viewer that takes its messages
    ///
    /// With the channels of --aov, at most once a second. A viewer that fails is left, with
    /// a warning; the render goes on.
    #[arg(long, value_parser = host_and_port, value_name = "HOST:PORT")]
    pub display_server: Option<String>,

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
    /// Returns the options of the request together with the shard.
    pub fn options(&self) -> Options {
        Options { shard: self.shard.unwrap_or_default(), ..self.request.options.clone() }
    }
}
