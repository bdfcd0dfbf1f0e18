//! The subcommand `goblet advise`: recommends settings for a render time or an error.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use clap::Args;
use serde::Serialize;

use super::cache::open_device;
use super::values::{resolution, seconds, target_error};
use super::{Failure, SceneMemory, terminal};
use crate::render::options::Options;
use crate::scene::Scene;
use crate::study::advise::{Advice, Expected, Goal, Length, advise};

/// The share of the render time that is spent on the probe, within [`PROBE_SECONDS`].
const PROBE_SHARE: f64 = 0.2;
const PROBE_SECONDS: [f64; 2] = [3.0, 30.0];
const PROBE_FOR_ERROR: f64 = 10.0;

/// Arguments of `goblet advise`.
#[derive(Args, Clone, Debug)]
pub struct AdviseArgs {
    /// The scene, in pbrt-v4's text format
    #[arg(value_name = "SCENE")]
    pub scene: PathBuf,

    /// Time available for the render, in seconds
    #[arg(long, value_name = "SECONDS", value_parser = seconds, required_unless_present = "error")]
    #[arg(allow_negative_numbers = true)]
    pub time: Option<Duration>,

    /// Relative error to reach, such as 0.05: the root mean square over pixels of noise and blur
    #[arg(long, value_name = "E", value_parser = target_error, conflicts_with = "time")]
    #[arg(allow_negative_numbers = true)]
    pub error: Option<f64>,

    /// Approximate time of the probe, in seconds [default: a fifth of --time, from 3 to 30; 10 with --error]
    #[arg(long, value_name = "SECONDS", value_parser = seconds, allow_negative_numbers = true)]
    pub probe: Option<Duration>,

    /// Width and height of the image in pixels, such as 640x480 [default: the scene's]
    #[arg(long, value_name = "WxH", value_parser = resolution, allow_hyphen_values = true)]
    pub resolution: Option<[u32; 2]>,

    /// Device to use: its index, or a part of its name, from `goblet devices` [default: the first that can render]
    #[arg(long, value_name = "INDEX|NAME")]
    pub device: Option<String>,

    /// How much memory the scene may take.
    #[command(flatten)]
    pub scene_memory: SceneMemory,

    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// The result that is printed.
#[derive(Serialize)]
struct Report {
    device: String,
    probe_seconds: f64,
    /// The options of `goblet render`.
    options: Vec<String>,
    expected: Expected,
    by_default: Expected,
    /// The numbers that `--photons auto --eye-paths auto` chooses, and why.
    auto: String,
    command: String,
}

/// Probes a scene and prints the recommended settings.
///
/// # Errors
/// The scene cannot be rendered, the device fails, or standard output cannot be written to.
pub fn run(args: &AdviseArgs) -> Result<(), Failure> {
    let scene = Scene::load_within(&args.scene, args.scene_memory.budget())?;
    for warning in &scene.warnings {
        terminal::warn(warning);
    }
    let time = args.time.map_or(0.0, |time| time.as_secs_f64());
    let goal = args.error.map_or(Goal::Time(time), Goal::Error);
    let usual = match goal {
        Goal::Time(seconds) => (PROBE_SHARE * seconds).clamp(PROBE_SECONDS[0], PROBE_SECONDS[1]),
        Goal::Error(_) => PROBE_FOR_ERROR,
    };
    let probe = args.probe.unwrap_or(Duration::from_secs_f64(usual));
    let device = Arc::new(open_device(args.device.as_deref(), false)?);
    let base = Options { resolution: args.resolution, ..Options::default() };
    let advice = advise(&device, &scene, &base, goal, Length::Time(probe))?;
    let options = options(args, &advice);
    let report = Report {
        device: device.info().name.clone(),
        probe_seconds: advice.probe_seconds,
        command: format!("goblet render {} {}", args.scene.display(), options.join(" ")),
        options,
        expected: advice.expected,
        by_default: advice.by_default,
        auto: advice.auto.to_string(),
    };
    terminal::print(&if args.json { report.json()? } else { report.text() })
}

fn options(args: &AdviseArgs, advice: &Advice) -> Vec<String> {
    let Options { eye_paths, photons, radius, radius_in_pixels, resolution, .. } = &advice.options;
    let mut options = Vec::new();
    let mut add = |name: &str, value: Option<String>| options.extend(value.map(|value| format!("--{name} {value}")));
    add("resolution", resolution.map(|[width, height]| format!("{width}x{height}")));
    add("eye-paths", eye_paths.map(|count| count.to_string()));
    add("photons", photons.map(|count| count.to_string()));
    add("radius", radius.map(|radius| radius.to_string()));
    add("radius", radius_in_pixels.map(|pixels| format!("{pixels}px")));
    match args.time {
        Some(time) => add("time", Some(time.as_secs_f64().to_string())),
        None => add("iterations", Some(advice.expected.iterations.to_string())),
    }
    options
}

impl Report {
    fn json(&self) -> Result<String, Failure> {
        let json = serde_json::to_string_pretty(self).map_err(|error| Failure::Print(error.into()))?;
        Ok(json + "\n")
    }

    fn text(&self) -> String {
        let Self { device, probe_seconds, expected, by_default, auto, command, .. } = self;
        let line = |it: &Expected| format!("{:.4} after {:.1} s, {} iterations", it.error, it.seconds, it.iterations);
        let parts = expected.parts;
        format!(
            "probe      {probe_seconds:.1} s on {device}\n\
             expect     {} (relative error of noise and blur)\n\
             made of    {:.0} % noise of eye paths, {:.0} % noise of photons, {:.0} % blur (shares of the squared error)\n\
             default    {}\n\
             auto       {auto}\n\
             {command}\n",
            line(expected),
            100.0 * parts.eye,
            100.0 * parts.photons,
            100.0 * parts.blur,
            line(by_default),
        )
    }
}
