//! Measures the error of each setting of a render against time, on this device.
//!
//! In a turn, all settings have the same seed. They take slices of time one after the other, alternately in
//! forward and in backward order, so that other load of the machine favours no setting. The first turn
//! renders each setting for the budget. Later turns render the same number of iterations as the first, so that
//! the images of different turns can be compared: their difference from each other is noise, and the
//! difference of their mean from the reference is bias.

mod error_of;
mod knob;
mod measured;
mod plot;
pub mod report;
mod results;
mod trajectory;
mod verdict;

pub use error_of::{ErrorOf, Reference};
pub use knob::{KnobError, Setting, Vary, knobs, settings};
pub use measured::{Bias, Measured, Point};
pub use results::{Conditions, Results, Source};
pub use trajectory::{Budget, Run, Trajectory};
pub use verdict::{Rank, Verdict};

use std::sync::Arc;
use std::time::Duration;

use goblet_host::Device;

use report::LastImage;

use crate::image::film::Image;
use crate::render::error::RenderError;
use crate::scene::Scene;

/// Number of slices into which the budget of a setting is divided.
const SLICES: u32 = 10;
/// Renders that run side by side may hold 1 / `MEMORY_SHARE` of the device's free memory.
const MEMORY_SHARE: u64 = 3;

/// A measurement in progress: its settings, and the results of each so far.
pub struct Measurement<'a> {
    device: &'a Arc<Device>,
    scene: &'a Scene,
    reference: &'a Reference,
    settings: &'a [Setting],
    /// Time of iterations of each setting in the first turn.
    budget: Duration,
    known: Vec<Known>,
}

/// Results of the turns of one setting.
#[derive(Default)]
struct Known {
    runs: Vec<Trajectory>,
    /// For each point, the sum over runs of each pixel's difference from the reference, as
    /// [`Reference::add_differences`] weights it.
    differences: Vec<Vec<[f32; 3]>>,
    last_image: Option<Image>,
}

impl<'a> Measurement<'a> {
    /// Starts a measurement; nothing is rendered yet.
    pub fn new(
        device: &'a Arc<Device>,
        scene: &'a Scene,
        reference: &'a Reference,
        settings: &'a [Setting],
        budget: Duration,
    ) -> Self {
        let known = settings.iter().map(|_| Known::default()).collect();
        Self { device, scene, reference, settings, budget, known }
    }

    /// Renders every setting once more, with the next seed, and calls `say` with the result of each. Calls `tell` before
    /// each slice of time with the setting that has it, and with the share of the turn that is done.
    ///
    /// # Errors
    /// A setting does not fit the scene, or the device fails.
    pub fn turn(
        &mut self,
        turn: u32,
        mut tell: impl FnMut(&Setting, f64),
        mut say: impl FnMut(&Setting, &Trajectory),
    ) -> Result<(), RenderError> {
        let (mut ended, all) = (0.0, self.settings.len() as f64);
        let mut waiting: Vec<usize> = (0..self.settings.len()).collect();
        if turn % 2 == 1 {
            waiting.reverse();
        }
        let room = self.device.info().memory.free_bytes / MEMORY_SHARE;
        while !waiting.is_empty() {
            // As many settings as fit into memory run side by side.
            let mut group = Vec::new();
            let mut held = 0;
            while let Some(index) = waiting.first().copied().filter(|_| held < room || group.is_empty()) {
                let of_group: f64 = group.iter().map(|(_, run): &(usize, Run)| run.share()).sum();
                tell(&self.settings[index], (ended + of_group) / all);
                let run = self.begin(index, turn)?;
                held += run.device_memory_bytes();
                group.push((index, run));
                waiting.remove(0);
            }
            while !group.is_empty() {
                let mut going: Vec<(usize, Run)> = Vec::new();
                let mut done: f64 = group.iter().map(|(_, run)| run.share()).sum();
                for (index, mut run) in group {
                    tell(&self.settings[index], (ended + done) / all);
                    done -= run.share();
                    if self.advance(index, &mut run)? {
                        let run = run.finish();
                        say(&self.settings[index], &run);
                        self.known[index].runs.push(run);
                        ended += 1.0;
                    } else {
                        done += run.share();
                        going.push((index, run));
                    }
                }
                group = going;
                group.reverse();
            }
        }
        Ok(())
    }

    fn begin(&self, index: usize, turn: u32) -> Result<Run, RenderError> {
        let setting = &self.settings[index];
        let budget = match self.known[index].runs.first() {
            None => Budget { time: self.budget, iterations: setting.request.limits.iterations },
            Some(first) => Budget { time: Duration::MAX, iterations: Some(first.iterations()) },
        };
        let mut options = setting.request.options.clone();
        options.seed = Some(options.seed.unwrap_or(self.scene.integrator.seed).wrapping_add(turn));
        Run::new(self.device, self.scene, &options, budget)
    }

    /// Runs a render for a slice of time. Returns whether it has ended.
    fn advance(&mut self, index: usize, run: &mut Run) -> Result<bool, RenderError> {
        let Known { differences, last_image, .. } = &mut self.known[index];
        let mut point = run.points();
        run.advance(self.budget / SLICES, &mut |image| {
            let error = self.reference.error_of(image)?;
            if differences.len() == point {
                differences.push(vec![[0.0; 3]; self.reference.pixels()]);
            }
            self.reference.add_differences(image, &mut differences[point])?;
            point += 1;
            *last_image = Some(image.clone());
            Ok(error)
        })
    }

    /// Returns the results so far.
    pub fn results(&self, conditions: Conditions) -> Results {
        let measured = self.settings.iter().zip(&self.known).map(|(setting, known)| {
            let biases = known.differences.iter().map(|sums| self.reference.squared_mean(sums, known.runs.len()));
            Measured::new(setting, &known.runs, &biases.collect::<Vec<_>>())
        });
        Results::new(conditions, self.reference.exposure_stops(), measured.collect())
    }

    /// Returns the image that is taken to be right.
    pub fn reference(&self) -> &Image {
        self.reference.image()
    }

    /// Returns the last image of each setting, with its difference from the reference; `None` before the first turn.
    pub fn images(&self) -> impl Iterator<Item = Option<LastImage<'_>>> {
        self.known.iter().zip(self.settings).map(|(known, setting)| {
            let image = known.last_image.as_ref()?;
            let film = &self.scene.film;
            let window = film.part(setting.request.options.resolution.unwrap_or(film.resolution));
            Some(LastImage { image, window, difference: self.reference.difference(image).ok().flatten() })
        })
    }
}
