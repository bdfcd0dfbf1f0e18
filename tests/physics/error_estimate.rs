//! The estimate of the error against the error: what the renderer says of one render, against
//! the spread of many.

use std::sync::Arc;

use goblet::image::estimate::Estimate;
use goblet::image::film::luminance;
use goblet::scene::Scene;
use goblet::{DirectLight, Integrator, Options, RadiusSchedule, Renderer, Sampler};
use goblet_host::Device;

use crate::support::{self, work};

fn seeds() -> std::ops::Range<u32> {
    1..work(7, 11)
}

/// How far root mean squares over all pixels of a few renders may be apart.
const TOLERANCE: f64 = 0.15;

/// Nothing but the lamp is this bright.
const LAMP: f64 = 2.0;

/// Luminance of each pixel in each render, and each render's estimate of the error.
struct Renders {
    images: Vec<Vec<f64>>,
    errors: Vec<Vec<f64>>,
    relative: Vec<f64>,
}

fn render(device: &Arc<Device>, scene: &Scene, options: &Options, iterations: u32) -> Renders {
    let mut renders = Renders { images: Vec::new(), errors: Vec::new(), relative: Vec::new() };
    for seed in seeds() {
        let options = Options { seed: Some(seed), ..options.clone() };
        let mut renderer = Renderer::new(Arc::clone(device), scene, &options).expect("a renderer");
        for _ in 0..iterations {
            renderer.step().expect("an iteration");
        }
        let estimate: Estimate = renderer.estimate().expect("an estimate");
        renders.images.push(estimate.image().pixels.iter().map(|pixel| f64::from(luminance(*pixel))).collect());
        renders.errors.push(estimate.standard_error().expect("halves").into_iter().map(f64::from).collect());
        renders.relative.push(estimate.relative_error().expect("halves"));
    }
    renders
}

fn mean(values: impl Iterator<Item = f64> + Clone) -> f64 {
    values.clone().sum::<f64>() / values.count() as f64
}

impl Renders {
    /// Mean and variance of a pixel over the renders.
    fn spread(&self, pixel: usize) -> [f64; 2] {
        let mean = mean(self.images.iter().map(|image| image[pixel]));
        let squares = self.images.iter().map(|image| (image[pixel] - mean).powi(2));
        [mean, squares.sum::<f64>() / (self.images.len() - 1) as f64]
    }

    /// The standard error of one render, as the root mean square over pixels: estimated and
    /// true. Without the pixels that see the lamp, of which a few would decide.
    fn standard_errors(&self) -> [f64; 2] {
        let pixels: Vec<usize> = (0..self.images[0].len()).filter(|pixel| self.spread(*pixel)[0] < LAMP).collect();
        let squares = |errors: &Vec<f64>| mean(pixels.iter().map(|pixel| errors[*pixel].powi(2)));
        let estimated = mean(self.errors.iter().map(squares));
        let spread = mean(pixels.iter().map(|pixel| self.spread(*pixel)[1]));
        [estimated.sqrt(), spread.sqrt()]
    }

    /// The relative error of one render: estimated and true.
    fn relative_errors(&self) -> [f64; 2] {
        let spreads: Vec<[f64; 2]> = (0..self.images[0].len()).map(|pixel| self.spread(pixel)).collect();
        let mut lit: Vec<f64> = spreads.iter().map(|[mean, _]| *mean).filter(|mean| *mean > 0.0).collect();
        lit.sort_by(f64::total_cmp);
        let floor = (0.1 * lit[lit.len() / 2]).powi(2);
        let truth = mean(spreads.iter().map(|[mean, variance]| variance / (mean * mean + floor)));
        [mean(self.relative.iter().map(|error| error * error)).sqrt(), truth.sqrt()]
    }
}

#[test]
fn the_estimated_error_is_the_spread_of_renders() {
    let device = support::device();
    let scene = Scene::load(support::root().join("tests/reference/cornell-caustic.pbrt")).expect("a scene");
    let base = Options {
        resolution: Some([32, 32]),
        photons: Some(8192),
        eye_paths: Some(16),
        radius: Some(0.05),
        ..Options::default()
    };
    let pcg = Options { sampler: Sampler::Pcg, ..base.clone() };
    let global = Options { radius_schedule: RadiusSchedule::Global, ..base.clone() };
    let ppm = Options { integrator: Integrator::Ppm, photons_per_round: Some(2 * 8192), ..base.clone() };
    let photons = Options { direct: DirectLight::Photons, ..base.clone() };
    let cases =
        [("sobol", base, 12), ("pcg", pcg, 12), ("global", global, 12), ("ppm", ppm, 24), ("photons", photons, 12)];
    for (name, options, iterations) in cases {
        let renders = render(&device, &scene, &options, iterations);
        for (what, [estimated, truth]) in
            [("standard error", renders.standard_errors()), ("relative error", renders.relative_errors())]
        {
            println!("{name}: {what} {estimated:.5} estimated, {truth:.5} true");
            assert!((estimated / truth - 1.0).abs() < TOLERANCE, "{name}: {what} {estimated}, and it is {truth}");
        }
    }
    support::assert_silent(&device);
}
