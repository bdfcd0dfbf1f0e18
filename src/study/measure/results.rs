//! The results of a measurement, which are written to `results.json` and `results.csv`.

use std::collections::BTreeMap;
use std::error::Error;

use serde::Serialize;

use super::knob::Setting;
use super::trajectory::Trajectory;
use crate::study::machine::Machine;

/// The reference of the errors.
#[derive(Clone, Debug, Serialize)]
pub struct Source {
    /// The file.
    pub path: String,
    /// Width and height in pixels.
    pub resolution: [u32; 2],
    /// Iterations of a reference that goblet has rendered itself; null for one that was given.
    pub own_iterations: Option<u32>,
    /// Estimated relative error from noise of a reference that goblet has rendered itself.
    pub own_relative_error: Option<f64>,
}

/// The conditions that all settings have in common.
#[derive(Clone, Debug, Serialize)]
pub struct Conditions {
    /// Device, driver, commit, date.
    pub machine: Machine,
    /// The command line.
    pub command: String,
    /// The scene's file.
    pub scene: String,
    /// The image that counts as correct.
    pub reference: Source,
    /// Seconds for each setting, in the first turn.
    pub budget: f64,
    /// Number of turns, each with another seed.
    pub repeat: u32,
}

/// The contents of `results.json`.
#[derive(Clone, Debug, Serialize)]
pub struct Results {
    /// The conditions that all settings have in common.
    #[serde(flatten)]
    pub conditions: Conditions,
    /// In the order of the command line.
    pub settings: Vec<Measured>,
}

/// The results of one setting.
#[derive(Clone, Debug, Serialize)]
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
#[derive(Clone, Debug, Serialize)]
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
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Bias {
    /// relMSE of the mean of infinitely many images. An estimate can be below 0.
    pub bias: f64,
    /// Mean squared difference of an image from that mean.
    pub noise: f64,
}

/// The error at a point in one turn.
#[derive(Clone, Debug, Serialize)]
pub struct Run {
    /// As [`Point::seconds`].
    pub seconds: f64,
    /// As [`Point::relmse`].
    pub relmse: f64,
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
        let error = step.error;
        Self { seconds: step.seconds, relmse: error.relmse, energy_ratio: error.energy_ratio, flip: error.flip }
    }
}

impl Results {
    /// Marks the Pareto front: the points for which no other has less error in the same time or less.
    pub fn new(conditions: Conditions, mut settings: Vec<Measured>) -> Self {
        let all: Vec<[f64; 2]> =
            settings.iter().flat_map(|setting| &setting.points).map(|point| [point.seconds, point.relmse]).collect();
        for setting in &mut settings {
            for point in &mut setting.points {
                let beats = |other: &[f64; 2]| {
                    other[0] <= point.seconds && other[1] <= point.relmse && *other != [point.seconds, point.relmse]
                };
                point.on_front = point.relmse.is_finite() && !all.iter().any(beats);
            }
            setting.on_front = setting.points.iter().any(|point| point.on_front);
        }
        Self { conditions, settings }
    }

    /// Returns the points of all settings as CSV: a line for each, after a line of names.
    ///
    /// # Errors
    /// The writer fails; into memory it does not.
    pub fn csv(&self) -> Result<String, Box<dyn Error>> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        for setting in &self.settings {
            for point in &setting.points {
                writer.serialize(Line::new(setting, point))?;
            }
        }
        Ok(String::from_utf8(writer.into_inner()?)?)
    }
}

/// A line of `results.csv`. Its fields are those of [`Point`].
#[derive(Serialize)]
struct Line<'a> {
    setting: &'a str,
    iterations: u32,
    photons: u64,
    seconds: f64,
    relmse: f64,
    relmse_trimmed: f64,
    energy_ratio: f64,
    flip: f64,
    /// Empty for a single turn, as is `noise`.
    bias: Option<f64>,
    noise: Option<f64>,
    on_front: bool,
}

impl<'a> Line<'a> {
    fn new(setting: &'a Measured, point: &Point) -> Self {
        Self {
            setting: &setting.label,
            iterations: point.iterations,
            photons: point.photons,
            seconds: point.seconds,
            relmse: point.relmse,
            relmse_trimmed: point.relmse_trimmed,
            energy_ratio: point.energy_ratio,
            flip: point.flip,
            bias: point.separated.map(|separated| separated.bias),
            noise: point.separated.map(|separated| separated.noise),
            on_front: point.on_front,
        }
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

    #[test]
    fn the_table_has_a_line_for_each_point_and_quotes_names() {
        let point = |separated| Point {
            iterations: 2,
            photons: 3,
            seconds: 0.5,
            relmse: 0.25,
            relmse_trimmed: 0.125,
            energy_ratio: 1.0,
            flip: 0.75,
            separated,
            on_front: true,
            runs: Vec::new(),
        };
        let setting = Measured {
            label: "a \"b\", c".to_owned(),
            knobs: BTreeMap::new(),
            options: String::new(),
            start_seconds: 0.0,
            device_memory_bytes: 0,
            passes: BTreeMap::new(),
            points: vec![point(None), point(Some(Bias { bias: 0.0625, noise: 4.0 }))],
            on_front: true,
        };
        let results = Results { conditions: conditions(), settings: vec![setting] };
        let expected = "setting,iterations,photons,seconds,relmse,relmse_trimmed,energy_ratio,flip,bias,noise,on_front\n\
                        \"a \"\"b\"\", c\",2,3,0.5,0.25,0.125,1.0,0.75,,,true\n\
                        \"a \"\"b\"\", c\",2,3,0.5,0.25,0.125,1.0,0.75,0.0625,4.0,true\n";
        assert_eq!(results.csv().unwrap(), expected);
    }

    fn conditions() -> Conditions {
        let text = || "x".to_owned();
        let machine = Machine { goblet: "0", commit: None, date: text(), device: text(), driver: text(), cpus: None };
        let reference = Source { path: text(), resolution: [1, 1], own_iterations: None, own_relative_error: None };
        Conditions { machine, command: text(), scene: text(), reference, budget: 1.0, repeat: 1 }
    }
}
