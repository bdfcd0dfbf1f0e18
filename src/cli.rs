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
pub(crate) mod status;
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

use values::{aov, exposure, limit, named, output_path, positive, scene_path, tolerance};

use crate::base::names::Named;
use crate::image::difference::Difference;
use crate::image::exposure::Exposure;
use crate::render::aov::Aov;

/// Renders pbrt-v4 scenes with caustics by progressive photon mapping, on a GPU or a CPU through Vulkan.
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
    /// In each iteration, eye paths run from each pixel to a visible point, the first diffuse
    /// surface that they meet, and photons run from the lights. A pixel sums the photons within
    /// the gather radius of its visible point. The radius blurs the image; it shrinks from
    /// iteration to iteration, so that noise and blur both vanish.
    ///
    /// No option is required: the scene has most settings, and the others have defaults.
    /// docs/guide.md explains rendering, docs/settings.md what the options do to noise, blur and
    /// time, docs/glossary.md the terms.
    ///
    /// Ctrl-C (or SIGTERM, SIGHUP) finishes the running iteration, writes the images and the
    /// checkpoint, and exits. A second Ctrl-C, or one before the first iteration, exits at once
    /// and writes nothing.
    ///
    /// Exit codes: 0 done; 1 the render, the device or an output failed; 2 wrong usage, scene or
    /// checkpoint; 130 stopped early by a signal.
    Render(Box<RenderArgs>),
    /// Show a pbrt-v4 scene in a window, and move the camera in it
    ///
    /// Accepts the options of `goblet render`, except --time, --target-error, --rounds,
    /// --checkpoint, --resume and --shard. Without --iterations, the render continues until the
    /// window is closed. --output is the file to which the panel saves. --stats writes how long
    /// input waited for a frame.
    ///
    /// Exit codes: 0 the window was closed; 1 no display, or the device failed; 2 wrong usage or
    /// scene.
    #[cfg(feature = "view")]
    View(Box<RenderArgs>),
    /// Add up the checkpoints of shards and write their common image
    ///
    /// A shard is the part of a render that one process has rendered: see `goblet render --shard`.
    /// The order of the files does not matter. The image is the same, bit for bit, as if one
    /// process had rendered all iterations.
    ///
    /// Exit codes: 0 done; 1 an output cannot be written; 2 wrong usage, or checkpoints of
    /// different renders.
    Merge(MergeArgs),
    /// Compare an image with a reference, and print the error
    ///
    /// Prints the mean energy ratio (mean of the image / mean of the reference), relMSE (mean of
    /// difference² / (reference² + 0.01)), RMSE and the largest difference.
    /// Reads EXR, HDR, JPEG, PFM, PNG and TGA files. With a limit (--max-...), the command can be a
    /// test in CI.
    ///
    /// Exit codes: 0 no limit exceeded; 1 a limit exceeded; 2 wrong usage, or images that cannot
    /// be compared.
    Compare(CompareArgs),
    /// Compare settings of a scene: the error of each against render time, on this device
    ///
    /// Renders the scene with each combination of the values that --vary lists, and compares the
    /// images with a reference while they are rendered. In a turn, every setting is rendered once,
    /// with the same seed. After each turn, it writes results.json, results.csv and report.html, a
    /// page with plots that needs no network.
    ///
    /// Exit codes: 0 done; 1 the device or an output failed; 2 wrong usage, scene or reference.
    #[cfg(feature = "study")]
    Measure(MeasureArgs),
    /// Suggest settings for a given render time or a given error
    ///
    /// Renders a short probe of the scene on this device, and prints the `goblet render` command
    /// that has the least error for --time, or takes the shortest time for --error. The relative
    /// error contains both noise and blur.
    ///
    /// Exit codes: 0 done; 1 the device failed; 2 wrong usage or scene.
    #[cfg(feature = "study")]
    Advise(AdviseArgs),
    /// Replace the bodies of revolution of a scene by triangle meshes
    ///
    /// The result is for renderers that do not know bodies of revolution. Included files are
    /// inlined and all other text is kept. The meshes are written beside OUT as OUT-1.ply,
    /// OUT-2.ply and so on.
    ///
    /// Exit codes: 0 done; 1 a file cannot be written; 2 wrong usage or scene.
    Tessellate(TessellateArgs),
    /// Check a scene: list its contents, its memory, warnings and unsupported features
    ///
    /// Needs no device.
    ///
    /// Exit codes: 0 the scene can be rendered; 2 wrong usage, or the scene cannot be rendered.
    Info(InfoArgs),
    /// List the Vulkan devices, and say whether they can render
    Devices(DevicesArgs),
    /// Print a completion script for a shell
    ///
    /// For bash: goblet completions bash > ~/.local/share/bash-completion/completions/goblet
    Completions(CompletionsArgs),
    /// Print the manual page in the format of man
    ///
    /// To read it: goblet man > goblet.1 && man ./goblet.1
    Man(ManArgs),
}

/// Arguments of `goblet merge`.
#[derive(Args, Clone, Debug)]
pub struct MergeArgs {
    /// Checkpoints that `goblet render --shard` has written
    #[arg(value_name = "CHECKPOINT", required = true)]
    pub checkpoints: Vec<PathBuf>,

    /// Image to write, .exr or .png; repeat the option to write several images
    #[arg(short, long, value_name = "FILE", value_parser = output_path, required_unless_present = "checkpoint")]
    pub output: Vec<PathBuf>,

    /// Checkpoint to write: the sum of the shards, which can be merged with further shards
    #[arg(long, value_name = "FILE")]
    pub checkpoint: Option<PathBuf>,

    /// Exposure of PNG images: brighter by a factor of 2 for each stop, or auto
    ///
    /// With auto, the geometric mean of the luminance of all pixels that are not black becomes 0.18, a middle grey. EXR
    /// images keep the radiance as it is.
    #[arg(long, value_name = "STOPS|auto", value_parser = exposure, default_value = "0", allow_negative_numbers = true)]
    pub exposure: Exposure,

    /// Layer to write to EXR images besides the colour; repeat the option for several layers
    #[arg(long, value_parser = aov(), value_name = "NAME", ignore_case = true)]
    pub aov: Vec<&'static Aov>,

    /// Print errors only
    #[arg(short, long)]
    pub quiet: bool,
}

/// Arguments of `goblet compare`.
#[derive(Args, Clone, Debug)]
pub struct CompareArgs {
    /// The image to compare
    #[arg(value_name = "IMAGE")]
    pub image: PathBuf,

    /// The reference: an image of the same size that is taken as correct
    #[arg(value_name = "REFERENCE")]
    pub reference: PathBuf,

    /// Write a map of the difference: a .png in false colours with their scale, or an .exr
    ///
    /// An EXR has the values of the map, without colours and scale. In a PNG, what is not
    /// finite is green.
    #[arg(long, value_name = "FILE", value_parser = output_path)]
    pub diff: Option<PathBuf>,

    /// Quantity of the map
    #[arg(long, value_name = "KIND", value_parser = named::<Difference>(), default_value = Difference::default().name())]
    #[arg(requires = "diff")]
    pub diff_kind: Difference,

    /// Value at the end of the map's scale [default: for flip 1, else a round value above 99 % of the pixels]
    #[arg(long, value_name = "X", value_parser = positive, allow_negative_numbers = true, requires = "diff")]
    pub diff_max: Option<f64>,

    /// Exposure at which FLIP sees both images, and --side-by-side shows them: stops, or auto
    ///
    /// A stop doubles the brightness. With auto, the geometric mean of the reference's luminance becomes 0.18, middle
    /// grey. No other number depends on it.
    #[arg(long, value_name = "STOPS|auto", value_parser = exposure, default_value = "0", allow_negative_numbers = true)]
    pub exposure: Exposure,

    /// Put the image and the reference beside the map, in the same PNG
    #[arg(long, requires = "diff")]
    pub side_by_side: bool,

    /// Print JSON; a value that is not finite is null
    #[arg(long)]
    pub json: bool,

    /// Exit with code 1 if relMSE, without the 0.1 % worst pixels, is above X
    #[arg(long, value_name = "X", value_parser = limit, allow_negative_numbers = true)]
    pub max_relmse: Option<f64>,

    /// Exit with code 1 if the mean energy ratio of these pixels differs from 1 by more than X
    #[arg(long, value_name = "X", value_parser = limit, allow_negative_numbers = true)]
    pub max_energy: Option<f64>,
}

/// Arguments of `goblet tessellate`.
#[derive(Args, Clone, Debug)]
pub struct TessellateArgs {
    /// The scene, in pbrt-v4's text format
    #[arg(value_name = "IN")]
    pub scene: PathBuf,

    /// Scene file to write, ending in .pbrt; it must not be a file that IN reads
    #[arg(short, long, value_name = "OUT", value_parser = scene_path)]
    pub output: PathBuf,

    /// Largest distance between a mesh and the true surface, relative to the body's size, 1e-7 to 0.1
    ///
    /// The size of a body is the larger of its diameter and its height in object space.
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
pub struct DevicesArgs {
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

#[cfg(test)]
mod tests;
