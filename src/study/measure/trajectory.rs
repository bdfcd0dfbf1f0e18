//! One render of one setting, whose error is measured as iterations are added.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use goblet_host::Device;

use super::ErrorOf;
use crate::image::compare::SizeMismatch;
use crate::image::film::Image;
use crate::render::error::RenderError;
use crate::render::options::Options;
use crate::render::renderer::Renderer;
use crate::scene::Scene;

/// The end of a run, which renders at least one iteration.
#[derive(Clone, Copy, Debug)]
pub struct Budget {
    /// Time of iterations; the time to measure errors does not count.
    pub time: Duration,
    /// The largest number of iterations; `None` for no limit.
    pub iterations: Option<u32>,
}

/// The error of a run after one of its iterations.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// Number of iterations.
    pub iterations: u32,
    /// Photons emitted by these iterations.
    pub photons: u64,
    /// Seconds of iterations.
    pub seconds: f64,
    /// Error of the image against the reference.
    pub error: ErrorOf,
}

/// The result of a run.
#[derive(Clone, Debug)]
pub struct Trajectory {
    /// At geometric steps of the iteration; the last is the end of the run.
    pub steps: Vec<Step>,
    /// Seconds to build the hierarchy, upload it and compile the kernels.
    pub start_seconds: f64,
    /// Seconds of the device for an iteration, by kernel.
    pub passes: BTreeMap<&'static str, f64>,
    /// Device memory that the run held.
    pub device_memory_bytes: u64,
}

impl Trajectory {
    /// Returns the number of iterations.
    pub fn iterations(&self) -> u32 {
        self.steps.last().map_or(0, |step| step.iterations)
    }
}

/// A run in progress. Others may run between its iterations.
pub struct Run {
    renderer: Renderer,
    budget: Budget,
    spent: Duration,
    steps: Vec<Step>,
    passes: BTreeMap<&'static str, Duration>,
    device_memory_bytes: u64,
}

/// Measures the next image of a run.
pub type Measure<'a> = dyn FnMut(&Image) -> Result<ErrorOf, SizeMismatch> + 'a;

impl Run {
    /// Prepares a run; nothing is rendered yet.
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

    /// Returns the bytes of device memory that the run holds.
    pub fn device_memory_bytes(&self) -> u64 {
        self.device_memory_bytes
    }

    /// Returns the number of images that were measured.
    pub fn points(&self) -> usize {
        self.steps.len()
    }

    /// Renders for a time, at least one iteration, and measures after iterations 1, 2, 3, 4, 6, 8, 11 and so
    /// on, each about √2 times the one before. Returns whether the run has ended.
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

    /// Returns how far the run has come, from 0 to 1.
    pub fn share(&self) -> f64 {
        let by_time = self.spent.as_secs_f64() / self.budget.time.as_secs_f64();
        let most = self.budget.iterations.map(|most| f64::from(most.max(1)));
        let by_count = most.map_or(0.0, |most| f64::from(self.renderer.iterations()) / most);
        by_time.max(by_count).min(1.0)
    }

    fn is_over(&self) -> bool {
        let most = self.budget.iterations.unwrap_or(u32::MAX).max(1);
        let iterations = self.renderer.iterations();
        iterations >= most || (iterations > 0 && self.spent >= self.budget.time)
    }

    fn pass_times(&self) -> BTreeMap<&'static str, Duration> {
        self.renderer.device().pass_times().into_iter().collect()
    }

    /// Returns the result.
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

/// Returns the next iteration to be measured: twice the one before the last, for every second one.
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
