//! The subcommand `goblet measure`: measures the error of each setting of a render against time.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use clap::Args;
use goblet_host::Device;

use super::cache::open_device;
use super::failure::CompareError;
use super::outputs::{Files, Written};
use super::status::{Line, Status, duration, of_limit};
use super::values::{positive_u32, seconds};
use super::{Failure, SceneMemory, compare, terminal};
use crate::base::output::replace;
use crate::gpu_scene::pack::pack;
use crate::image::compare::SizeMismatch;
use crate::image::file;
use crate::image::film::Image;
use crate::render::activity::{Activity, Since};
use crate::render::error::RenderError;
use crate::render::options::Options;
use crate::render::renderer::Prepared;
use crate::scene::Scene;
use crate::study::machine::Machine;
use crate::study::measure::{
    Conditions, Measurement, Reference, Setting, Source, Trajectory, Vary, knobs, report, settings,
};

/// The render time of the automatic reference, in budgets of a setting.
const REFERENCE_BUDGETS: u32 = 10;
/// The difference between the seed of the automatic reference and the scene's seed.
const REFERENCE_SEED: u32 = 1 << 20;

/// The name of the reference that goblet renders itself.
const AUTO: &str = "auto";

/// Names of the files in the output folder.
const RESULTS: [&str; 2] = ["results.json", "results.csv"];
const REPORT: &str = "report.html";
const OWN_REFERENCE: &str = "reference.exr";

/// Arguments of `goblet measure`.
#[derive(Args, Clone, Debug)]
pub struct MeasureArgs {
    /// The scene, in pbrt-v4's text format
    #[arg(value_name = "SCENE")]
    pub scene: PathBuf,

    /// Reference: an image that is taken as correct, or `auto`, which renders one first
    ///
    /// `auto` renders with the scene's own settings for ten times the budget. This reference is
    /// blurred too, and the blur that it shares with an image does not count as an error of the image.
    #[arg(long, value_name = "FILE|auto")]
    pub reference: PathBuf,

    /// What is varied.
    #[arg(long, value_name = "KNOB=V1,V2..", value_parser = vary, help = vary_help())]
    pub vary: Vec<Vary>,

    /// Vary one option at a time, instead of measuring all combinations
    ///
    /// The settings are the default, and each value of each --vary alone. If a --vary has only
    /// one value, all settings have it.
    #[arg(long)]
    pub each: bool,

    /// Render time of each setting in the first turn, in seconds; later turns repeat its iterations
    #[arg(long, value_name = "SECONDS", value_parser = seconds, default_value = "10")]
    #[arg(allow_negative_numbers = true)]
    pub budget: Duration,

    /// Number of turns; each has another seed, and two or more separate noise from bias
    #[arg(long, value_name = "K", value_parser = positive_u32, default_value = "4")]
    #[arg(allow_negative_numbers = true)]
    pub repeat: u32,

    /// Folder for the results; it is created if it does not exist
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,

    /// Device to use: its index, or a part of its name, from `goblet devices` [default: the first that can render]
    #[arg(long, value_name = "INDEX|NAME")]
    pub device: Option<String>,

    /// How much memory the scene may take.
    #[command(flatten)]
    pub scene_memory: SceneMemory,

    /// Print errors only
    #[arg(short, long)]
    pub quiet: bool,
}

fn vary_help() -> String {
    format!(
        "Option of `goblet render` and the values to measure, such as radius=1px,2px; repeat --vary to measure all \
         combinations. Options: {}",
        knobs()
    )
}

fn vary(text: &str) -> Result<Vary, String> {
    text.parse().map_err(|error: crate::study::measure::KnobError| error.to_string())
}

/// Measures settings, and writes the results after every turn.
///
/// # Errors
/// The scene, a setting or the reference is invalid, or the device or an output fails.
pub fn run(args: &MeasureArgs) -> Result<(), Failure> {
    let status = Status::new(Activity::ReadingScene, args.quiet);
    let scene = Scene::load_within(&args.scene, args.scene_memory.budget())?;
    for warning in scene.warnings.iter().filter(|_| !args.quiet) {
        terminal::warn(warning);
    }
    let settings = settings(&args.vary, args.each)?;
    check_options(&scene, &settings)?;
    check_files(args, &scene, settings.len())?;
    fs::create_dir_all(&args.output).map_err(|reason| failed(&args.output, reason))?;
    let given = given_reference(args)?;
    if !args.quiet {
        terminal::say(plan(args, settings.len(), given.is_none()));
    }
    status.note(Activity::OpeningDevice);
    let device = Arc::new(open_device(args.device.as_deref(), false)?);
    let (image, source) = match given {
        Some(given) => given,
        None => own_reference(args, &device, &scene, &status)?,
    };
    status.note(Activity::Rendering);
    let reference = Reference::new(image, args.vary.iter().any(|vary| vary.knob == "resolution"));
    check_sizes(&reference, &scene, &settings)?;

    let mut measurement = Measurement::new(&device, &scene, &reference, &settings, args.budget);
    let begin = Instant::now();
    let planned = settings.len() as f64 * f64::from(args.repeat) * args.budget.as_secs_f64();
    for turn in 0..args.repeat {
        let tell = |setting: &Setting, done: f64| {
            let (turns, label, now) = (args.repeat, setting.label(), Instant::now());
            let place = Place { turn, turns, done, label, planned, begin, now };
            status.show(Box::new(move |since| place.line(since)));
            status.note(Activity::Rendering);
            status.draw();
        };
        measurement.turn(turn, tell, |setting, run| say(args, turn, setting, run))?;
        let conditions = Conditions {
            machine: Machine::new(device.info()),
            command: command_line(),
            scene: args.scene.display().to_string(),
            reference: source.clone(),
            budget: args.budget.as_secs_f64(),
            repeat: turn + 1,
        };
        status.note(Activity::Writing);
        write(&args.output, &measurement, conditions)?;
    }
    drop(status);
    if !args.quiet {
        terminal::say(format_args!("measured in {}", duration(begin.elapsed().as_secs_f64())));
        terminal::say(format_args!("wrote {}", args.output.join(REPORT).display()));
    }
    Ok(())
}

/// Returns how long the measurement will take, before anything is rendered. How long kernels take to compile, and images to
/// compare, follows from the first runs: [`Place`].
fn plan(args: &MeasureArgs, settings: usize, renders_reference: bool) -> String {
    let runs = settings as f64 * f64::from(args.repeat);
    let reference = if renders_reference { f64::from(REFERENCE_BUDGETS) } else { 0.0 };
    let seconds = (runs + reference) * args.budget.as_secs_f64();
    let some = |count: f64, what: &str| format!("{count} {what}{}", if count == 1.0 { "" } else { "s" });
    format!(
        "measuring {} in {} of {} each{}: about {} of rendering; kernels are compiled and images compared besides",
        some(settings as f64, "setting"),
        some(args.repeat.into(), "turn"),
        duration(args.budget.as_secs_f64()),
        if renders_reference { ", after a reference" } else { "" },
        duration(seconds),
    )
}

/// Where a measurement is.
struct Place {
    turn: u32,
    turns: u32,
    /// The share of the turn that is done.
    done: f64,
    /// The setting that is rendered.
    label: String,
    /// The time of rendering in all turns, before anything is known about what comes with it.
    planned: f64,
    begin: Instant,
    /// When the measurement was here.
    now: Instant,
}

impl Place {
    fn line(&self, since: &Since) -> Line {
        let Self { turn, turns, done, ref label, planned, begin, now } = *self;
        let share = (f64::from(turn) + done) / f64::from(turns);
        let elapsed = begin.elapsed().as_secs_f64();
        let mut parts = vec![format!("turn {} of {turns}", turn + 1)];
        // Turns take equal times, nearly.
        let all = if share > 0.0 { (now - begin).as_secs_f64() / share } else { planned };
        parts.push(format!("about {} left", duration(((1.0 - share) * all - now.elapsed().as_secs_f64()).max(0.0))));
        parts.push(match since.activity {
            Activity::Writing => since.activity.to_string(),
            _ => label.clone(),
        });
        parts.push(format!("{} so far", duration(elapsed)));
        Line { share: Some(share), parts }
    }
}

/// Checks before anything is rendered that no result replaces a file that the command reads.
fn check_files(args: &MeasureArgs, scene: &Scene, settings: usize) -> Result<(), Failure> {
    let mut files = Files::default().reads_scene(&args.scene, scene);
    if args.reference.as_os_str() != OsStr::new(AUTO) {
        files = files.reads("the reference", &args.reference);
    }
    files.writes("a result", &outputs(&args.output, settings)).check()
}

fn say(args: &MeasureArgs, turn: u32, setting: &Setting, run: &Trajectory) {
    if let Some(last) = run.steps.last().filter(|_| !args.quiet) {
        terminal::say(format_args!(
            "turn {} of {}, {}: {} iterations in {:.2} s, relMSE {:.5}",
            turn + 1,
            args.repeat,
            setting.label(),
            last.iterations,
            last.seconds,
            last.error.relmse
        ));
    }
}

/// Reads the reference, before a device is opened; `None` if goblet renders the reference itself.
fn given_reference(args: &MeasureArgs) -> Result<Option<(Image, Source)>, Failure> {
    if args.reference.as_os_str() == OsStr::new(AUTO) {
        return Ok(None);
    }
    let image = file::read(&args.reference).map_err(CompareError::from)?;
    let source = Source {
        path: args.reference.display().to_string(),
        resolution: [image.width, image.height],
        own_iterations: None,
        own_relative_error: None,
    };
    Ok(Some((image, source)))
}

/// Renders a reference with the scene's own settings, and writes it to the folder of the results.
fn own_reference(
    args: &MeasureArgs,
    device: &Arc<Device>,
    scene: &Scene,
    status: &Status,
) -> Result<(Image, Source), Failure> {
    let time = args.budget * REFERENCE_BUDGETS;
    if !args.quiet {
        terminal::say(format_args!(
            "rendering a reference for {:.0} s; blur that it shares with a setting will not count as error",
            time.as_secs_f64()
        ));
    }
    let seed = Some(scene.integrator.seed.wrapping_add(REFERENCE_SEED));
    let options = Options { seed, ..Options::default() };
    let mut renderer = Prepared::new(scene, &options, status.observer())?.build(Arc::clone(device))?;
    let start = Instant::now();
    status.show(Box::new(move |since| Line {
        share: Some(start.elapsed().as_secs_f64() / time.as_secs_f64()),
        parts: vec![format!("reference, {}", of_limit(start.elapsed(), time)), since.activity.to_string()],
    }));
    while renderer.iterations() == 0 || start.elapsed() < time {
        renderer.step()?;
    }
    let estimate = renderer.estimate()?;
    let image = estimate.image();
    let path = args.output.join(OWN_REFERENCE);
    file::write_part(&path, &image, &estimate.window, &[], &[])?;
    let source = Source {
        path: path.display().to_string(),
        resolution: [image.width, image.height],
        own_iterations: Some(renderer.iterations()),
        own_relative_error: estimate.relative_error(),
    };
    Ok((image, source))
}

/// Checks before anything is rendered that each setting fits the scene.
fn check_options(scene: &Scene, settings: &[Setting]) -> Result<(), Failure> {
    for setting in settings {
        let options = &setting.request.options;
        let packed = pack(scene, options.revolution_solver).map_err(RenderError::from)?;
        options.resolve(scene, packed.space.radius / packed.space.scale)?;
    }
    Ok(())
}

/// Checks, before the settings are rendered, that their images have the size of the reference.
fn check_sizes(reference: &Reference, scene: &Scene, settings: &[Setting]) -> Result<(), Failure> {
    let [first, end] = scene.film.bounds(scene.film.resolution);
    let image = [end[0] - first[0], end[1] - first[1]];
    let as_the_scene_says = settings.iter().any(|setting| setting.request.options.resolution.is_none());
    if as_the_scene_says && image != reference.resolution() {
        return Err(CompareError::FilmSize(SizeMismatch { image, reference: reference.resolution() }).into());
    }
    Ok(())
}

/// Writes all results so far. A file that cannot be written does not stop the others.
fn write(folder: &Path, measurement: &Measurement, conditions: Conditions) -> Result<(), Failure> {
    let results = measurement.results(conditions);
    let save = |name: &str, text: Result<String, String>| {
        let path = folder.join(name);
        let text = text.map_err(|error| failed(folder, error))?;
        replace(&path, text.as_bytes()).map_err(|reason| failed(&path, reason))
    };
    let mut written = Written::default();
    let json = serde_json::to_string_pretty(&results).map(|json| json + "\n");
    written.note(save(RESULTS[0], json.map_err(|error| error.to_string())));
    written.note(save(RESULTS[1], results.csv().map_err(|error| error.to_string())));
    let images: Vec<_> = measurement.images().collect();
    for (i, last) in images.iter().enumerate().filter_map(|(i, last)| Some((i, last.as_ref()?))) {
        let path = folder.join(image_file(i));
        written.note(file::write_part(&path, last.image, &last.window, &[], &[]).map_err(Failure::from));
        if let Some(difference) = &last.difference {
            let (sheet, _) = compare::draw(difference, &difference.scale(), None);
            written.note(file::write(&folder.join(difference_file(i)), &sheet, &[]).map_err(Failure::from));
        }
    }
    let report = report::html(&results, measurement.reference(), &images);
    written.note(save(REPORT, report.map_err(|error| error.to_string())));
    written.end()
}

fn image_file(setting: usize) -> String {
    format!("setting-{}.exr", setting + 1)
}

fn difference_file(setting: usize) -> String {
    format!("setting-{}-difference.png", setting + 1)
}

/// Returns all files that may be written for this number of settings.
fn outputs(folder: &Path, settings: usize) -> Vec<PathBuf> {
    let fixed = [RESULTS[0], RESULTS[1], REPORT, OWN_REFERENCE].map(str::to_owned);
    let images = (0..settings).flat_map(|setting| [image_file(setting), difference_file(setting)]);
    fixed.into_iter().chain(images).map(|name| folder.join(name)).collect()
}

fn failed(path: &Path, reason: impl std::fmt::Display) -> Failure {
    Failure::Report { path: path.display().to_string(), reason: reason.to_string() }
}

/// Returns the command line as given, with `goblet` in place of the path of the program.
fn command_line() -> String {
    let rest = std::env::args_os().skip(1).map(|arg| arg.to_string_lossy().into_owned());
    std::iter::once("goblet".to_owned()).chain(rest).collect::<Vec<_>>().join(" ")
}
