//! A render in progress in the viewer: it sends pictures to the window and writes files.

use std::path::Path;
use std::time::{Duration, Instant};

use super::doing::Doing;
use super::guiding::Guiding;
use super::plan::Rendered;
use super::quantity::Quantity;
use super::shared::{Save, Shared, Status, Target, View};
use crate::cli::render::{at, save_checkpoint, scene_name, write_images};
use crate::cli::{Failure, RenderArgs};
use crate::render::aov;
use crate::render::options::{Contribution, Options};
use crate::render::renderer::{Aside, Renderer};
use crate::scene::Scene;

/// The least time between two pictures of the same quantity.
const LEAST_BETWEEN_VIEWS: Duration = Duration::from_millis(30);
/// The least time between two estimates of the error, because an estimate takes time.
const BETWEEN_ERRORS: Duration = Duration::from_secs(1);

/// A render in progress.
pub struct Render {
    /// The renderer.
    pub renderer: Renderer,
    /// The target that is rendered.
    pub target: Target,
    /// The number of image pixels along each axis per rendered pixel.
    pub coarseness: u32,
    /// The number of the last move of the camera in the render.
    pub moves: u64,
    /// The total time of the iterations.
    pub time: Duration,
    /// Device time of the last iteration by pass.
    pub passes: Vec<(&'static str, Duration)>,
    error: Option<f64>,
    estimated: Instant,
    /// The time of the last picture that was sent to the window, its number of iterations, and its quantity.
    told: Option<(Instant, u32, Quantity)>,
}

/// An image with all its iterations, kept while the window shows another part of the light.
pub struct Kept {
    /// The target of the image.
    pub target: Target,
    render: Aside,
    time: Duration,
    passes: Vec<(&'static str, Duration)>,
    error: Option<f64>,
}

impl Render {
    /// Returns the state of a render without iterations.
    pub fn new(renderer: Renderer, target: Target, coarseness: u32) -> Self {
        Self {
            renderer,
            target,
            coarseness,
            moves: 0,
            time: Duration::ZERO,
            passes: Vec::new(),
            error: None,
            estimated: Instant::now(),
            told: None,
        }
    }

    /// Returns the values of the state that decide about the next step.
    pub fn standing(&self) -> Rendered<'_> {
        Rendered {
            target: &self.target,
            coarseness: self.coarseness,
            iterations: self.renderer.iterations(),
            shown: self.told.map(|(_, iterations, quantity)| (iterations, quantity)),
        }
    }

    /// Starts again with the options of another target at a coarseness, without compiling anything. Returns
    /// false and changes nothing if this needs a new renderer.
    ///
    /// # Errors
    /// An option is out of range, or the device fails.
    pub fn restart(
        &mut self,
        scene: &Scene,
        options: &Options,
        target: &Target,
        coarseness: u32,
    ) -> Result<bool, Failure> {
        if !self.renderer.restart(scene, options)? {
            return Ok(false);
        }
        (self.target, self.coarseness) = (target.clone(), coarseness);
        (self.time, self.error, self.told) = (Duration::ZERO, None, None);
        Ok(true)
    }

    /// Copies the render to memory; `None` if it is coarse or has no iteration.
    ///
    /// # Errors
    /// The device fails.
    pub fn keep(&self) -> Result<Option<Kept>, Failure> {
        if !self.standing().is_whole() {
            return Ok(None);
        }
        let (target, passes) = (self.target.clone(), self.passes.clone());
        Ok(Some(Kept { target, render: self.renderer.put_aside()?, time: self.time, passes, error: self.error }))
    }

    /// Continues a render that was kept, after a restart for its target.
    ///
    /// # Errors
    /// The device fails.
    pub fn take_up(&mut self, kept: Kept) -> Result<(), Failure> {
        self.renderer.take_up(&kept.render).map_err(|reason| at(Path::new("the image that was kept"), reason))?;
        (self.time, self.passes, self.error) = (kept.time, kept.passes, kept.error);
        Ok(())
    }

    /// Sends the window a picture after an iteration, unless it has got one of this quantity just now.
    ///
    /// # Errors
    /// The device fails.
    pub fn tell_soon(&mut self, shared: &Shared, quantity: Quantity, doing: Doing) -> Result<(), Failure> {
        let is_soon = self.told.is_some_and(|(when, _, what)| what == quantity && when.elapsed() < LEAST_BETWEEN_VIEWS);
        if is_soon { Ok(()) } else { self.tell(shared, quantity, doing, None) }
    }

    /// Sends the window a picture of the quantity, the status of the render, and a message about a finished
    /// action, if there is one.
    ///
    /// # Errors
    /// The device fails.
    pub fn tell(
        &mut self,
        shared: &Shared,
        quantity: Quantity,
        doing: Doing,
        message: Option<String>,
    ) -> Result<(), Failure> {
        let estimate = self.renderer.estimate()?;
        let is_first = self.told.is_none();
        if self.coarseness == 1 && (self.error.is_none() || self.estimated.elapsed() > BETWEEN_ERRORS) {
            self.error = self.renderer.noise(&estimate)?.relative_error();
            self.estimated = Instant::now();
        }
        let picture = quantity.picture(&estimate);
        let lengths = if is_first { Some(self.renderer.path_lengths()?) } else { None };
        let view = View { picture, moves: self.moves, lengths };
        let iterations = self.renderer.iterations();
        self.told = Some((Instant::now(), iterations, quantity));
        shared.tell(|news| {
            // Lengths that the window has not taken yet are of this render, unless it has begun just now.
            let kept = news.view.take().and_then(|view| view.lengths).filter(|_| !is_first);
            news.view = Some(View { lengths: view.lengths.or(kept), ..view });
            if let Some(message) = message {
                news.message = Some(Ok(message));
            }
            news.status.does(doing);
            news.status = Status {
                doing,
                since: news.status.since,
                iterations,
                photons: self.renderer.tally().emitted,
                time: self.time,
                passes: self.passes.clone(),
                error: self.error,
                guiding: Guiding::of(&self.target.options, self.renderer.follows_photons(), self.renderer.guide()),
                memory: self.renderer.device().allocated_bytes(),
                resolution: estimate.resolution,
                device: std::mem::take(&mut news.status.device),
            };
        });
        Ok(())
    }

    /// Writes the same file as `goblet render`: an image or a checkpoint, by the extension of its name. Sends
    /// the window a picture of the written quantity.
    ///
    /// # Errors
    /// The device fails, or the file cannot be written.
    pub fn save(&mut self, shared: &Shared, args: &RenderArgs, scene: &Path, save: &Save) -> Result<(), Failure> {
        let Save { path, quantity, .. } = save;
        let scene = scene_name(scene);
        let renderer = &self.renderer;
        if path.extension().is_some_and(|extension| extension == "checkpoint") {
            save_checkpoint(&scene, path, renderer)?;
        } else {
            let estimate = renderer.estimate()?;
            let metadata = renderer.metadata(&scene, &estimate);
            let channels = aov::channels(&args.aov, &estimate)?;
            write_images(std::slice::from_ref(path), &estimate, &channels, &metadata, save.exposure, true)?;
        }
        self.tell(shared, *quantity, Doing::Renders, Some(wrote(path, &self.target, renderer.iterations())))
    }
}

/// Returns the message about a file that was written.
fn wrote(path: &Path, target: &Target, iterations: u32) -> String {
    let what = match target.options.contribution {
        Contribution::All => "the image",
        Contribution::Direct => "the direct light",
        Contribution::Photons => "the light of photons",
    };
    let unit = if iterations == 1 { "iteration" } else { "iterations" };
    format!("wrote {}: {what} after {iterations} {unit}", path.display())
}
