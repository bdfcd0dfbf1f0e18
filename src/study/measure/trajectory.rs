//! One render of one setting, and its error on the way.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use goblet_host::Device;

use super::ErrorOf;
use crate::image::compare::SizeMismatch;
use crate::image::film::Image;
use crate::render::options::Options;
use crate::render::renderer::{RenderError, Renderer};
use crate::scene::Scene;

/// When a run ends: at least one iteration is rendered.
#[derive(Clone, Copy, Debug)]
pub struct Budget {
    /// Of iterations; measuring is not counted.
    pub time: Duration,
    /// If there, the most.
    pub iterations: Option<u32>,
}

/// The image of a run at one of its iterations.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// So far.
    pub iterations: u32,
    /// So far.
    pub photons: u64,
    /// So far, of iterations alone.
    pub seconds: f64,
    /// How far it is from the reference.
    pub error: ErrorOf,
}

/// What a run left.
#[derive(Clone, Debug)]
pub struct Trajectory {
    /// At geometric steps; the last is the end.
    pub steps: Vec<Step>,
    /// To build the hierarchy, upload and compile.
    pub start_seconds: f64,
    /// Of the device, an iteration, by kernel.
    pub passes: BTreeMap<&'static str, f64>,
    /// Held while it rendered.
    pub device_memory_bytes: u64,
}

impl Trajectory {
    /// All that it rendered.
    pub fn iterations(&self) -> u32 {
        self.steps.last().map_or(0, |step| step.iterations)
    }
}

/// A run that is not over: others may run between its iterations.
pub struct Run {
    renderer: Renderer,
    budget: Budget,
    spent: Duration,
    steps: Vec<Step>,
    passes: BTreeMap<&'static str, Duration>,
    device_memory_bytes: u64,
}

/// What is measured of an image, which is the next of its run.
pub type Measure<'a> = dyn FnMut(&Image) -> Result<ErrorOf, SizeMismatch> + 'a;

impl Run {
    /// Prepares, and renders nothing.
    ///
    /// # Errors
    /// The options do not fit the scene, or the device fails.
    pub fn new(device: &Arc<Device>, scene: &Scene, options: &Options, budget: Budget) -> Result<Self, RenderError> {
        let before = device.allocated_bytes();
        let renderer = Renderer::new(Arc::clone(device), scene, options)?;
        let device_memory_bytes = device.allocated_bytes().saturating_sub(before);
        let (spent, steps, passes) = Default::default();
        Ok(Self { renderer, budget, spent, steps, passes, device_memory_bytes })
    }

    /// Held until it is over.
    pub fn device_memory_bytes(&self) -> u64 {
        self.device_memory_bytes
    }

    /// How often it was measured.
    pub fn points(&self) -> usize {
        self.steps.len()
    }

    /// Renders for a while, one iteration at least, and measures at 1, 2, 3, 4, 6, 8, 11 and so
    /// on: each is about the root of 2 times the one before. Whether it is over.
    ///
    /// # Errors
    /// The device fails, or images have another size than the reference.
    pub fn advance(&mut self, slice: Duration, measure: &mut Measure) -> Result<bool, RenderError> {
        let until = self.spent + slice;
        let before = self.pass_times();
        while !self.is_over() {
            let start = Instant::now();
            self.renderer.step()?;
            self.spent += start.elapsed();
            let next = self.steps.last().map_or(1, |step| following(step.iterations));
            if self.renderer.iterations() >= next || self.is_over() {
                let image = self.renderer.resolve()?;
                let error = measure(&image).map_err(|reason| RenderError::Option(reason.to_string()))?;
                self.steps.push(Step {
                    iterations: self.renderer.iterations(),
                    photons: self.renderer.photons(),
                    seconds: self.spent.as_secs_f64(),
                    error,
                });
            }
            if self.spent >= until {
                break;
            }
        }
        for (name, time) in self.pass_times() {
            let before = before.get(name).copied().unwrap_or_default();
            *self.passes.entry(name).or_default() += time.saturating_sub(before);
        }
        Ok(self.is_over())
    }

    fn is_over(&self) -> bool {
        let most = self.budget.iterations.unwrap_or(u32::MAX).max(1);
        let iterations = self.renderer.iterations();
        iterations >= most || (iterations > 0 && self.spent >= self.budget.time)
    }

    fn pass_times(&self) -> BTreeMap<&'static str, Duration> {
        self.renderer.device().pass_times().into_iter().collect()
    }

    /// What it left.
    pub fn finish(self) -> Trajectory {
        let iterations = f64::from(self.renderer.iterations().max(1));
        let passes = self.passes.into_iter().map(|(name, time)| (name, time.as_secs_f64() / iterations));
        Trajectory {
            steps: self.steps,
            start_seconds: (self.renderer.build_time() + self.renderer.compile_time()).as_secs_f64(),
            passes: passes.filter(|(_, seconds)| *seconds > 0.0).collect(),
            device_memory_bytes: self.device_memory_bytes,
        }
    }
}

/// The next iteration to be measured: every second is twice the one before the last.
fn following(iterations: u32) -> u32 {
    let next = (f64::from(iterations) * std::f64::consts::SQRT_2).round() as u32;
    next.max(iterations.saturating_add(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_geometric() {
        let steps: Vec<u32> = std::iter::successors(Some(1), |n| Some(following(*n))).take(9).collect();
        assert_eq!(steps, [1, 2, 3, 4, 6, 8, 11, 16, 23]);
    }
}
