//! How the time of an iteration grows with the size of the task.

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use goblet_host::Device;
use serde::Serialize;

use super::Result;
use super::cases::{self, Case};
use super::measure::{Run, Times};

/// Iterations of each size that count, at most.
const REPEATS: usize = 2;
/// A size may have more than one of them only in this share of the series' time.
const SHARE: f64 = 0.25;
/// What would take one iteration longer, setup included, is left out: seconds.
const LONGEST: f64 = 150.0;

/// How time should grow.
#[derive(Clone, Copy, Debug, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Order {
    Constant,
    Logarithmic,
    Linear,
}

/// Tasks that differ in one size.
#[derive(Clone, Copy, Serialize)]
pub struct Series {
    pub name: &'static str,
    pub order: Order,
    /// From here on, what does not grow should no longer count.
    pub big: u64,
    #[serde(skip)]
    sizes: &'static [u64],
    #[serde(skip)]
    case: fn(&Path, u64) -> Result<Case>,
}

/// What takes longest comes last, and has the time that the others left.
pub const SERIES: [Series; 4] = [
    Series {
        name: "lights",
        order: Order::Constant,
        big: 1,
        sizes: &[1, 10, 100, 1_000, 10_000, 100_000],
        case: cases::lights,
    },
    Series {
        name: "pixels",
        order: Order::Linear,
        big: 1 << 18,
        sizes: &[1 << 14, 1 << 16, 1 << 18, 1 << 20, 1 << 22, 1 << 24],
        case: cases::pixels,
    },
    Series {
        name: "triangles",
        order: Order::Logarithmic,
        big: 10_000,
        sizes: &[100, 1_000, 10_000, 100_000, 1_000_000, 10_000_000],
        case: cases::triangles,
    },
    Series {
        name: "photons",
        order: Order::Linear,
        big: 100_000,
        sizes: &[10_000, 100_000, 1_000_000, 10_000_000, 100_000_000],
        case: cases::photons,
    },
];

/// What came of a size.
#[derive(Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    Measured(Times),
    /// By goblet or its device, which said this.
    Refused(String),
    /// Why it was not tried.
    LeftOut(String),
}

#[derive(Serialize)]
pub struct Point {
    pub size: u64,
    /// Seconds to write the scene, before goblet reads it.
    pub generate: f64,
    /// Seconds that all of it took.
    pub total: f64,
    #[serde(flatten)]
    pub outcome: Outcome,
}

#[derive(Serialize)]
pub struct Growth {
    #[serde(flatten)]
    pub series: Series,
    pub points: Vec<Point>,
}

/// Measures the sizes of a series, in ascending order, until `seconds` seconds have passed.
pub fn measure(device: &Arc<Device>, series: Series, seconds: f64) -> Result<Growth> {
    let folder = tempfile::tempdir()?;
    let start = Instant::now();
    let mut growth = Growth { series, points: vec![] };
    for size in series.sizes {
        let left = (seconds - start.elapsed().as_secs_f64()).clamp(0.0, LONGEST);
        let expected = growth.expected_seconds(*size);
        eprintln!("{} {}: {expected:.1} s and more", size, series.name);
        let point = if expected > left {
            let why = format!("one iteration and its setup should take {expected:.1} s, of {left:.1} s left");
            Point { size: *size, generate: 0.0, total: 0.0, outcome: Outcome::LeftOut(why) }
        } else {
            measure_size(device, &series, folder.path(), *size, SHARE * seconds)
        };
        growth.points.push(point);
    }
    Ok(growth)
}

/// Whatever goes wrong is a result, too.
fn measure_size(device: &Arc<Device>, series: &Series, folder: &Path, size: u64, share: f64) -> Point {
    let start = Instant::now();
    let case = (series.case)(folder, size);
    let generate = start.elapsed().as_secs_f64();
    let size = case.as_ref().map_or(size, |case| case.size);
    let outcome = match case.and_then(|case| iterate(device, &case, share)) {
        Ok(times) => Outcome::Measured(times),
        Err(error) => Outcome::Refused(error.to_string()),
    };
    Point { size, generate, total: start.elapsed().as_secs_f64(), outcome }
}

/// Repeats iterations while there is time.
fn iterate(device: &Arc<Device>, case: &Case, seconds: f64) -> Result<Times> {
    let start = Instant::now();
    let mut run = Run::start(device, &case.scene, &case.options)?;
    // The first is the slowest.
    while run.times.iterations.len() < REPEATS && start.elapsed().as_secs_f64() + run.times.warm_up.seconds < seconds {
        run.step()?;
    }
    Ok(run.times)
}

impl Order {
    /// The time at a size, in some unit.
    pub fn at(self, size: u64) -> f64 {
        match self {
            Self::Constant => 1.0,
            Self::Logarithmic => (size as f64).log2(),
            Self::Linear => size as f64,
        }
    }
}

impl Growth {
    /// What was measured, and its times.
    pub fn measured(&self) -> impl Iterator<Item = (&Point, &Times)> {
        self.points.iter().filter_map(|point| match &point.outcome {
            Outcome::Measured(times) => Some((point, times)),
            _ => None,
        })
    }

    /// That of big sizes.
    pub fn big(&self) -> impl Iterator<Item = (&Point, &Times)> {
        self.measured().filter(|(point, _)| point.size >= self.series.big)
    }

    /// Setup and one iteration of a size, from the last that was measured; 0 without any.
    fn expected_seconds(&self, size: u64) -> f64 {
        let Some((last, times)) = self.measured().last() else { return 0.0 };
        let order = self.series.order;
        let before = (last.generate + times.setup.load + times.setup.build) * size as f64 / last.size as f64;
        before + times.setup.compile + times.warm_up.seconds * order.at(size) / order.at(last.size)
    }

    /// Exponents of size that fit the time of big sizes, as measured and as expected; nothing
    /// where a line cannot be drawn.
    pub fn slopes(&self, time: impl Fn(&Times) -> f64) -> Option<[f64; 2]> {
        let measured = self.big().map(|(point, times)| (point.size as f64, time(times)));
        let expected = self.big().map(|(point, _)| (point.size as f64, self.series.order.at(point.size)));
        Some([slope(measured)?, slope(expected)?])
    }
}

/// Of the least squares' line through the logarithms of points.
fn slope(points: impl Iterator<Item = (f64, f64)>) -> Option<f64> {
    let logs: Vec<[f64; 2]> = points.map(|(x, y)| [x.ln(), y.ln()]).collect();
    let count = logs.len() as f64;
    let [x, y] = [0, 1].map(|i| logs.iter().map(|log| log[i]).sum::<f64>() / count);
    let covariance: f64 = logs.iter().map(|log| (log[0] - x) * (log[1] - y)).sum();
    let variance: f64 = logs.iter().map(|log| (log[0] - x).powi(2)).sum();
    Some(covariance / variance).filter(|slope| slope.is_finite())
}
