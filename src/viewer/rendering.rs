//! A render in progress: what the window is told of it, and what is written.

use std::path::Path;
use std::time::{Duration, Instant};

use super::plan::Rendered;
use super::quantity::Quantity;
use super::shared::{Save, Shared, Status, Target, View};
use crate::cli::render::{at, metadata, save_checkpoint, scene_name, write_images};
use crate::cli::{Failure, RenderArgs};
use crate::render::aov;
use crate::render::checkpoint::MadeBy;
use crate::render::options::{Contribution, Options};
use crate::render::renderer::{Aside, Renderer};
use crate::scene::Scene;

/// Pictures of quick iterations need not come more often.
const LEAST_BETWEEN_VIEWS: Duration = Duration::from_millis(30);
/// The error is estimated, and costs time, so often.
const BETWEEN_ERRORS: Duration = Duration::from_secs(1);

/// A render in progress.
pub struct Render {
    /// The render.
    pub renderer: Renderer,
    /// What it is of.
    pub target: Target,
    /// Pixels along each axis that are one.
    pub coarseness: u32,
    /// Moves of the camera that it has seen.
    pub moves: u64,
    /// That iterations took.
    pub time: Duration,
    /// The last one, by pass.
    pub passes: Vec<(&'static str, Duration)>,
    error: Option<f64>,
    estimated: Instant,
    /// When the window was last told, after how many iterations, and of what.
    told: Option<(Instant, u32, Quantity)>,
}

/// An image with all its iterations, while another part of its light is looked at.
pub struct Kept {
    /// What it is of.
    pub target: Target,
    render: Aside,
    time: Duration,
    passes: Vec<(&'static str, Duration)>,
    error: Option<f64>,
}

impl Render {
    /// Of something that has no iterations.
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

    /// As far as it matters for what is next.
    pub fn standing(&self) -> Rendered<'_> {
        Rendered {
            target: &self.target,
            coarseness: self.coarseness,
            iterations: self.renderer.iterations(),
            shown: self.told.map(|(_, iterations, quantity)| (iterations, quantity)),
        }
    }

    /// Begins anew with other options, which are of a target at a coarseness, and without
    /// compiling anything; whether that is possible. All is as it was if it is not.
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

    /// Copies it to memory, if it is an image.
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

    /// Goes on with what was kept, after a restart for it.
    ///
    /// # Errors
    /// The device fails.
    pub fn take_up(&mut self, kept: Kept) -> Result<(), Failure> {
        self.renderer.take_up(&kept.render).map_err(|reason| at(Path::new("the image that was kept"), reason))?;
        (self.time, self.passes, self.error) = (kept.time, kept.passes, kept.error);
        Ok(())
    }

    /// Tells the window what there is after an iteration, unless it was told just now.
    ///
    /// # Errors
    /// The device fails.
    pub fn tell_soon(&mut self, shared: &Shared, quantity: Quantity, doing: &'static str) -> Result<(), Failure> {
        let is_soon = self.told.is_some_and(|(when, _, what)| what == quantity && when.elapsed() < LEAST_BETWEEN_VIEWS);
        if is_soon { Ok(()) } else { self.tell(shared, quantity, doing, None) }
    }

    /// Tells the window what there is, and what was done with it.
    ///
    /// # Errors
    /// The device fails.
    pub fn tell(
        &mut self,
        shared: &Shared,
        quantity: Quantity,
        doing: &'static str,
        message: Option<String>,
    ) -> Result<(), Failure> {
        let estimate = self.renderer.estimate()?;
        let is_first = self.told.is_none();
        if self.coarseness == 1 && (self.error.is_none() || self.estimated.elapsed() > BETWEEN_ERRORS) {
            self.error = self.renderer.noise(&estimate)?.relative_error();
            self.estimated = Instant::now();
        }
        let picture = quantity.picture(&self.renderer, &estimate)?;
        let lengths = if is_first { Some(self.renderer.path_lengths()?) } else { None };
        let view = View { picture, moves: self.moves, lengths };
        let iterations = self.renderer.iterations();
        self.told = Some((Instant::now(), iterations, quantity));
        shared.tell(|news| {
            // Lengths that nobody has taken yet are those of this render, if it has not begun just now.
            let kept = news.view.take().and_then(|view| view.lengths).filter(|_| !is_first);
            news.view = Some(View { lengths: view.lengths.or(kept), ..view });
            if let Some(message) = message {
                news.message = Some(Ok(message));
            }
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

    /// Writes what `goblet render` would, an image or a checkpoint by the file's name, and shows
    /// what was written.
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
            let metadata = metadata(&scene, &MadeBy::new(renderer.device()), &estimate, renderer.photons());
            let channels = aov::channels(&args.aov, &estimate, Some(renderer))?;
            write_images(std::slice::from_ref(path), &estimate, &channels, &metadata, true)?;
        }
        self.tell(shared, *quantity, "rendering", Some(wrote(path, &self.target, renderer.iterations())))
    }
}

/// What is said of a file that was written.
fn wrote(path: &Path, target: &Target, iterations: u32) -> String {
    let what = match target.options.contribution {
        Contribution::All => "the image",
        Contribution::Direct => "the direct light",
        Contribution::Photons => "the light of photons",
    };
    let unit = if iterations == 1 { "iteration" } else { "iterations" };
    format!("wrote {}: {what} after {iterations} {unit}", path.display())
}
