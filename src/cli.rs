//! The command line: what it accepts, and what its help says.
//!
//! A value is rejected here if no scene and no device could make sense of it;
//! clap then prints the reason and exits with code 2.

pub mod compare;
pub mod devices;
mod failure;
pub mod render;
mod solver;
mod stats;
pub mod tessellate;

pub use failure::Failure;

use std::fmt::Display;
use std::ops::RangeInclusive;
use std::path::PathBuf;
use std::str::FromStr;
use std::time::Duration;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, Parser, Subcommand};

use crate::pack::RevolutionSolver;
use crate::{output, tessellate as mesh};

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
    /// Options that are left out take the scene's own values. Exit codes: 0 done,
    /// 1 the render, the device or an output failed, 2 wrong usage or scene.
    Render(RenderArgs),
    /// Measure how far an image is from a reference
    ///
    /// Reads EXR, PNG, PFM and HDR. Exit codes: 0 done and every limit kept,
    /// 1 a limit exceeded, 2 wrong usage or an image that cannot be compared.
    Compare(CompareArgs),
    /// Write a scene with triangle meshes in place of its bodies of revolution
    ///
    /// Other renderers read the result: included files are put in their place, the
    /// rest of the text is kept, and the meshes are written beside it as OUT-1.ply,
    /// OUT-2.ply and so on. Exit codes: 0 done, 1 a file cannot be written, 2 wrong
    /// usage or scene.
    Tessellate(TessellateArgs),
    /// List the Vulkan devices and whether they can render
    Devices(DevicesArgs),
}

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
    #[arg(long, value_name = "P", value_parser = positive_u64, help_heading = "Quality")]
    #[arg(allow_negative_numbers = true)]
    pub photons: Option<u64>,

    /// Initial gather radius in scene units [default: the scene's]
    #[arg(long, value_name = "R", value_parser = radius, help_heading = "Quality")]
    #[arg(allow_negative_numbers = true)]
    pub radius: Option<f64>,

    /// Share of new photons kept when the radius shrinks, above 0 up to 1
    ///
    /// Smaller values shrink the radius faster: less blur, more noise.
    #[arg(long, value_name = "A", value_parser = alpha, help_heading = "Quality")]
    #[arg(allow_negative_numbers = true)]
    pub alpha: Option<f64>,

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

    /// Write times, counts and memory of the render as JSON
    #[arg(long, value_name = "FILE")]
    pub stats: Option<PathBuf>,

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
}

/// Arguments of `goblet devices`.
#[derive(Args, Clone, Copy, Debug)]
pub struct DevicesArgs {}

fn workgroup_sizes() -> impl TypedValueParser<Value = u32> {
    PossibleValuesParser::new(["32", "64", "128"]).try_map(|size| size.parse::<u32>())
}

fn output_path(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    match output::check_extension(&path) {
        Ok(()) => Ok(path),
        Err(_) => Err(format!("expected a file name ending in {}", output::WRITABLE_EXTENSIONS.replace("and", "or"))),
    }
}

fn scene_path(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    match (path.file_stem(), path.extension()) {
        (Some(_), Some(extension)) if extension == "pbrt" => Ok(path),
        _ => Err("expected a file name ending in .pbrt".to_owned()),
    }
}

fn positive_u64(text: &str) -> Result<u64, String> {
    whole_number(text, 1..=u64::MAX)
}

fn positive_u32(text: &str) -> Result<u32, String> {
    whole_number(text, 1..=u32::MAX)
}

fn seed(text: &str) -> Result<u32, String> {
    whole_number(text, 0..=u32::MAX)
}

fn whole_number<T>(text: &str, range: RangeInclusive<T>) -> Result<T, String>
where
    T: FromStr + PartialOrd + Display,
{
    text.parse()
        .ok()
        .filter(|value| range.contains(value))
        .ok_or_else(|| format!("expected a whole number from {} to {}", range.start(), range.end()))
}

fn number(text: &str, accepted: impl Fn(f64) -> bool, expected: &str) -> Result<f64, String> {
    text.parse().ok().filter(|&value| accepted(value)).ok_or_else(|| format!("expected {expected}"))
}

fn radius(text: &str) -> Result<f64, String> {
    // The kernels square it in 32-bit floats.
    let accepted = |radius| (1e-18..=1e18).contains(&radius);
    number(text, accepted, "a length above 0, from 1e-18 to 1e18")
}

fn alpha(text: &str) -> Result<f64, String> {
    // As it is on the device: not rounded to zero.
    let accepted = |alpha| (f64::from(f32::MIN_POSITIVE)..=1.0).contains(&alpha);
    number(text, accepted, "a number above 0 and at most 1")
}

fn tolerance(text: &str) -> Result<f64, String> {
    let [least, most] = mesh::TOLERANCES;
    number(text, |tolerance| (least..=most).contains(&tolerance), &format!("a number from {least:e} to {most}"))
}

fn limit(text: &str) -> Result<f64, String> {
    let accepted = |limit: f64| limit.is_finite() && limit >= 0.0;
    number(text, accepted, "a finite number, 0 or more")
}

fn seconds(text: &str) -> Result<Duration, String> {
    text.parse()
        .ok()
        .and_then(|seconds| Duration::try_from_secs_f64(seconds).ok())
        .filter(|time| !time.is_zero())
        .ok_or_else(|| "expected a finite number of seconds above 0".to_owned())
}

fn resolution(text: &str) -> Result<[u32; 2], String> {
    let side = |text: &str| text.parse().ok().filter(|side| (1..=65536).contains(side));
    text.split_once('x')
        .and_then(|(width, height)| Some([side(width)?, side(height)?]))
        .ok_or_else(|| "expected WIDTHxHEIGHT, each from 1 to 65536, such as 640x480".to_owned())
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;
    use crate::pack::Envelopes;

    fn render(arguments: &[&str]) -> Result<RenderArgs, clap::Error> {
        let fixed = ["goblet", "render", "scene.pbrt"];
        match Cli::try_parse_from(fixed.iter().chain(arguments))?.command {
            Command::Render(args) => Ok(args),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn the_definition_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn all_options_of_render_arrive() {
        let args = render(&[
            "-o",
            "a.exr",
            "--output",
            "b.PNG",
            "--iterations",
            "64",
            "--time",
            "1.5",
            "--photons",
            "5000000000",
            "--radius",
            "0.25",
            "--alpha",
            "1",
            "--max-depth",
            "8",
            "--seed",
            "4294967295",
            "--resolution",
            "640x480",
            "--device",
            "llvmpipe",
            "--stats",
            "s.json",
            "--validate",
            "--quiet",
            "--workgroup-size",
            "128",
            "--batch-size",
            "1024",
        ])
        .unwrap();
        assert_eq!(args.output, [PathBuf::from("a.exr"), PathBuf::from("b.PNG")]);
        assert_eq!(args.time, Some(Duration::from_millis(1500)));
        assert_eq!(args.photons, Some(5_000_000_000));
        assert_eq!((args.radius, args.alpha), (Some(0.25), Some(1.0)));
        assert_eq!((args.iterations, args.max_depth), (Some(64), Some(8)));
        assert_eq!((args.seed, args.resolution), (Some(u32::MAX), Some([640, 480])));
        assert_eq!((args.workgroup_size, args.batch_size), (Some(128), Some(1024)));
        assert!(args.validate && args.quiet && args.stats.is_some() && args.device.is_some());
    }

    #[test]
    fn values_that_cannot_be_rendered_are_usage_errors() {
        let cases: &[(&str, &[&str], &str)] = &[
            ("-o", &["a.jpg", "a", ""], ".exr or .png"),
            ("--iterations", &["0", "-1", "1.5", "4294967296"], "from 1 to 4294967295"),
            ("--time", &["0", "-1", "nan", "inf", "1e30", "1e-30", "x"], "seconds above 0"),
            ("--photons", &["0", "-5", "1e6", "18446744073709551616"], "whole number from 1"),
            ("--radius", &["0", "-1", "nan", "inf", "1e30", "1e-30", "x"], "length above 0"),
            ("--alpha", &["0", "-0.5", "1.01", "nan", "inf"], "above 0 and at most 1"),
            ("--max-depth", &["0", "-1"], "whole number from 1"),
            ("--seed", &["-1", "4294967296", "x"], "from 0 to 4294967295"),
            ("--resolution", &["0x0", "1x0", "65537x1", "640", "1x2x3", "-1x1"], ""),
            ("--workgroup-size", &["0", "33", "256"], "32, 64, 128"),
            ("--batch-size", &["0", "4294967296"], "whole number from 1"),
        ];
        for (option, values, expected) in cases {
            for value in *values {
                let error = render(&[option, value]).expect_err(value);
                assert_eq!(error.exit_code(), 2);
                let message = error.to_string();
                assert!(message.contains(expected), "{option} {value}: {message}");
                assert!(message.contains(option), "{option} {value}: {message}");
            }
        }
    }

    #[test]
    fn a_solver_is_chosen_and_only_newtons_has_options() {
        let solver = |arguments: &[&str]| render(arguments).map(|args| args.revolution_solver);
        assert_eq!(solver(&[]).unwrap(), RevolutionSolver::Certified);
        assert_eq!(solver(&["--revolution-solver", "certified"]).unwrap(), RevolutionSolver::Certified);
        let newton = |segments, envelopes| RevolutionSolver::Newton { segments, envelopes };
        let chosen = ["--revolution-solver", "newton"];
        assert_eq!(solver(&chosen).unwrap(), newton(16, Envelopes::Both));
        for (name, which) in [("chord", Envelopes::Chord), ("tangent", Envelopes::Tangent), ("both", Envelopes::Both)] {
            let all = [&chosen[..], &["--newton-segments", "64", "--newton-envelopes", name]].concat();
            assert_eq!(solver(&all).unwrap(), newton(64, which));
        }
        let wrong: &[(&[&str], &str)] = &[
            (&["--newton-segments", "4"], "--newton-segments requires --revolution-solver newton"),
            (&["--newton-envelopes", "both"], "--newton-envelopes requires --revolution-solver newton"),
            (&["--revolution-solver", "certified", "--newton-segments", "4"], "requires --revolution-solver newton"),
            (&["--revolution-solver", "newton", "--newton-segments", "0"], "from 1 to 64"),
            (&["--revolution-solver", "newton", "--newton-segments", "-1"], "from 1 to 64"),
            (&["--revolution-solver", "newton", "--newton-segments", "65"], "from 1 to 64"),
            (&["--revolution-solver", "newton", "--newton-envelopes", "none"], "chord, tangent, both"),
            (&["--revolution-solver", "exact"], "certified, newton"),
        ];
        for (arguments, expected) in wrong {
            let error = solver(arguments).expect_err(expected);
            assert_eq!(error.exit_code(), 2);
            assert!(error.to_string().contains(expected), "{arguments:?}: {error}");
        }
    }

    #[test]
    fn compare_takes_two_images_and_finite_limits() {
        let parse = |arguments: &[&str]| Cli::try_parse_from(["goblet", "compare"].iter().chain(arguments));
        assert!(parse(&["a.exr"]).is_err());
        assert!(parse(&["a.exr", "b.exr", "--max-relmse", "nan"]).is_err());
        assert!(parse(&["a.exr", "b.exr", "--max-energy", "-1"]).is_err());
        assert!(parse(&["a.exr", "b.exr", "--diff", "d.gif"]).is_err());
        let cli = parse(&["a.exr", "b.exr", "--max-relmse", "0.01", "--json"]).unwrap();
        let Command::Compare(args) = cli.command else {
            panic!("{cli:?}");
        };
        assert_eq!((args.max_relmse, args.max_energy, args.json), (Some(0.01), None, true));
    }
}
