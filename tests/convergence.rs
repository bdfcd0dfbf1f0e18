//! The error falls as theory says.

mod support;

use std::rc::Rc;

use goblet::film::Image;
use goblet::scene::Scene;
use goblet::{Options, Renderer};
use goblet_host::Device;

/// Two decades of photons and a bit: iterations 4 to 512.
const CHECKPOINTS: [u32; 8] = [4, 8, 16, 32, 64, 128, 256, 512];

/// With α = 2/3 the squared radius falls as N^(-1/3): the bias follows the squared radius,
/// the variance is one over the photons inside, and the squared error of both falls as
/// N^(-2/3) (Knaus and Zwicker 2011, section 4).
#[test]
fn the_squared_error_of_the_caustic_falls_as_photons_to_the_minus_two_thirds() {
    const THEORY: f64 = -2.0 / 3.0;
    let device = support::device();
    let scene = narrowed(&std::fs::read_to_string(support::root().join("tests/reference/caustic-point.pbrt")).unwrap());
    let base = Options { resolution: Some([64, 50]), ..Options::default() };

    // Discs far smaller than a pixel, which stay so. What two such images have in common is
    // the truth: the mean of (x - a)(x - b) has no share of their noise.
    let sharp = Options { radius: Some(0.012), alpha: Some(1.0), photons: Some(65_536), ..base.clone() };
    let [a, b] = [1, 2].map(|seed| {
        let options = Options { seed: Some(seed), ..sharp.clone() };
        support::render_scene(&device, &scene, &options, 48).image
    });
    let direct = support::render_scene(&device, &scene, &Options { photons: Some(1), ..base.clone() }, 64).image;
    let caustic: Vec<usize> = (0..a.pixels.len())
        .filter(|i| direct.pixels[*i] == [0.0; 3] && a.pixels[*i][0] + b.pixels[*i][0] > 0.2)
        .collect();
    assert!(caustic.len() > 150, "{} pixels", caustic.len());

    let mut errors = [0.0; CHECKPOINTS.len()];
    for seed in 11..14 {
        let options = Options { seed: Some(seed), radius: Some(0.14), photons: Some(2048), ..base.clone() };
        let run = squared_errors(&device, &scene, &options, |x| mean_product(x, &a, &b, &caustic));
        for (sum, error) in errors.iter_mut().zip(run) {
            *sum += error / 3.0;
        }
    }
    let points: Vec<[f64; 2]> =
        CHECKPOINTS.iter().zip(errors).map(|(iterations, error)| [f64::from(*iterations).ln(), error.ln()]).collect();
    let slope = slope(&points);
    println!("slope {slope:.3} over {} pixels, squared errors {errors:.6?}", caustic.len());
    assert!((slope / THEORY - 1.0).abs() < 0.15, "slope {slope}, squared errors {errors:?}");
}

/// The point light in a cone that holds the glass: the caustic is the same, and every
/// photon takes part in it.
fn narrowed(text: &str) -> Scene {
    let cone = "LightSource \"spot\" \"point3 to\" [.1 1.6 .1] \"float coneangle\" 12 \"float conedeltaangle\" .5";
    let narrow = text.replace("LightSource \"point\"", cone);
    assert_ne!(narrow, text);
    Scene::parse(&narrow, "caustic-point.pbrt", support::root()).expect("a scene")
}

/// The error of one progressive render at each checkpoint.
fn squared_errors(device: &Rc<Device>, scene: &Scene, options: &Options, error: impl Fn(&Image) -> f64) -> Vec<f64> {
    let mut renderer = Renderer::new(Rc::clone(device), scene, options).expect("a renderer");
    let at = |iterations: &u32| {
        while renderer.iterations() < *iterations {
            renderer.step().expect("an iteration");
        }
        error(&renderer.resolve().expect("an image"))
    };
    CHECKPOINTS.iter().map(at).collect()
}

/// The mean of (x - a)(x - b) over some pixels and all channels.
fn mean_product(x: &Image, a: &Image, b: &Image, pixels: &[usize]) -> f64 {
    let product = |i: usize, c: usize| {
        let [x, a, b] = [x, a, b].map(|image| f64::from(image.pixels[i][c]));
        (x - a) * (x - b)
    };
    let sum: f64 = pixels.iter().map(|i| (0..3).map(|c| product(*i, c)).sum::<f64>()).sum();
    sum / (3 * pixels.len()) as f64
}

/// Of the line through points, by least squares.
fn slope(points: &[[f64; 2]]) -> f64 {
    let n = points.len() as f64;
    let [x, y] = [0, 1].map(|axis| points.iter().map(|point| point[axis]).sum::<f64>() / n);
    let covariance: f64 = points.iter().map(|point| (point[0] - x) * (point[1] - y)).sum();
    covariance / points.iter().map(|point| (point[0] - x).powi(2)).sum::<f64>()
}
