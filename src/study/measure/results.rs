//! The results of a measurement, which are written to `results.json` and `results.csv`.

use std::error::Error;

use serde::Serialize;

use super::measured::{Measured, Point};
use super::verdict::Verdict;
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
    /// The exposure at which FLIP and the report see images, stops: 0 unless the reference is very bright or dark.
    pub exposure_stops: f32,
    /// Which setting is best; null if none has an image.
    pub verdict: Option<Verdict>,
    /// In the order of the command line.
    pub settings: Vec<Measured>,
}

impl Results {
    /// Marks the Pareto front: the points for which no other has less error in the same time or less.
    pub fn new(conditions: Conditions, exposure_stops: f32, mut settings: Vec<Measured>) -> Self {
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
        Self { conditions, exposure_stops, verdict: Verdict::new(&settings), settings }
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
    use std::collections::BTreeMap;

    use super::*;
    use crate::study::measure::measured::Bias;

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
        let results = Results { conditions: conditions(), exposure_stops: 0.0, verdict: None, settings: vec![setting] };
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
