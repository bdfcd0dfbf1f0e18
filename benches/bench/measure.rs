//! Renders with a stopwatch.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use goblet::scene::Scene;
use goblet::{Options, Renderer};
use goblet_host::Device;
use serde::Serialize;

use super::Result;

/// Seconds before the first iteration: to read the scene, to build the hierarchy and upload,
/// to compile.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Setup {
    pub load: f64,
    pub build: f64,
    pub compile: f64,
}

/// Seconds of one iteration: of all of it, and of the device by pass.
#[derive(Debug, Serialize)]
pub struct Iteration {
    pub seconds: f64,
    pub passes: BTreeMap<&'static str, f64>,
}

/// All times of a render.
#[derive(Debug, Serialize)]
pub struct Times {
    pub setup: Setup,
    /// The first iteration finds memory that nobody has touched yet, and a schedule that knows
    /// nothing: it counts only where there is no other.
    pub warm_up: Iteration,
    pub iterations: Vec<Iteration>,
}

/// The least, since other work on the machine only ever adds to it, and what is usual.
#[derive(Clone, Copy, Debug)]
pub struct Spread {
    pub least: f64,
    pub median: f64,
}

/// A render and its times.
pub struct Run {
    pub renderer: Renderer,
    pub times: Times,
}

impl Run {
    /// Loads a scene and runs the first iteration.
    pub fn start(device: &Arc<Device>, path: &Path, options: &Options) -> Result<Self> {
        let start = Instant::now();
        let scene = Scene::load(path)?;
        let load = start.elapsed().as_secs_f64();
        let mut renderer = Renderer::new(Arc::clone(device), &scene, options)?;
        let [build, compile] = [renderer.build_time(), renderer.compile_time()].map(|time| time.as_secs_f64());
        let warm_up = step(&mut renderer)?;
        let times = Times { setup: Setup { load, build, compile }, warm_up, iterations: vec![] };
        Ok(Self { renderer, times })
    }

    /// Runs one more.
    pub fn step(&mut self) -> Result<()> {
        self.times.iterations.push(step(&mut self.renderer)?);
        Ok(())
    }
}

fn step(renderer: &mut Renderer) -> Result<Iteration> {
    let before: BTreeMap<_, _> = renderer.device().pass_times().into_iter().collect();
    let start = Instant::now();
    renderer.step()?;
    let seconds = start.elapsed().as_secs_f64();
    let mut passes = BTreeMap::new();
    for (pass, time) in renderer.device().pass_times() {
        let time = time - before.get(pass).copied().unwrap_or_default();
        // The device may have run other passes for other renderers.
        if !time.is_zero() {
            passes.insert(pass, time.as_secs_f64());
        }
    }
    Ok(Iteration { seconds, passes })
}

impl Times {
    /// Whole iterations.
    pub fn whole(&self) -> Spread {
        self.spread(|iteration| iteration.seconds)
    }

    /// One pass of them; 0 where it did not run.
    pub fn pass(&self, pass: &str) -> Spread {
        self.spread(|iteration| iteration.passes.get(pass).copied().unwrap_or(0.0))
    }

    /// Time that is no pass's: the host's work, submission, clearing and copies.
    pub fn rest(&self) -> Spread {
        self.spread(|iteration| iteration.seconds - iteration.passes.values().sum::<f64>())
    }

    /// The time of all iterations that count.
    pub fn spent(&self) -> f64 {
        self.iterations.iter().map(|iteration| iteration.seconds).sum()
    }

    fn spread(&self, time: impl Fn(&Iteration) -> f64) -> Spread {
        let counted = if self.iterations.is_empty() { std::slice::from_ref(&self.warm_up) } else { &self.iterations };
        let mut times: Vec<f64> = counted.iter().map(time).collect();
        times.sort_by(f64::total_cmp);
        Spread { least: times[0], median: median(&times) }
    }
}

/// Of numbers in order; nothing of none.
pub fn median(sorted: &[f64]) -> f64 {
    let [low, high] = [sorted.len().saturating_sub(1) / 2, sorted.len() / 2];
    match (sorted.get(low), sorted.get(high)) {
        (Some(low), Some(high)) => 0.5 * (low + high),
        _ => f64::NAN,
    }
}

/// The passes of renders, the slowest first.
pub fn passes<'a>(all: impl IntoIterator<Item = &'a Times>) -> Vec<&'static str> {
    let mut total: BTreeMap<&'static str, f64> = BTreeMap::new();
    for times in all {
        for pass in times.iterations.iter().chain([&times.warm_up]).flat_map(|iteration| iteration.passes.keys()) {
            total.entry(pass).or_insert(0.0);
        }
        total.iter_mut().for_each(|(pass, total)| *total += times.pass(pass).least);
    }
    let mut passes: Vec<&'static str> = total.keys().copied().collect();
    passes.sort_by(|a, b| total[b].total_cmp(&total[a]));
    passes
}
