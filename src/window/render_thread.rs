//! Renders what the window wishes, and tells it.

use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::time::{Duration, Instant};

use goblet_host::Device;

use super::quantity::Quantity;
use super::shared::{Loaded, Shared, Status, View, Wish};
use crate::checkpoint::MadeBy;
use crate::cli::render::{metadata, save_checkpoint, scene_name, write_images};
use crate::cli::{Failure, RenderArgs};
use crate::options::Options;
use crate::renderer::{Renderer, open_device};
use crate::scene::{Camera, Scene};

/// After the camera has come to rest, coarse images are enough for so long.
const REST: Duration = Duration::from_millis(150);
/// The first image of something has a pixel for so many along each axis, at least and at most:
/// as many as it takes to be made in no time. Then half as many, and so on to one.
const COARSE: [u32; 2] = [2, 8];
/// No time, as a hand feels it.
const AT_ONCE: Duration = Duration::from_millis(120);
/// Pictures of quick iterations need not come more often.
const LEAST_BETWEEN_VIEWS: Duration = Duration::from_millis(30);
/// With nothing to do, it looks up so often.
const IDLE: Duration = Duration::from_millis(500);
/// The error is estimated, and costs time, so often.
const BETWEEN_ERRORS: Duration = Duration::from_secs(1);
/// How far the window's thread comes before this one.
#[cfg(unix)]
const NICENESS: i32 = 10;

/// The thread's state.
struct RenderThread<'a> {
    shared: &'a Shared,
    args: &'a RenderArgs,
    device: Rc<Device>,
    /// With the camera that is in use ..
    scene: Scene,
    /// .. and the one that it has in the file.
    home: Camera,
    /// Its file.
    path: PathBuf,
    loads: u64,
    /// None before the first one, and where scene or options do not let themselves be rendered.
    render: Option<Render>,
    /// What has failed, and is not tried again.
    failed: Option<Target>,
    /// Pixels along each axis that are one in a first image.
    coarsest: u32,
}

/// What a render is of.
#[derive(Clone, PartialEq)]
struct Target {
    loads: u64,
    camera: Camera,
    options: Options,
}

/// A render in progress.
struct Render {
    renderer: Renderer,
    target: Target,
    /// Pixels along each axis that are one.
    coarseness: u32,
    /// Moves of the camera that it has seen.
    moves: u64,
    /// That iterations took.
    time: Duration,
    passes: Vec<(&'static str, Duration)>,
    error: Option<f64>,
    estimated: Instant,
    /// When the window was last told, and of what.
    told: Option<(Instant, u32, Quantity)>,
}

/// Renders until the window closes.
pub fn run(shared: &Shared, args: &RenderArgs, scene: Scene) {
    // The threads of a device that is software inherit it. If it cannot be had, that is no error.
    #[cfg(unix)]
    let _ = rustix::process::nice(NICENESS);
    let device = match open_device(args.device.as_deref(), args.validate) {
        Ok(device) => Rc::new(device),
        Err(error) => return shared.tell(|news| news.message = Some(Err(error.to_string()))),
    };
    shared.tell(|news| news.status.device.clone_from(&device.info().name));
    let mut thread = RenderThread {
        shared,
        args,
        device: Rc::clone(&device),
        home: scene.camera,
        scene,
        path: args.scene.clone(),
        loads: 0,
        render: None,
        failed: None,
        coarsest: COARSE[1],
    };
    loop {
        let wish = shared.take_wish();
        if wish.close {
            break;
        }
        if let Err(failure) = thread.serve(&wish) {
            thread.render = None;
            thread.failed = Some(thread.target(&wish));
            shared.tell(|news| news.message = Some(Err(failure.to_string())));
        }
    }
    drop(thread);
    let messages = device.validation_messages();
    shared.tell(|news| news.validation = messages);
}

/// Every file that a scene's text is in.
pub fn files(path: &Path, scene: &Scene) -> Vec<PathBuf> {
    [path.to_owned()].into_iter().chain(scene.included.iter().cloned()).collect()
}

impl RenderThread<'_> {
    /// Does a bit of what is wished.
    fn serve(&mut self, wish: &Wish) -> Result<(), Failure> {
        if wish.loads != self.loads {
            self.load(wish);
        }
        let target = self.target(wish);
        if self.failed.as_ref() == Some(&target) {
            self.shared.wait(IDLE);
            return Ok(());
        }
        let is_moving = wish.moved.is_some_and(|moved| moved.elapsed() < REST);
        let coarseness = self.coarseness(&target, is_moving);
        let is_coarse = coarseness > 1;
        self.aim(target, coarseness)?;
        let Some(render) = &mut self.render else { return Ok(()) };
        render.moves = wish.moves;
        let is_done = wish.paused || self.args.iterations.is_some_and(|most| render.renderer.iterations() >= most);
        for path in &wish.saves {
            if !is_coarse && (is_done || render.renderer.iterations() > 0) {
                save(self.shared, self.args, &self.path, &render.renderer, path);
            } else {
                // There is nothing yet.
                self.shared.wish(false, |wish| wish.saves.push(path.clone()));
            }
        }
        if is_done && !is_coarse {
            render.tell(self.shared, wish.quantity, "done")?;
            self.shared.wait(IDLE);
            return Ok(());
        }
        self.iterate(wish, coarseness)
    }

    /// Runs an iteration, unless something else is wished meanwhile.
    fn iterate(&mut self, wish: &Wish, coarseness: u32) -> Result<(), Failure> {
        let Some(render) = &mut self.render else { return Ok(()) };
        let before = self.device.pass_times();
        let start = Instant::now();
        // First images are quick, and of use to a hand that moves on.
        let is_first = coarseness == self.coarsest;
        let gives_up = || !is_first && self.shared.in_hurry();
        if render.renderer.step_unless(&gives_up)? {
            render.time += start.elapsed();
            render.passes = since(&before, self.device.pass_times());
            render.tell(self.shared, wish.quantity, if coarseness > 1 { "looking" } else { "rendering" })?;
            if is_first {
                self.observe(start.elapsed());
            }
        }
        Ok(())
    }

    fn target(&self, wish: &Wish) -> Target {
        let options = Options { contribution: wish.quantity.contribution(), responsive: true, ..wish.options.clone() };
        Target { loads: self.loads, camera: wish.camera.unwrap_or(self.home), options }
    }

    /// Reads a scene; the old one stays if that fails.
    fn load(&mut self, wish: &Wish) {
        self.loads = wish.loads;
        self.shared.tell(|news| news.status.doing = "reading the scene");
        match Scene::load_within(&wish.scene, self.scene.budget.anew()) {
            Ok(scene) => {
                let loaded = Loaded { camera: scene.camera, film: scene.film.clone() };
                let message = scene.warnings.first().map_or_else(|| "read the scene".to_owned(), Clone::clone);
                self.shared.tell(|news| {
                    (news.loaded, news.message) = (Some(loaded), Some(Ok(message)));
                    news.files = Some(files(&wish.scene, &scene));
                });
                (self.home, self.scene) = (scene.camera, scene);
                self.path.clone_from(&wish.scene);
                self.render = None;
            }
            Err(error) => {
                // What is rendered is what it was.
                if let Some(render) = &mut self.render {
                    render.target.loads = self.loads;
                }
                self.shared.tell(|news| news.message = Some(Err(error.to_string())));
            }
        }
    }

    /// How many pixels along each axis are to be one: what is new is seen coarsely first.
    fn coarseness(&self, target: &Target, is_moving: bool) -> u32 {
        match &self.render {
            Some(render) if render.target == *target => match render.renderer.iterations() {
                0 => render.coarseness,
                _ if is_moving => render.coarseness,
                _ => (render.coarseness / 2).max(1),
            },
            _ => self.coarsest,
        }
    }

    /// Learns how long a first image took.
    fn observe(&mut self, took: Duration) {
        // Four times the pixels take about four times as long.
        let other = if took > AT_ONCE { 2 * self.coarsest } else { self.coarsest / 2 };
        if took > AT_ONCE || 5 * took < AT_ONCE {
            self.coarsest = other.clamp(COARSE[0], COARSE[1]);
        }
    }

    /// Begins to render something else, if it is something else.
    fn aim(&mut self, target: Target, coarseness: u32) -> Result<(), Failure> {
        if self.render.as_ref().is_some_and(|render| render.target == target && render.coarseness == coarseness) {
            return Ok(());
        }
        self.scene.camera = target.camera;
        let options = coarse(&target.options, &self.scene, coarseness);
        let restarted = match &mut self.render {
            Some(render) => render.renderer.restart(&self.scene, &options)?,
            None => false,
        };
        if !restarted {
            self.shared.tell(|news| news.status.doing = "preparing the scene");
            // First, so that both are never in memory.
            self.render = None;
            let mut renderer = Renderer::new(Rc::clone(&self.device), &self.scene, &target.options)?;
            renderer.restart(&self.scene, &options)?;
            self.render = Some(Render::new(renderer, target.clone()));
        }
        if let Some(render) = &mut self.render {
            (render.target, render.coarseness) = (target, coarseness);
            (render.time, render.error, render.told) = (Duration::ZERO, None, None);
        }
        Ok(())
    }
}

/// The same, with so many pixels along each axis made one, and in a hurry if they are.
fn coarse(options: &Options, scene: &Scene, coarseness: u32) -> Options {
    if coarseness == 1 {
        return options.clone();
    }
    let fewer = u64::from(coarseness * coarseness);
    Options {
        resolution: Some(options.resolution.unwrap_or(scene.film.resolution).map(|side| side.div_ceil(coarseness))),
        photons: options.photons.or(scene.integrator.photons_per_iteration).map(|photons| photons.div_ceil(fewer)),
        radius: options.radius.or(scene.integrator.radius).map(|radius| radius * f64::from(coarseness)),
        eye_paths: Some(1),
        ..options.clone()
    }
}

/// Times by pass since there were others.
fn since(before: &[(&'static str, Duration)], now: Vec<(&'static str, Duration)>) -> Vec<(&'static str, Duration)> {
    let earlier = |name| before.iter().find(|(other, _)| *other == name).map_or(Duration::ZERO, |(_, time)| *time);
    now.into_iter().map(|(name, time)| (name, time.saturating_sub(earlier(name)))).collect()
}

impl Render {
    fn new(renderer: Renderer, target: Target) -> Self {
        Self {
            renderer,
            target,
            coarseness: 1,
            moves: 0,
            time: Duration::ZERO,
            passes: Vec::new(),
            error: None,
            estimated: Instant::now(),
            told: None,
        }
    }

    /// Tells the window what there is, if it is something new.
    fn tell(&mut self, shared: &Shared, quantity: Quantity, doing: &'static str) -> Result<(), Failure> {
        let iterations = self.renderer.iterations();
        let is_known = self.told.is_some_and(|(_, of, what)| (of, what) == (iterations, quantity));
        let is_soon = self.told.is_some_and(|(when, _, what)| what == quantity && when.elapsed() < LEAST_BETWEEN_VIEWS);
        if iterations == 0 || is_known || (is_soon && doing != "done") {
            return Ok(());
        }
        let estimate = self.renderer.estimate()?;
        let has_lengths = self.told.is_some();
        if self.coarseness == 1 && (self.error.is_none() || self.estimated.elapsed() > BETWEEN_ERRORS) {
            self.error = self.renderer.noise(&estimate)?.relative_error();
            self.estimated = Instant::now();
        }
        let picture = quantity.picture(&self.renderer, &estimate)?;
        let lengths = if has_lengths { None } else { Some(self.renderer.path_lengths()?) };
        let view = View { picture, moves: self.moves, lengths };
        self.told = Some((Instant::now(), iterations, quantity));
        shared.tell(|news| {
            // Lengths that nobody has taken yet are those of this render, if it has not begun just now.
            let kept = news.view.take().and_then(|view| view.lengths).filter(|_| has_lengths);
            news.view = Some(View { lengths: view.lengths.or(kept), ..view });
            news.status = Status {
                doing,
                iterations,
                photons: self.renderer.tally().emitted,
                time: self.time,
                passes: self.passes.clone(),
                error: self.error,
                memory: self.renderer.device().allocated_bytes(),
                resolution: estimate.resolution,
                device: std::mem::take(&mut news.status.device),
            };
        });
        Ok(())
    }
}

/// Writes what `goblet render` would: an image or a checkpoint, by the file's name.
fn save(shared: &Shared, args: &RenderArgs, scene: &Path, renderer: &Renderer, path: &Path) {
    let scene = scene_name(scene);
    let written = if path.extension().is_some_and(|extension| extension == "checkpoint") {
        save_checkpoint(&scene, path, renderer)
    } else {
        renderer.estimate().map_err(Failure::from).and_then(|estimate| {
            let metadata = metadata(&scene, &MadeBy::new(renderer.device()), &estimate, renderer.photons());
            write_images(&[path.to_owned()], &estimate, &args.aov, &metadata, true)
        })
    };
    let message = written.map(|()| format!("wrote {}", path.display())).map_err(|failure| failure.to_string());
    shared.tell(|news| news.message = Some(message));
}
