//! The command line: subcommands, arguments and their help.
//!
//! A value that no scene and no device could use is rejected here; clap prints the reason and exits with
//! code 2.

#[cfg(feature = "study")]
pub mod advise;
pub mod cache;
pub mod compare;
pub mod devices;
mod failure;
pub mod info;
pub mod manual;
#[cfg(feature = "study")]
pub mod measure;
mod memory;
pub mod merge;
pub(crate) mod outputs;
pub mod render;
mod shard;
pub(crate) mod stats;
pub mod terminal;
pub mod tessellate;
mod values;

#[cfg(feature = "study")]
pub use advise::AdviseArgs;
pub use failure::Failure;
pub use manual::{CompletionsArgs, ManArgs};
#[cfg(feature = "study")]
pub use measure::MeasureArgs;
pub use memory::SceneMemory;
pub use render::RenderArgs;

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};

use values::{aov, exposure, limit, output_path, scene_path, tolerance};

use crate::image::exposure::Exposure;
use crate::render::aov::Aov;

/// A progressive photon mapper that runs as Vulkan compute.
#[derive(Debug, Parser)]
#[command(name = "goblet", version)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// The subcommands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render a pbrt-v4 scene to an image
    ///
    /// Options that are left out take the scene's own values. Ctrl-C, SIGTERM and SIGHUP finish
    /// the iteration in flight and write what there is; once more stops at once, and so does the
    /// first before the first iteration. Exit codes: 0 done, 1 the render, the device or an output
    /// failed, 2 wrong usage, scene or checkpoint, 130 stopped by a signal before it was done.
    Render(Box<RenderArgs>),
    /// Show a pbrt-v4 scene in a window, and move the camera in it
    ///
    /// Takes the options of `goblet render`, but for those of long renders. Without
    /// --iterations, it goes on until the window is closed; --output is the file that the panel
    /// saves to, and --stats has how long events waited for a frame. Exit codes: 0 closed, 1 no
    /// display, or the device failed, 2 wrong usage or scene.
    #[cfg(feature = "view")]
    View(Box<RenderArgs>),
    /// Add the checkpoints of shards, and write their image
    ///
    /// The order of the files does not matter, and the image is the same, bit for bit, as
    /// if one process had rendered all iterations. Exit codes: 0 done, 1 an output cannot
    /// be written, 2 wrong usage, or checkpoints that do not belong together.
    Merge(MergeArgs),
    /// Measure how far an image is from a reference
    ///
    /// Reads EXR, PNG, PFM and HDR. Exit codes: 0 done and every limit kept,
    /// 1 a limit exceeded, 2 wrong usage or an image that cannot be compared.
    Compare(CompareArgs),
    /// Measure what settings are worth: error against time, on this device
    ///
    /// Renders each combination of the values that --vary lists, in turns, and compares
    /// with a reference on the way. Writes results.json, results.csv and report.html, a page
    /// with plots that needs nothing else, after every turn. Exit codes: 0 done, 1 the device
    /// or an output failed, 2 wrong usage, scene or reference.
    #[cfg(feature = "study")]
    Measure(MeasureArgs),
    /// Say which settings to use for a time or an error, from a short probe on this device
    ///
    /// The error is relative and of noise and blur together. Prints the `goblet render`
    /// command. Exit codes: 0 done, 1 the device failed, 2 wrong usage or scene.
    #[cfg(feature = "study")]
    Advise(AdviseArgs),
    /// Write a scene with triangle meshes in place of its bodies of revolution
    ///
    /// Other renderers read the result: included files are put in their place, the
    /// rest of the text is kept, and the meshes are written beside it as OUT-1.ply,
    /// OUT-2.ply and so on. Exit codes: 0 done, 1 a file cannot be written, 2 wrong
    /// usage or scene.
    Tessellate(TessellateArgs),
    /// Say what is in a scene, what it needs, and what of it is not supported
    ///
    /// Needs no device. Exit codes: 0 the scene can be rendered, 2 wrong usage, or a scene
    /// that cannot.
    Info(InfoArgs),
    /// List the Vulkan devices and whether they can render
    Devices(DevicesArgs),
    /// Print a script that completes goblet's arguments in a shell
    ///
    /// For bash: goblet completions bash > ~/.local/share/bash-completion/completions/goblet
    Completions(CompletionsArgs),
    /// Print the manual page, for man
    ///
    /// To read it: goblet man > goblet.1 && man ./goblet.1
    Man(ManArgs),
}

/// Arguments of `goblet merge`.
#[derive(Args, Clone, Debug)]
pub struct MergeArgs {
    /// The checkpoints that `goblet render --shard` has written
    #[arg(value_name = "CHECKPOINT", required = true)]
    pub checkpoints: Vec<PathBuf>,

    /// Image to write, .exr or .png; repeat it for more than one
    #[arg(short, long, value_name = "FILE", value_parser = output_path, required_unless_present = "checkpoint")]
    pub output: Vec<PathBuf>,

    /// Write the sum as a checkpoint too, to merge it with further shards
    #[arg(long, value_name = "FILE")]
    pub checkpoint: Option<PathBuf>,

    /// Exposure of PNGs in stops, or auto
    ///
    /// A stop doubles the brightness. With auto, the geometric mean of the luminance of all pixels that are not
    /// black becomes 0.18, middle grey. EXRs keep the radiance as it is.
    #[arg(long, value_name = "STOPS|auto", value_parser = exposure, default_value = "0", allow_negative_numbers = true)]
    pub exposure: Exposure,

    /// Further channels of EXR outputs
    #[arg(long, value_parser = aov(), value_name = "NAME", ignore_case = true)]
    pub aov: Vec<&'static Aov>,

    /// Print errors only
    #[arg(short, long)]
    pub quiet: bool,
}

/// Arguments of `goblet compare`.
#[derive(Args, Clone, Debug)]
pub struct CompareArgs {
    /// The image to judge
    #[arg(value_name = "IMAGE")]
    pub image: PathBuf,

    /// The image that is taken to be right, of the same size
    #[arg(value_name = "REFERENCE")]
    pub reference: PathBuf,

    /// Write a picture of the relative error
    ///
    /// Red is too bright, blue too dark, green not finite.
    #[arg(long, value_name = "FILE", value_parser = output_path)]
    pub diff: Option<PathBuf>,

    /// Print JSON; a value that is not finite is null
    #[arg(long)]
    pub json: bool,

    /// Fail when relMSE is above X, with the 0.1 % worst pixels left out
    #[arg(long, value_name = "X", value_parser = limit, allow_negative_numbers = true)]
    pub max_relmse: Option<f64>,

    /// Fail when the mean energy ratio is further than X from 1, over the same pixels
    #[arg(long, value_name = "X", value_parser = limit, allow_negative_numbers = true)]
    pub max_energy: Option<f64>,
}

/// Arguments of `goblet tessellate`.
#[derive(Args, Clone, Debug)]
pub struct TessellateArgs {
    /// The scene, in pbrt-v4's text format
    #[arg(value_name = "IN")]
    pub scene: PathBuf,

    /// Scene to write, ending in .pbrt; none of the files that IN reads
    #[arg(short, long, value_name = "OUT", value_parser = scene_path)]
    pub output: PathBuf,

    /// How far a mesh may be from the true surface, from 1e-7 to 0.1
    ///
    /// In units of the body's size, which is the larger of its diameter and its height
    /// in object space.
    #[arg(long, value_name = "T", value_parser = tolerance, default_value = "1e-4")]
    #[arg(allow_negative_numbers = true)]
    pub tolerance: f64,

    /// How much memory the scene may take.
    #[command(flatten)]
    pub scene_memory: SceneMemory,
}

/// Arguments of `goblet info`.
#[derive(Args, Clone, Debug)]
pub struct InfoArgs {
    /// The scene, in pbrt-v4's text format
    #[arg(value_name = "SCENE")]
    pub scene: PathBuf,

    /// Print JSON
    #[arg(long)]
    pub json: bool,

    /// How much memory the scene may take.
    #[command(flatten)]
    pub scene_memory: SceneMemory,
}

/// Arguments of `goblet devices`.
#[derive(Args, Clone, Copy, Debug)]
pub struct DevicesArgs {}

#[cfg(test)]
mod tests;
