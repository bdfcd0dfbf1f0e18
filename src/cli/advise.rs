//! The subcommand `goblet advise`: recommends settings for a render time or an error.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use clap::Args;
use serde::Serialize;

use super::cache::open_device;
use super::status::{Line, Status, of_limit};
use super::values::{resolution, seconds, target_error};
use super::{Failure, SceneMemory, terminal};
use crate::render::activity::Activity;
use crate::render::options::Options;
use crate::scene::Scene;
use crate::study::advise::{Advice, Expected, Goal, Length, advise};

/// The seconds that advice takes in all, at least and at most, unless it is given: within them, those of the render.
const SECONDS: [f64; 2] = [5.0, 30.0];
const SECONDS_FOR_ERROR: f64 = 15.0;

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

    /// Time that the advice takes, in seconds [default: --time, from 5 to 30; 15 with --error]
    ///
    /// goblet reads the scene, compiles the kernels once and makes the trial of --photons auto. The rest of the time, at
    /// least a quarter, is for five short renders with other radii, eye paths and photons. The last of them has the
    /// advised settings and three sevenths of the rest. If the time is short for the image, they have fewer pixels.
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

    /// Print errors only, and no progress
    #[arg(short, long)]
    pub quiet: bool,
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
    let start = Instant::now();
    let status = Status::new(Activity::ReadingScene, args.quiet);
    let time = args.time.map_or(0.0, |time| time.as_secs_f64());
    let goal = args.error.map_or(Goal::Time(time), Goal::Error);
    let usual = match goal {
        Goal::Time(seconds) => seconds.clamp(SECONDS[0], SECONDS[1]),
        Goal::Error(_) => SECONDS_FOR_ERROR,
    };
    let budget = args.probe.unwrap_or(Duration::from_secs_f64(usual));
    status.show(Box::new(move |since| Line {
        share: Some(start.elapsed().as_secs_f64() / budget.as_secs_f64()),
        parts: vec![since.to_string(), format!("{} in all", of_limit(start.elapsed(), budget))],
    }));
    let scene = Scene::load_within(&args.scene, args.scene_memory.budget())?;
    for warning in scene.warnings.iter().filter(|_| !args.quiet) {
        terminal::warn(warning);
    }
    status.note(Activity::OpeningDevice);
    let device = Arc::new(open_device(args.device.as_deref(), false)?);
    let base = Options { resolution: args.resolution, ..Options::default() };
    let length = Length::Time(budget.saturating_sub(start.elapsed()));
    let advice = advise(&device, &scene, &base, goal, length, status.observer())?;
    drop(status);
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
