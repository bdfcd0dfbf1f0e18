//! The error of an image against the time that it took.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use goblet::image::file;
use goblet::image::film::{Image, luminance};
use goblet::scene::Scene;
use goblet::{Options, Renderer};
use goblet_host::Device;
use serde::Serialize;

use super::Result;
use super::measure::median;

const SCENE: &str = "scenes/cornell-caustic.pbrt";
const SIDE: u32 = 512;
/// Seconds at which the error is asked for.
const CHECKPOINTS: [f64; 4] = [1.0, 3.0, 6.0, 12.0];
/// Seconds and errors of pbrt-v4's sppm, for the same scene and image on two cores, June 2026.
pub const PBRT: [(f64, f64); 4] = [(10.0, 0.0123), (30.0, 0.0037), (60.0, 0.0018), (120.0, 0.0010)];

/// What is rendered: the scene's own options, but for these.
fn options(seed: u32) -> Options {
    Options { resolution: Some([SIDE; 2]), seed: Some(seed), ..Options::default() }
}

/// Two images of the scene with independent noise.
pub struct References {
    files: [PathBuf; 2],
    images: [Image; 2],
}

impl References {
    /// Reads them, and checks that they fit.
    pub fn read(files: [PathBuf; 2]) -> std::result::Result<Self, String> {
        let read = |file: &PathBuf| {
            let image = file::read(file).map_err(|error| error.to_string())?;
            let name = file.display();
            if [image.width, image.height] != [SIDE; 2] {
                return Err(format!("{name} is {}x{}; expected {SIDE}x{SIDE}", image.width, image.height));
            }
            let finite = image.pixels.as_flattened().iter().all(|value| value.is_finite());
            if finite { Ok(image) } else { Err(format!("{name} has values that are not finite")) }
        };
        let images = [read(&files[0])?, read(&files[1])?];
        Ok(Self { files, images })
    }

    /// The mean over pixels of (x - a)(x - b) / (m² + 0.01), where m is the mean of a and b: the
    /// references' own noise is in neither factor of the other, and so not in the mean.
    fn error(&self, image: &Image) -> f64 {
        let [a, b] = &self.images;
        let error = |((x, a), b): ((&[f32; 3], &[f32; 3]), &[f32; 3])| {
            let [x, a, b] = [x, a, b].map(|pixel| f64::from(luminance(*pixel)));
            let mean = 0.5 * (a + b);
            (x - a) * (x - b) / (mean * mean + 0.01)
        };
        let errors = image.pixels.iter().zip(&a.pixels).zip(&b.pixels).map(error);
        errors.sum::<f64>() / image.pixels.len() as f64
    }
}

/// The end of an iteration.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Moment {
    pub iterations: u32,
    /// Since the renderer began to be made, without the time to look at the image.
    pub seconds: f64,
    pub error: f64,
}

#[derive(Serialize)]
pub struct Seed {
    pub seed: u32,
    pub moments: Vec<Moment>,
}

#[derive(Serialize)]
pub struct Checkpoint {
    pub at: f64,
    /// The last moments until then of all seeds, each value's median; null if a seed has none.
    pub reached: Option<Moment>,
}

#[derive(Serialize)]
pub struct Measured {
    pub scene: &'static str,
    pub references: [PathBuf; 2],
    pub seeds: Vec<Seed>,
    pub checkpoints: Vec<Checkpoint>,
    pub pbrt: [(f64, f64); 4],
}

/// Renders with each of `seeds` seeds for `seconds` seconds.
pub fn measure(device: &Arc<Device>, references: &References, seeds: u32, seconds: f64) -> Result<Measured> {
    let scene = Scene::load(SCENE)?;
    let mut all = Vec::new();
    for seed in 1..=seeds {
        eprintln!("error at equal time, seed {seed}");
        all.push(Seed { seed, moments: render(device, &scene, references, seed, seconds)? });
    }
    let checkpoints = CHECKPOINTS.into_iter().filter(|at| *at <= seconds);
    let checkpoints = checkpoints.map(|at| Checkpoint { at, reached: reached(&all, at) }).collect();
    Ok(Measured { scene: SCENE, references: references.files.clone(), seeds: all, checkpoints, pbrt: PBRT })
}

fn render(device: &Arc<Device>, scene: &Scene, references: &References, seed: u32, limit: f64) -> Result<Vec<Moment>> {
    let start = Instant::now();
    let mut renderer = Renderer::new(Arc::clone(device), scene, &options(seed))?;
    let mut seconds = start.elapsed().as_secs_f64();
    let mut moments = Vec::new();
    while seconds < limit {
        let start = Instant::now();
        renderer.step()?;
        seconds += start.elapsed().as_secs_f64();
        let error = references.error(&renderer.resolve()?);
        moments.push(Moment { iterations: renderer.iterations(), seconds, error });
    }
    Ok(moments)
}

fn reached(seeds: &[Seed], at: f64) -> Option<Moment> {
    let last = |seed: &Seed| seed.moments.iter().rfind(|moment| moment.seconds <= at).copied();
    let moments: Vec<Moment> = seeds.iter().map(last).collect::<Option<_>>()?;
    let middle = |value: fn(&Moment) -> f64| {
        let mut values: Vec<f64> = moments.iter().map(value).collect();
        values.sort_by(f64::total_cmp);
        median(&values)
    };
    Some(Moment {
        iterations: middle(|moment| moment.iterations.into()) as u32,
        seconds: middle(|moment| moment.seconds),
        error: middle(|moment| moment.error),
    })
}
