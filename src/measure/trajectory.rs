//! One render of one setting, and its error on the way.

use std::collections::BTreeMap;
use std::rc::Rc;
use std::time::{Duration, Instant};

use goblet_host::Device;

use super::ErrorOf;
use crate::compare::SizeMismatch;
use crate::film::Image;
use crate::options::Options;
use crate::renderer::{RenderError, Renderer};
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
    /// Renders, and measures at 1, 2, 3, 4, 6, 8, 11 and so on: each is about the root of 2
    /// times the one before.
    ///
    /// # Errors
    /// The options do not fit the scene, the device fails, or images have another size than
    /// the reference.
    pub fn render(
        device: &Rc<Device>,
        scene: &Scene,
        options: &Options,
        budget: Budget,
        mut measure: impl FnMut(&Image) -> Result<ErrorOf, SizeMismatch>,
    ) -> Result<Self, RenderError> {
        let mut renderer = Renderer::new(Rc::clone(device), scene, options)?;
        let most = budget.iterations.unwrap_or(u32::MAX).max(1);
        let before: BTreeMap<_, _> = device.pass_times().into_iter().collect();
        let (mut spent, mut next, mut steps) = (Duration::ZERO, 1, Vec::new());
        loop {
            let start = Instant::now();
            renderer.step()?;
            spent += start.elapsed();
            let iterations = renderer.iterations();
            let is_last = iterations >= most || spent >= budget.time;
            if iterations >= next || is_last {
                let error = measure(&renderer.resolve()?).map_err(|reason| RenderError::Option(reason.to_string()))?;
                steps.push(Step { iterations, photons: renderer.photons(), seconds: spent.as_secs_f64(), error });
                next = following(iterations);
            }
            if is_last {
                break;
            }
        }
        let iterations = f64::from(renderer.iterations());
        let passes = device.pass_times().into_iter().map(|(name, time)| {
            let before = before.get(name).copied().unwrap_or_default();
            (name, time.saturating_sub(before).as_secs_f64() / iterations)
        });
        Ok(Self {
            steps,
            start_seconds: (renderer.build_time() + renderer.compile_time()).as_secs_f64(),
            passes: passes.filter(|(_, seconds)| *seconds > 0.0).collect(),
            device_memory_bytes: device.allocated_bytes(),
        })
    }

    /// All that it rendered.
    pub fn iterations(&self) -> u32 {
        self.steps.last().map_or(0, |step| step.iterations)
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
