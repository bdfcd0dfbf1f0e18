//! What each setting of a render is worth: its error against time, measured on this device.
//!
//! In a turn, all settings have the same seed and take slices of time one after the other, to
//! and fro, so that what else the machine does favours none. The first turn renders each for
//! the budget, and the others as many iterations, so that images of the same iteration can be
//! set side by side: what they differ by is noise, and what their mean is off by is bias.

mod error_of;
mod knob;
mod plot;
pub mod report;
mod results;
mod trajectory;

pub use error_of::{ErrorOf, Reference};
pub use knob::{KnobError, Setting, Vary, knobs, settings};
pub use results::{Bias, Conditions, Measured, Point, Results, Source};
pub use trajectory::{Budget, Run, Trajectory};

use std::sync::Arc;
use std::time::Duration;

use goblet_host::Device;

use crate::image::film::{Image, Window};
use crate::render::renderer::RenderError;
use crate::scene::Scene;

/// The budget is spent in so many slices.
const SLICES: u32 = 10;
/// Renders side by side may hold this part of the device's memory.
const MEMORY_SHARE: u64 = 3;

/// A measurement in progress: its settings, and what is known of each.
pub struct Measurement<'a> {
    device: &'a Arc<Device>,
    scene: &'a Scene,
    reference: &'a Reference,
    settings: &'a [Setting],
    /// Of the first turn.
    budget: Duration,
    known: Vec<Known>,
}

/// What the turns of a setting left.
#[derive(Default)]
struct Known {
    runs: Vec<Trajectory>,
    /// For each point, the sum over runs of each pixel's weighted difference.
    differences: Vec<Vec<[f32; 3]>>,
    last_image: Option<Image>,
}

impl<'a> Measurement<'a> {
    /// Nothing is rendered yet.
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

    /// Renders every setting once more, with the next seed; says of each what came out.
    ///
    /// # Errors
    /// A setting does not fit the scene, or the device fails.
    pub fn turn(&mut self, turn: u32, mut say: impl FnMut(&Setting, &Trajectory)) -> Result<(), RenderError> {
        let mut waiting: Vec<usize> = (0..self.settings.len()).collect();
        if turn % 2 == 1 {
            waiting.reverse();
        }
        let room = self.device.info().memory_bytes / MEMORY_SHARE;
        while !waiting.is_empty() {
            // As many as fit run side by side.
            let mut group = Vec::new();
            let mut held = 0;
            while let Some(index) = waiting.first().copied().filter(|_| held < room || group.is_empty()) {
                let run = self.begin(index, turn)?;
                held += run.device_memory_bytes();
                group.push((index, run));
                waiting.remove(0);
            }
            while !group.is_empty() {
                let mut going = Vec::new();
                for (index, mut run) in group {
                    if self.advance(index, &mut run)? {
                        let run = run.finish();
                        say(&self.settings[index], &run);
                        self.known[index].runs.push(run);
                    } else {
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

    /// Lets a run go on for its slice.
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

    /// All that is known so far.
    pub fn results(&self, conditions: Conditions) -> Results {
        let measured = self.settings.iter().zip(&self.known).map(|(setting, known)| {
            let biases = known.differences.iter().map(|sums| self.reference.squared_mean(sums, known.runs.len()));
            Measured::new(setting, &known.runs, &biases.collect::<Vec<_>>())
        });
        Results::new(conditions, measured.collect())
    }

    /// The last image of each setting, where it lies in what the camera sees, and where it is
    /// off; `None` before the first turn.
    pub fn images(&self) -> impl Iterator<Item = Option<(&Image, Window, Option<Image>)>> {
        self.known.iter().zip(self.settings).map(|(known, setting)| {
            let image = known.last_image.as_ref()?;
            let film = &self.scene.film;
            let window = film.part(setting.request.options.resolution.unwrap_or(film.resolution));
            Some((image, window, self.reference.difference_image(image).ok()))
        })
    }
}
