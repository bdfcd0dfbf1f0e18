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

    /// Image to write, .exr or .png; repeat the option to write several images
    ///
    /// An EXR file holds linear radiance and metadata. A PNG file is sRGB, clamped to the range
    /// from 0 to 1. Without this option, the file is the "filename" of the scene's Film.
    #[arg(short, long, value_name = "FILE", value_parser = output_path)]
    pub output: Vec<PathBuf>,

    /// Exposure of PNG images: brighter by a factor of 2 for each stop, or auto
    ///
    /// With auto, the geometric mean of the luminance of all pixels that are not black becomes 0.18, a middle grey. EXR
    /// images keep the radiance as it is.
    #[arg(long, value_name = "STOPS|auto", value_parser = exposure, default_value = "0", allow_negative_numbers = true)]
    pub exposure: Exposure,

    /// Layer to write to EXR images besides the colour; repeat the option for several layers
    #[arg(long, value_parser = aov(), value_name = "NAME", ignore_case = true)]
    pub aov: Vec<&'static Aov>,

    /// Write the times of the render to the metadata of EXR images, as pbrt does
    ///
    /// renderTimeSeconds is the time of the iterations. goblet.totalSeconds includes reading the scene and compiling
    /// the kernels. Without this option, the same render always gives the same file.
    #[arg(long)]
    pub record_times: bool,

    /// Show the image in the viewer tev while it is rendered
    ///
    /// Start tev, or another viewer with tev's protocol, first. tev listens on port 14158, as in
    /// localhost:14158. It receives the image and the layers of --aov up to four times a second.
    #[arg(long, value_name = "HOST:PORT", value_parser = Address::parse)]
    pub display_server: Option<Address>,

    /// How to render, and for how long.
    #[command(flatten)]
    pub request: Request,

    /// Save the state of the render to this file, for --resume or `goblet merge`
    ///
    /// The file is written every --checkpoint-every seconds, at the end, and when a signal stops
    /// the render. It is replaced as a whole, so that a crash leaves the previous checkpoint.
    #[arg(long, value_name = "FILE", help_heading = "Long renders")]
    pub checkpoint: Option<PathBuf>,

    /// Time between checkpoints, in seconds
    #[arg(long, value_name = "SECONDS", value_parser = seconds, default_value = "60")]
    #[arg(help_heading = "Long renders", allow_negative_numbers = true, requires = "checkpoint")]
    pub checkpoint_every: Duration,

    /// Continue a render from its checkpoint
    ///
    /// The scene and the options that change the image must be the same as before. The image is
    /// the same, bit for bit, as that of an uninterrupted render. --iterations includes the
    /// iterations of the checkpoint, and may be larger than before.
    #[arg(long, value_name = "FILE", help_heading = "Long renders")]
    pub resume: Option<PathBuf>,

    /// Render part I of N of the image's iterations, such as 0/4, for `goblet merge`
    ///
    /// Shard I of N renders the rounds I, I + N, I + 2 N and so on, counted from 0. A round is an
    /// iteration, or with --integrator ppm the iterations that share their eye paths. All shards
    /// have the same --iterations, and need --radius-schedule global or --integrator ppm. `auto`
    /// takes I and N from the environment of an array job of Slurm, Kubernetes or AWS Batch. An
    /// image is written only with --output.
    #[arg(long, value_name = "I/N|auto", value_parser = crate::cli::shard::parse, help_heading = "Long renders")]
    #[arg(requires = "checkpoint")]
    pub shard: Option<Shard>,

    /// Device to use: its index, or a part of its name, from `goblet devices` [default: the first that can render]
    #[arg(long, value_name = "INDEX|NAME", help_heading = "Device", display_order = 0)]
    pub device: Option<String>,

    /// Turn on the Vulkan validation layers, which find errors of goblet and of the driver
    #[arg(long, help_heading = "Device")]
    pub validate: bool,

    /// How much memory the scene may take.
    #[command(flatten)]
    pub scene_memory: SceneMemory,

    /// Write times, counts and memory of the render to this file, as JSON
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
