//! The results of one setting, as means over its turns.

use std::collections::BTreeMap;

use serde::Serialize;

use super::error_of::ErrorOf;
use super::knob::Setting;
use super::trajectory::Trajectory;

/// The results of one setting.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Measured {
    /// Its name in reports.
    pub label: String,
    /// The values that are varied, as the command line has them.
    pub knobs: BTreeMap<&'static str, String>,
    /// All options, as `goblet render` takes them.
    pub options: String,
    /// Seconds to build the hierarchy, upload it and compile the kernels; mean over turns.
    pub start_seconds: f64,
    /// Device memory that the render holds.
    pub device_memory_bytes: u64,
    /// Seconds of the device for an iteration, by kernel; mean over turns.
    pub passes: BTreeMap<&'static str, f64>,
    /// In the order of iterations.
    pub points: Vec<Point>,
    /// Whether one of its points is on the Pareto front.
    pub on_front: bool,
}

/// The image of a setting at one iteration: means over turns.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Point {
    /// Number of iterations.
    pub iterations: u32,
    /// Photons emitted by these iterations.
    pub photons: u64,
    /// Seconds of iterations, without start and measuring.
    pub seconds: f64,
    /// Mean over pixels and channels of (x - r)² / (r² + 0.01).
    pub relmse: f64,
    /// relMSE without the 0.1 % worst pixels.
    pub relmse_trimmed: f64,
    /// Mean of the image over the mean of the reference.
    pub energy_ratio: f64,
    /// Mean of LDR-FLIP.
    pub flip: f64,
    /// relMSE as a sum of bias and noise; null for a single turn.
    pub separated: Option<Bias>,
    /// Whether no point of any setting has less error in less time: the Pareto front.
    pub on_front: bool,
    /// The values of each turn.
    pub runs: Vec<Run>,
}

/// The parts of relMSE, estimated from several turns. The noise of the reference counts as bias.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Bias {
    /// relMSE of the mean of infinitely many images. An estimate can be below 0.
    pub bias: f64,
    /// Mean squared difference of an image from that mean.
    pub noise: f64,
}

/// The error at a point in one turn.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Run {
    /// As [`Point::seconds`].
    pub seconds: f64,
    /// As [`Point::relmse`].
    pub relmse: f64,
    /// As [`Point::relmse_trimmed`].
    pub relmse_trimmed: f64,
    /// As [`Point::energy_ratio`].
    pub energy_ratio: f64,
    /// As [`Point::flip`].
    pub flip: f64,
}

impl Bias {
    /// Separates the mean relMSE of `images` images by the relMSE of their mean, which has all of the bias
    /// and 1 / `images` of the noise. `None` for a single image.
    pub fn new(relmse: f64, of_mean: f64, images: usize) -> Option<Self> {
        let images = images as f64;
        let noise = (relmse - of_mean) * images / (images - 1.0);
        (images > 1.0).then_some(Self { bias: relmse - noise, noise })
    }
}

impl Measured {
    /// Summarises the runs of a setting; `of_means` has the relMSE of their mean image at each point.
    pub fn new(setting: &Setting, runs: &[Trajectory], of_means: &[f64]) -> Self {
        let mean = |values: &mut dyn Iterator<Item = f64>| values.sum::<f64>() / runs.len() as f64;
        let points = runs.first().map_or(0, |run| run.steps.len());
        let point = |i: usize| {
            let first = runs[0].steps[i];
            let step = |run: &Trajectory| run.steps[i.min(run.steps.len() - 1)];
            let relmse = mean(&mut runs.iter().map(|run| step(run).error.relmse));
            Point {
                iterations: first.iterations,
                photons: first.photons,
                seconds: mean(&mut runs.iter().map(|run| step(run).seconds)),
                relmse,
                relmse_trimmed: mean(&mut runs.iter().map(|run| step(run).error.relmse_trimmed)),
                energy_ratio: mean(&mut runs.iter().map(|run| step(run).error.energy_ratio)),
                flip: mean(&mut runs.iter().map(|run| step(run).error.flip)),
                separated: of_means.get(i).and_then(|of_mean| Bias::new(relmse, *of_mean, runs.len())),
                on_front: false,
                runs: runs.iter().map(|run| Run::new(run, i)).collect(),
            }
        };
        let mut passes = BTreeMap::new();
        for (name, seconds) in runs.iter().flat_map(|run| &run.passes) {
            *passes.entry(*name).or_insert(0.0) += seconds / runs.len() as f64;
        }
        Self {
            label: setting.label(),
            knobs: setting.knobs.clone(),
            options: setting.options_text().trim().to_owned(),
            start_seconds: mean(&mut runs.iter().map(|run| run.start_seconds)),
            device_memory_bytes: runs.iter().map(|run| run.device_memory_bytes).max().unwrap_or(0),
            passes,
            points: (0..points).map(point).collect(),
            on_front: false,
        }
    }
}

impl Run {
    fn new(run: &Trajectory, i: usize) -> Self {
        let step = run.steps[i.min(run.steps.len() - 1)];
        let ErrorOf { relmse, relmse_trimmed, energy_ratio, flip } = step.error;
        Self { seconds: step.seconds, relmse, relmse_trimmed, energy_ratio, flip }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bias_is_what_averaging_leaves() {
        let Bias { bias, noise } = Bias::new(5.0, 2.0, 4).unwrap();
        assert_eq!((bias, noise), (1.0, 4.0));
        assert!(Bias::new(1.0, 1.0, 1).is_none());
    }
}
