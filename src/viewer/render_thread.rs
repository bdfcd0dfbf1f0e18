//! The render thread: it renders the target that the window wishes, and sends pictures to the window.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use goblet_host::Device;

use super::doing::Doing;
use super::plan::{Next, Standing, next};
use super::rendering::{Kept, Render};
use super::shared::{Loaded, Save, Shared, Target, Wish};
use crate::cli::cache::open_device;
use crate::cli::outputs::{AN_IMAGE, Files};
use crate::cli::{Failure, RenderArgs};
use crate::render::activity::{Activity, Observer};
use crate::render::error::RenderError;
use crate::render::options::Options;
use crate::render::renderer::Prepared;
use crate::scene::{Camera, Scene};

/// The time after a move of the camera during which coarse images are enough.
const REST: Duration = Duration::from_millis(150);
/// The range of the coarseness of a target's first image. The coarseness is chosen so that the first image
/// takes less than [`AT_ONCE`]; each following image has half the coarseness of the one before, down to 1.
const COARSE: [u32; 2] = [2, 8];
/// The longest time for an image that a user perceives as immediate.
const AT_ONCE: Duration = Duration::from_millis(120);
/// The longest wait for a wish when there is nothing to do.
const IDLE: Duration = Duration::from_millis(500);
/// The niceness of the render thread, so that the thread of the window has priority.
#[cfg(unix)]
const NICENESS: i32 = 10;

/// The state of the render thread.
struct RenderThread<'a> {
    shared: &'a Arc<Shared>,
    args: &'a RenderArgs,
    device: Arc<Device>,
    /// The scene, with the camera of the target.
    scene: Scene,
    /// The camera in the scene file.
    home: Camera,
    /// The scene file.
    path: PathBuf,
    loads: u64,
    /// The render in progress; `None` before the first one, and if scene or options cannot be rendered.
    render: Option<Render>,
    /// Images of the same target with other parts of the light: at most one for each part.
    kept: Vec<Kept>,
    /// The target that has failed, and the error. It is not tried again.
    failed: Option<(Target, String)>,
    /// Files that wait for an iteration.
    saves: Vec<Save>,
    /// The coarseness of the first image of a target.
    coarsest: u32,
}

/// Opens the device and renders until the window closes.
pub fn run(shared: &Arc<Shared>, args: &RenderArgs, scene: Scene) {
    // The threads of a software device inherit the niceness. If it cannot be set, that is no error.
    #[cfg(unix)]
    let _ = rustix::process::nice(NICENESS);
    match open_device(args.device.as_deref(), args.validate) {
        Ok(device) => run_on(&Arc::new(device), shared, args, scene),
        Err(error) => without_device(shared, &error.to_string()),
    }
}

/// Renders on a device until the window closes.
pub fn run_on(device: &Arc<Device>, shared: &Arc<Shared>, args: &RenderArgs, scene: Scene) {
    shared.tell(|news| news.status.device.clone_from(&device.info().name));
    let mut thread = RenderThread {
        shared,
        args,
        device: Arc::clone(device),
        home: scene.camera,
        scene,
        path: args.scene.clone(),
        loads: 0,
        render: None,
        kept: Vec::new(),
        failed: None,
        saves: Vec::new(),
        coarsest: COARSE[1],
    };
    loop {
        let mut wish = shared.take_wish();
        thread.saves.append(&mut wish.saves);
        let next = thread.next(&wish);
        if next == Next::End {
            break;
        }
        if let Err(failure) = thread.step(next, &wish) {
            thread.fail(next, &wish, &failure);
        }
    }
    drop(thread);
    let messages = device.validation_messages();
    shared.tell(|news| news.validation = messages);
}

/// Answers all wishes with an error, because there is no device.
fn without_device(shared: &Shared, error: &str) {
    shared.tell(|news| {
        news.message = Some(Err(error.to_owned()));
        news.status.does(Doing::Failed);
    });
    loop {
        let wish = shared.take_wish();
        refuse(shared, &wish, &wish.saves, error);
        if wish.close {
            return;
        }
        shared.wait(IDLE);
    }
}

/// Reports that files are not written, with the reason.
fn refuse(shared: &Shared, wish: &Wish, saves: &[Save], why: &str) {
    for save in saves {
        let path = save.path.display();
        not_written(shared, wish, Failure::Unwritten(format!("{path}: not written, there is no image: {why}")));
    }
}

fn not_written(shared: &Shared, wish: &Wish, failure: Failure) {
    shared.tell(|news| {
        if wish.close {
            news.unwritten.push(failure);
        } else {
            news.message = Some(Err(failure.to_string()));
        }
    });
}

/// Returns the scene file and all files that it includes.
pub fn files(path: &Path, scene: &Scene) -> Vec<PathBuf> {
    [path.to_owned()].into_iter().chain(scene.included.iter().cloned()).collect()
}

impl RenderThread<'_> {
    fn next(&self, wish: &Wish) -> Next {
        let standing = Standing {
            loads: self.loads,
            render: self.render.as_ref().map(Render::standing),
            failed: self.failed.as_ref().map(|(target, _)| target),
            is_aside: self.kept.iter().any(|kept| kept.target == wish.target),
            coarsest: self.coarsest,
            most: self.args.request.limits.iterations.unwrap_or(u32::MAX),
            saves: &self.saves,
        };
        next(wish, &standing, wish.moved.is_some_and(|moved| moved.elapsed() < REST))
    }

    fn step(&mut self, next: Next, wish: &Wish) -> Result<(), Failure> {
        if let Next::Save(index) = next {
            let save = self.saves.remove(index);
            return self.save(wish, &save);
        }
        if next != Next::Load && self.failed.as_ref().is_some_and(|(target, _)| *target != wish.target) {
            self.failed = None;
            self.shared.tell(|news| news.message = Some(Ok("trying again".to_owned())));
        }
        let doing = match &self.render {
            _ if self.failed.is_some() => Doing::Failed,
            Some(render) if render.coarseness > 1 => Doing::Looks,
            _ if next != Next::Iterate && wish.paused => Doing::Pauses,
            _ => Doing::Renders,
        };
        match next {
            Next::Follow => self.saves.iter_mut().for_each(|save| {
                (save.target, save.quantity) = (wish.target.clone(), wish.quantity);
            }),
            Next::Load => self.load(wish),
            Next::Aim(coarseness) => self.aim(wish, coarseness)?,
            Next::Iterate => self.iterate(wish, doing)?,
            Next::Show => {
                if let Some(render) = &mut self.render {
                    render.tell(self.shared, wish.quantity, doing, None)?;
                }
            }
            Next::Refuse => {
                let why = self.failed.as_ref().map_or_else(String::new, |(_, why)| why.clone());
                refuse(self.shared, wish, &std::mem::take(&mut self.saves), &why);
            }
            Next::Rest => {
                self.says(if wish.paused { Doing::Pauses } else { Doing::IsDone });
                self.shared.wait(IDLE);
            }
            Next::Save(_) | Next::End => {}
        }
        Ok(())
    }

    /// Reports the failure of a step. Its target is not tried again.
    fn fail(&mut self, next: Next, wish: &Wish, failure: &Failure) {
        // Options are refused before anything changes, and a failed iteration leaves the iterations before
        // it.
        let is_left = next == Next::Iterate || matches!(failure, Failure::Render(RenderError::Option(_)));
        if !is_left {
            self.render = None;
        }
        self.failed = Some((wish.target.clone(), failure.to_string()));
        self.shared.tell(|news| {
            news.message = Some(Err(failure.to_string()));
            news.status.does(Doing::Failed);
        });
    }

    fn says(&self, doing: Doing) {
        if self.shared.news().status.doing != doing && self.failed.is_none() {
            self.shared.tell(|news| news.status.does(doing));
        }
    }

    /// Writes a file. A failure is reported, and does not end the render.
    fn save(&mut self, wish: &Wish, save: &Save) -> Result<(), Failure> {
        let Some(render) = &mut self.render else { return Ok(()) };
        let save = &save.with_free_name();
        let files = Files::default().reads_scene(&self.path, &self.scene).writes(AN_IMAGE, [&save.path]);
        let saved = files.check().and_then(|()| render.save(self.shared, self.args, &self.path, save));
        if let Err(failure) = saved {
            not_written(self.shared, wish, failure);
        }
        Ok(())
    }

    /// Runs an iteration, and gives it up if the wish changes meanwhile.
    fn iterate(&mut self, wish: &Wish, doing: Doing) -> Result<(), Failure> {
        let Some(render) = &mut self.render else { return Ok(()) };
        render.moves = wish.moves;
        let before = self.device.pass_times();
        let start = Instant::now();
        // First images are quick and useful during a movement, so they are not given up. Other iterations are
        // given up for another target or, after the first one, because the window is closed. They are not
        // given up for another quantity: the visible points on the device would then be of an iteration that
        // is not finished, and their normals, depths and radii are shown.
        let is_first = render.coarseness == self.coarsest;
        let can_wait = render.renderer.iterations() == 0;
        let shared = self.shared;
        let gives_up = || !is_first && shared.in_hurry() && !shared.still_wants(&wish.target, !can_wait);
        if render.renderer.step_unless(&gives_up)? {
            render.time += start.elapsed();
            render.passes = since(&before, self.device.pass_times());
            render.tell_soon(self.shared, wish.quantity, doing)?;
            if is_first {
                self.observe(start.elapsed());
            }
        }
        Ok(())
    }

    /// Reads the wished scene. If this fails, the old scene stays.
    fn load(&mut self, wish: &Wish) {
        self.says(Doing::Reads);
        self.loads = wish.target.loads;
        match Scene::load_within(&wish.scene, self.scene.budget.anew()) {
            Ok(scene) => {
                let (path, camera, film) = (wish.scene.clone(), scene.camera, scene.film.clone());
                let loaded = Loaded { path, camera, film, loads: self.loads, integrator: scene.integrator };
                let message = scene.warnings.first().map_or_else(|| "read the scene".to_owned(), Clone::clone);
                self.shared.tell(|news| {
                    (news.loaded, news.message) = (Some(loaded), Some(Ok(message)));
                    news.files = Some(files(&wish.scene, &scene));
                });
                (self.home, self.scene) = (scene.camera, scene);
                self.path.clone_from(&wish.scene);
                (self.render, self.failed) = (None, None);
                self.kept.clear();
            }
            Err(error) => {
                // The render in progress is still the wished one.
                let render = self.render.iter_mut().map(|render| &mut render.target);
                let kept = self.kept.iter_mut().map(|kept| &mut kept.target);
                let failed = self.failed.iter_mut().map(|(target, _)| target);
                render.chain(kept).chain(failed).for_each(|target| target.loads = self.loads);
                self.shared.tell(|news| (news.unread, news.message) = (Some(self.loads), Some(Err(error.to_string()))));
            }
        }
    }

    /// Adapts the coarseness of first images to the time that one took.
    fn observe(&mut self, took: Duration) {
        // Half the coarseness means four times the pixels and about four times the time.
        let other = if took > AT_ONCE { 2 * self.coarsest } else { self.coarsest / 2 };
        if took > AT_ONCE || 5 * took < AT_ONCE {
            self.coarsest = other.clamp(COARSE[0], COARSE[1]);
        }
    }

    /// Starts to render the wished target at a coarseness, or continues its render if it was kept.
    fn aim(&mut self, wish: &Wish, coarseness: u32) -> Result<(), Failure> {
        let target = &wish.target;
        self.keep(target)?;
        self.scene.camera = target.camera.unwrap_or(self.home);
        let options = coarse(&target.options, &self.scene, coarseness);
        let restarted = match &mut self.render {
            Some(render) => render.restart(&self.scene, &options, target, coarseness)?,
            None => false,
        };
        if !restarted {
            // The old renderer is dropped first, so that there are never two in memory.
            self.render = None;
            let prepared = Prepared::new(&self.scene, &target.options, observer(Arc::clone(self.shared)))?;
            let mut renderer = prepared.build(Arc::clone(&self.device))?;
            renderer.restart(&self.scene, &options)?;
            self.render = Some(Render::new(renderer, target.clone(), coarseness));
            self.says(if coarseness > 1 { Doing::Looks } else { Doing::Renders });
        }
        let kept = self.kept.iter().position(|kept| kept.target == *target);
        if let Some((render, place)) = self.render.as_mut().zip(kept) {
            render.take_up(self.kept.swap_remove(place))?;
        }
        if let Some(render) = &mut self.render {
            render.moves = wish.moves;
        }
        Ok(())
    }

    /// Keeps the current image if its target differs from the wished one only by the part of the light or by the
    /// layers, because users switch between these. Drops kept images of other targets.
    fn keep(&mut self, wished: &Target) -> Result<(), Failure> {
        self.kept.retain(|kept| kept.target.is_alike(wished));
        let Some(render) = self.render.as_ref().filter(|render| render.target.is_alike(wished)) else { return Ok(()) };
        if render.target != *wished {
            self.kept.extend(render.keep()?);
        }
        Ok(())
    }
}

/// Returns an observer that tells the window what users wait for. What else a render does, pictures tell.
fn observer(shared: Arc<Shared>) -> Observer {
    Observer::new(move |activity| match activity {
        Activity::Rendering | Activity::Writing => {}
        activity => shared.tell(|news| news.status.does(Doing::Prepares(activity))),
    })
}

/// Returns the options of a coarser image, with 1 / `coarseness` of the pixels along each axis, fewer
/// photons, a larger radius and one eye path; unchanged options for a coarseness of 1.
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

/// Returns the time of each pass since `before`.
fn since(before: &[(&'static str, Duration)], now: Vec<(&'static str, Duration)>) -> Vec<(&'static str, Duration)> {
    let earlier = |name| before.iter().find(|(other, _)| *other == name).map_or(Duration::ZERO, |(_, time)| *time);
    now.into_iter().map(|(name, time)| (name, time.saturating_sub(earlier(name)))).collect()
}
