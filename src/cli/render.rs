//! `goblet render`: a scene to image files.

use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use super::stats::Stats;
use super::{Failure, RenderArgs};
use crate::output;
use crate::renderer::{Options, Renderer, open_device};
use crate::scene::Scene;

/// Renders, and writes every output.
///
/// # Errors
/// The scene, an option, the device or an output is at fault.
pub fn run(args: &RenderArgs) -> Result<(), Failure> {
    let start = Instant::now();
    let scene = Scene::load(&args.scene)?;
    for warning in scene.warnings.iter().filter(|_| !args.quiet) {
        eprintln!("warning: {warning}");
    }
    let outputs = outputs(args, &scene);
    for path in &outputs {
        output::check_writable(path)?;
    }
    if let Some(path) = &args.stats {
        Stats::check_writable(path)?;
    }
    let load_time = start.elapsed();

    let device = Rc::new(open_device(args.device.as_deref(), args.validate)?);
    let mut renderer = Renderer::new(device, &scene, &options(args))?;
    let limit = Limit::new(args, &scene);
    let render_start = Instant::now();
    let progress = Progress::new(&limit, args.quiet);
    while !limit.reached(renderer.iterations(), render_start.elapsed()) {
        renderer.step()?;
        progress.show(&renderer, &limit, render_start.elapsed());
    }
    let image = renderer.resolve()?;
    let render_time = render_start.elapsed();
    progress.finish();

    let metadata = metadata(args, &renderer);
    for path in &outputs {
        output::write(path, &image, &metadata)?;
        if !args.quiet {
            eprintln!("wrote {}", path.display());
        }
    }
    let stats = Stats::new(&scene, &renderer, load_time, render_time, start.elapsed())?;
    for warning in stats.warnings() {
        eprintln!("warning: {warning}");
    }
    if let Some(path) = &args.stats {
        stats.write(path)?;
    }
    let messages = renderer.device().validation_messages();
    if messages.is_empty() { Ok(()) } else { Err(Failure::Validation(messages)) }
}

fn options(args: &RenderArgs) -> Options {
    Options {
        resolution: args.resolution,
        photons: args.photons,
        radius: args.radius,
        alpha: args.alpha,
        max_depth: args.max_depth,
        seed: args.seed,
        workgroup_size: args.workgroup_size,
        batch_size: args.batch_size.map(u64::from),
        revolution_solver: args.revolution_solver,
    }
}

/// The files to write: as asked, else what the scene names, else an EXR named after it.
fn outputs(args: &RenderArgs, scene: &Scene) -> Vec<PathBuf> {
    if !args.output.is_empty() {
        return args.output.clone();
    }
    let named = scene.film.filename.clone();
    let stem = args.scene.file_stem().map_or_else(|| Path::new("goblet"), Path::new);
    vec![named.unwrap_or_else(|| stem.with_extension("exr"))]
}

/// When to stop.
struct Limit {
    iterations: Option<u32>,
    time: Option<Duration>,
}

impl Limit {
    fn new(args: &RenderArgs, scene: &Scene) -> Self {
        let scenes_own = args.time.is_none().then_some(scene.integrator.iterations);
        Self { iterations: args.iterations.or(scenes_own), time: args.time }
    }

    /// At least one iteration is rendered, whatever the time.
    fn reached(&self, iterations: u32, elapsed: Duration) -> bool {
        iterations > 0
            && (self.iterations.is_some_and(|most| iterations >= most) || self.time.is_some_and(|most| elapsed >= most))
    }

    /// Seconds left, as far as can be told.
    fn left(&self, iterations: u32, elapsed: Duration) -> f64 {
        let by_count = self.iterations.map(|most| {
            elapsed.as_secs_f64() / f64::from(iterations.max(1)) * f64::from(most.saturating_sub(iterations))
        });
        let by_time = self.time.map(|most| most.saturating_sub(elapsed).as_secs_f64());
        by_count.into_iter().chain(by_time).fold(f64::INFINITY, f64::min)
    }
}

/// A bar on a terminal, a line now and then otherwise, nothing when quiet.
struct Progress {
    bar: Option<ProgressBar>,
    quiet: bool,
    printed: std::cell::Cell<Duration>,
}

/// Time between lines where there is no terminal.
const LINE_INTERVAL: Duration = Duration::from_secs(5);

impl Progress {
    fn new(limit: &Limit, quiet: bool) -> Self {
        let bar = (!quiet && std::io::stderr().is_terminal()).then(|| {
            let bar = limit.iterations.map_or_else(ProgressBar::new_spinner, |most| ProgressBar::new(most.into()));
            if let Ok(style) = ProgressStyle::with_template("{bar:30} {pos}/{len} iterations {msg}") {
                bar.set_style(style);
            }
            bar
        });
        Self { bar, quiet, printed: std::cell::Cell::default() }
    }

    fn show(&self, renderer: &Renderer, limit: &Limit, elapsed: Duration) {
        let rate = renderer.photons() as f64 / elapsed.as_secs_f64() / 1e6;
        let left = limit.left(renderer.iterations(), elapsed);
        if let Some(bar) = &self.bar {
            bar.set_position(renderer.iterations().into());
            bar.set_message(format!("{rate:.2} M photons/s, {left:.0} s left"));
        } else if !self.quiet && elapsed - self.printed.get() >= LINE_INTERVAL {
            self.printed.set(elapsed);
            eprintln!("iteration {}: {rate:.2} M photons/s, {left:.0} s left", renderer.iterations());
        }
    }

    fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish();
        }
    }
}

/// What an EXR says of its making. No time and no host: the same render is the same file.
fn metadata(args: &RenderArgs, renderer: &Renderer) -> Vec<(String, String)> {
    let scene = args.scene.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let device = renderer.device().info();
    [
        ("goblet.version", env!("CARGO_PKG_VERSION").to_owned()),
        ("goblet.scene", scene),
        ("goblet.iterations", renderer.iterations().to_string()),
        ("goblet.photons", renderer.photons().to_string()),
        ("goblet.device", device.name.clone()),
        ("goblet.driver", device.driver.clone()),
    ]
    .map(|(key, value)| (key.to_owned(), value))
    .to_vec()
}
