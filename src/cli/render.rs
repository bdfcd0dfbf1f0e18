//! The subcommand `goblet render`: renders a scene and writes image files.

mod args;
mod display_server;
mod limit;
mod options;
#[cfg(test)]
mod options_page;
mod progress;
mod signal;
mod summary;
#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

pub use args::RenderArgs;
use display_server::DisplayServer;
use limit::Limit;
use progress::{Begin, Progress};
pub use signal::STOPPED;
use signal::Signals;

use super::cache::open_device;
use super::outputs::{AN_IMAGE, Files, THE_CHECKPOINT, THE_STATISTICS, Written};
use super::stats::{Stats, percent};
use super::status::Status;
use super::{Failure, terminal};
use crate::image::estimate::Estimate;
use crate::image::exposure::{self, Exposure, exposed, white_share};
use crate::image::file::{self, Attribute, Channel, ImageError};
use crate::image::film::Image;
use crate::render::activity::Activity;
use crate::render::aov;
use crate::render::checkpoint::{Checkpoint, CheckpointError, MadeBy};
use crate::render::error::RenderError;
use crate::render::renderer::{Prepared, Renderer};
use crate::render::unsampled::Noise;
use crate::scene::Scene;

/// The largest share of white pixels in a picture without a warning.
const MOST_WHITE: f64 = 0.5;

/// The way in which a render ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// The render reached its limit.
    Done,
    /// A signal stopped the render; the outputs are written.
    Stopped,
}

/// Renders a scene and writes every output. If an iteration fails, the outputs have the iterations before it.
///
/// # Errors
/// The scene, an option or a checkpoint is invalid, or the device or an output fails.
pub fn run(args: &RenderArgs) -> Result<End, Failure> {
    run_with(args, Renderer::step)
}

/// Does the work of [`run`]; `step` renders an iteration, so that tests can make one fail.
fn run_with(args: &RenderArgs, step: impl Fn(&mut Renderer) -> Result<(), RenderError>) -> Result<End, Failure> {
    let start = Instant::now();
    let mut signals = Signals::new()?;
    let status = Status::new(Activity::ReadingScene, args.quiet);
    let scene = Scene::load_within(&args.scene, args.scene_memory.budget())?;
    for warning in scene.warnings.iter().filter(|_| !args.quiet) {
        terminal::warn(warning);
    }
    let outputs = outputs(args, &scene);
    check_files(args, &scene, &outputs)?;
    check_writable(args, &outputs)?;
    let resumed = args.resume.as_deref().map(read_checkpoint).transpose()?;
    let load_time = start.elapsed();

    let resumed = args.resume.as_deref().zip(resumed.as_ref());
    let mut renderer = prepare(args, &scene, resumed, &status)?;
    signals.begin();
    let begin = Begin { iterations: renderer.iterations(), photons: renderer.photons(), time: Instant::now() };
    let address = args.display_server.clone();
    let mut display =
        address.map(|address| DisplayServer::new(address, scene_name(&args.scene), &args.aov, args.quiet));
    let limit = Limit::new(args, &scene, renderer.sequence());
    let mut progress = Progress::new(&status, limit, begin);
    let outcome = iterate(args, &signals, &mut renderer, &mut progress, &mut display, step);
    let render_time = begin.time.elapsed();
    status.note(Activity::Writing);
    let mut written = Written::default();
    let saved = args.checkpoint.as_deref().map(|path| save(args, path, &renderer).map(|()| path)).transpose();
    if renderer.iterations() > 0 || outcome.is_ok() {
        let times = [load_time, render_time, start.elapsed()];
        written.note(write(args, &scene, &outputs, &mut renderer, &begin, times));
        written.note(display.map_or(Ok(()), |display| display.finish(&renderer)));
    }
    drop(status);
    say_end(args, &outcome, &renderer, saved.as_ref().ok().copied().flatten());
    written.note(saved.map(drop));
    // The failure that stopped the render determines the result, even if outputs failed after it.
    let end = match outcome {
        Err(failure) => {
            written.say();
            return Err(failure);
        }
        Ok(end) => end,
    };
    written.end()?;
    check_paths(&renderer)?;
    let messages = renderer.device().validation_messages();
    if messages.is_empty() { Ok(end) } else { Err(Failure::Validation(messages)) }
}

/// Opens the device and prepares the scene, up to the first iteration. A checkpoint that is to be resumed is compared
/// with the render before any kernel is compiled.
fn prepare(
    args: &RenderArgs,
    scene: &Scene,
    resumed: Option<(&Path, &Checkpoint)>,
    status: &Status,
) -> Result<Renderer, Failure> {
    status.note(Activity::OpeningDevice);
    let device = Arc::new(open_device(args.device.as_deref(), args.validate)?);
    let options = args.options();
    let prepared = Prepared::new(scene, &options, status.observer())?;
    if let Some((path, checkpoint)) = resumed {
        prepared.check(checkpoint).map_err(|reason| at(path, reason))?;
    }
    let mut renderer = prepared.build(device)?;
    for warning in renderer.warnings().iter().filter(|_| !args.quiet) {
        terminal::warn(warning);
    }
    if let Some((path, checkpoint)) = resumed {
        renderer.resume(checkpoint).map_err(|reason| at(path, reason))?;
        if !args.quiet {
            warn_of_other_maker(path, &checkpoint.made_by, &MadeBy::new(renderer.device()));
        }
    }
    if !args.quiet {
        let seconds = renderer.compile_time().as_secs_f64();
        terminal::say(format_args!("compiled the kernels in {seconds:.1} s"));
        if let Some(choice) = renderer.choice() {
            terminal::say(format_args!("trial of {:.1} s: {choice}", choice.time.as_secs_f64()));
        }
    }
    status.note(Activity::Rendering);
    Ok(renderer)
}

/// Says which checkpoint was written, and how to go on if the render was stopped or has failed.
fn say_end(args: &RenderArgs, outcome: &Result<End, Failure>, renderer: &Renderer, saved: Option<&Path>) {
    if args.quiet {
        return;
    }
    if let Some(path) = saved {
        terminal::say(format_args!("wrote {}", path.display()));
    }
    let has_failed = outcome.is_err() && saved.is_some() && renderer.iterations() > 0;
    if matches!(outcome, Ok(End::Stopped)) || has_failed {
        terminal::say(summary::stopped(args, renderer.iterations(), saved));
    }
}

/// Says the summary, and writes images and statistics. A failed output does not stop the others.
fn write(
    args: &RenderArgs,
    scene: &Scene,
    outputs: &[PathBuf],
    renderer: &mut Renderer,
    begin: &Begin,
    times: [Duration; 3],
) -> Result<(), Failure> {
    let estimate = renderer.estimate()?;
    let noise = renderer.noise(&estimate)?;
    if !args.quiet {
        terminal::say(summary::summary(renderer, begin, times[1], &noise));
    }
    let mut metadata = renderer.metadata(&scene_name(&args.scene), &estimate);
    if args.record_times {
        let [_, render, total] = times;
        let seconds = [("renderTimeSeconds", render), ("goblet.totalSeconds", total)];
        metadata.extend(seconds.map(|(name, time)| (name.to_owned(), Attribute::Float(time.as_secs_f32()))));
    }
    let channels = aov::channels(&args.aov, &estimate)?;
    let mut written = Written::default();
    written.note(write_images(outputs, &estimate, &channels, &metadata, args.exposure, args.quiet));
    written.note(write_stats(args, scene, renderer, noise, begin, times));
    written.end()
}

/// Prints the warnings that follow from the statistics, and writes the statistics if `--stats` is given.
fn write_stats(
    args: &RenderArgs,
    scene: &Scene,
    renderer: &Renderer,
    noise: Noise,
    begin: &Begin,
    times: [Duration; 3],
) -> Result<(), Failure> {
    let photons = renderer.photons() - begin.photons;
    let stats = Stats::new(scene, renderer, noise, photons, times)?;
    for warning in stats.warnings() {
        terminal::warn(warning);
    }
    let Some(path) = &args.stats else { return Ok(()) };
    stats.write(path)?;
    if !args.quiet {
        terminal::say(format_args!("wrote {}", path.display()));
    }
    Ok(())
}

/// Runs iterations until a limit or a signal, and shows images and saves checkpoints on the way. A signal stops the render
/// only after the first iteration, so that there is an image.
fn iterate(
    args: &RenderArgs,
    signals: &Signals,
    renderer: &mut Renderer,
    progress: &mut Progress,
    display: &mut Option<DisplayServer>,
    step: impl Fn(&mut Renderer) -> Result<(), RenderError>,
) -> Result<End, Failure> {
    let (limit, begin) = (progress.limit, progress.begin);
    progress.draw(renderer);
    let mut saved = Instant::now();
    // A resumed render may have reached the target error already.
    if limit.wants_error(renderer.iterations(), args.quiet) {
        progress.error = renderer.relative_error()?;
    }
    while !limit.reached(renderer.iterations(), begin.time.elapsed(), progress.error) {
        if signals.received() && renderer.iterations() > 0 {
            return Ok(End::Stopped);
        }
        step(renderer)?;
        if limit.wants_error(renderer.iterations(), args.quiet) {
            progress.error = renderer.relative_error()?;
        }
        progress.show(renderer);
        if let Some(display) = display {
            display.show(renderer)?;
        }
        if let Some(path) = args.checkpoint.as_ref().filter(|_| saved.elapsed() >= args.checkpoint_every) {
            // A full disk does not end the render, because there may be space later.
            if let Err(failure) = save(args, path, renderer) {
                terminal::warn(failure);
            }
            saved = Instant::now();
        }
    }
    progress.draw(renderer);
    Ok(End::Done)
}

/// Checks that not all photon paths and not all eye paths were dropped for values that are not finite.
fn check_paths(renderer: &Renderer) -> Result<(), Failure> {
    let tally = renderer.tally();
    let all = |dropped: u64, traced: u64| traced > 0 && dropped >= traced;
    if all(tally.non_finite.photon, tally.emitted) {
        return Err(Failure::NotFinite("photon"));
    }
    if all(tally.non_finite.eye, renderer.eye_paths()) {
        return Err(Failure::NotFinite("eye path"));
    }
    Ok(())
}

/// Returns the image files to write: those of `--output`, else the file that the scene names, else an EXR
/// named after the scene. A shard writes no image without `--output`.
fn outputs(args: &RenderArgs, scene: &Scene) -> Vec<PathBuf> {
    if !args.output.is_empty() || args.shard.is_some() {
        return args.output.clone();
    }
    let named = scene.film.filename.clone();
    let stem = args.scene.file_stem().map_or_else(|| Path::new("goblet"), Path::new);
    vec![named.unwrap_or_else(|| stem.with_extension("exr"))]
}

/// Checks that no output replaces an input or another output. The only exception is the checkpoint that the
/// render resumes: the new checkpoint may replace it.
fn check_files(args: &RenderArgs, scene: &Scene, outputs: &[PathBuf]) -> Result<(), Failure> {
    let inputs = || Files::default().reads_scene(&args.scene, scene);
    inputs().writes(THE_CHECKPOINT, &args.checkpoint).check()?;
    let resumed = args.resume.iter().fold(inputs(), |files, path| files.reads("the checkpoint to resume", path));
    resumed.writes(AN_IMAGE, outputs).writes(THE_STATISTICS, &args.stats).check()?;
    let own = Files::default().writes(THE_CHECKPOINT, &args.checkpoint);
    own.writes(AN_IMAGE, outputs).writes(THE_STATISTICS, &args.stats).check()
}

/// Checks before a long render that all outputs can be written.
fn check_writable(args: &RenderArgs, outputs: &[PathBuf]) -> Result<(), Failure> {
    for path in outputs {
        file::check_writable(path)?;
    }
    if let Some(path) = &args.checkpoint {
        Checkpoint::check_writable(path).map_err(|reason| at(path, reason))?;
    }
    if let Some(path) = &args.stats {
        Stats::check_writable(path)?;
    }
    Ok(())
}

/// Returns the name of a scene file in outputs.
pub fn scene_name(scene: &Path) -> String {
    scene.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
}

fn save(args: &RenderArgs, path: &Path, renderer: &Renderer) -> Result<(), Failure> {
    save_checkpoint(&scene_name(&args.scene), path, renderer)
}

/// Writes a checkpoint; `scene` is the name of the scene.
///
/// # Errors
/// The device fails, or the file cannot be written.
pub fn save_checkpoint(scene: &str, path: &Path, renderer: &Renderer) -> Result<(), Failure> {
    renderer.checkpoint(scene)?.write(path).map_err(|reason| at(path, reason))
}

/// Reads a checkpoint.
///
/// # Errors
/// The file cannot be read, or is not a whole checkpoint. The error has the file's name.
pub fn read_checkpoint(path: &Path) -> Result<Checkpoint, Failure> {
    Checkpoint::read(path).map_err(|reason| at(path, reason))
}

/// Returns the failure for an error of a checkpoint, with the name of its file.
pub fn at(path: &Path, reason: CheckpointError) -> Failure {
    Failure::Checkpoint { path: path.display().to_string(), reason }
}

/// Prints a warning if a checkpoint was made by another program, device or driver (`there`) than the rest of
/// the render (`here`).
pub fn warn_of_other_maker(path: &Path, there: &MadeBy, here: &MadeBy) {
    if here != there {
        let path = path.display();
        terminal::warn(format_args!(
            "{path}: made by {there}, the rest by {here}: roundings may differ from one run's"
        ));
    }
}

/// Writes the image of an estimate: as it is to EXRs, with further channels and attributes, and with an exposure to
/// PNGs. A file that cannot be written does not stop the others.
///
/// # Errors
/// A file cannot be written.
pub fn write_images(
    paths: &[PathBuf],
    estimate: &Estimate,
    channels: &[Channel],
    metadata: &[(String, Attribute)],
    exposure: Exposure,
    quiet: bool,
) -> Result<(), Failure> {
    let image = estimate.image();
    let mut written = Written::default();
    for path in paths {
        let (outcome, how) = if file::is_picture(path) {
            let stops = exposure.stops(&image);
            let how = if exposure == Exposure::Auto {
                format!(", exposure {}", exposure::text(stops))
            } else {
                String::new()
            };
            (write_picture(path, &image, stops, quiet), how)
        } else {
            (file::write_part(path, &image, &estimate.window, channels, metadata), String::new())
        };
        if outcome.is_ok() && !quiet {
            terminal::say(format_args!("wrote {}{how}", path.display()));
        }
        written.note(outcome.map_err(Failure::from));
    }
    written.end()
}

/// Writes a picture of an image, and warns if most of it is white.
fn write_picture(path: &Path, image: &Image, stops: f32, quiet: bool) -> Result<(), ImageError> {
    let picture = exposed(image, stops);
    file::write(path, &picture, &[])?;
    let white = white_share(&picture);
    if white > MOST_WHITE && !quiet {
        let (path, white, stops) = (path.display(), percent(white), exposure::text(stops));
        terminal::warn(format_args!(
            "{path}: {white} of the pixels are white at an exposure of {stops}; --exposure auto shows more"
        ));
    }
    Ok(())
}
