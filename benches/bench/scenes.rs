//! Iterations of whole scenes.

use std::path::Path;
use std::sync::Arc;

use goblet::Options;
use goblet_host::Device;
use serde::Serialize;

use super::Result;
use super::measure::{Run, Times};

const SCENES: [&str; 3] = ["scenes/cornell-caustic.pbrt", "scenes/caustic-point.pbrt", "tests/reference/wine-cup.pbrt"];
pub const SIDE: u32 = 512;
pub const PHOTONS: u64 = 262_144;

#[derive(Serialize)]
pub struct Measured {
    pub scene: &'static str,
    pub side: u32,
    pub photons: u64,
    pub times: Times,
}

/// Scenes take turns, so that what else the machine does slows all of them alike, until each
/// has had its time. Each has at least one iteration that counts.
pub fn measure(device: &Arc<Device>, seconds: f64) -> Result<Vec<Measured>> {
    let options = Options { resolution: Some([SIDE; 2]), photons: Some(PHOTONS), ..Options::default() };
    let mut runs = Vec::new();
    for scene in SCENES {
        eprintln!("{scene}");
        runs.push(Run::start(device, Path::new(scene), &options)?);
    }
    loop {
        let mut waiting = runs.iter_mut().filter(|run| run.times.spent() < seconds).peekable();
        if waiting.peek().is_none() {
            break;
        }
        waiting.try_for_each(Run::step)?;
    }
    let measured = |(scene, run): (_, Run)| Measured { scene, side: SIDE, photons: PHOTONS, times: run.times };
    Ok(SCENES.into_iter().zip(runs).map(measured).collect())
}
