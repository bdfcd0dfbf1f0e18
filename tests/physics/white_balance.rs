//! The white balance of the film: a matrix from the light that a pixel sees to the image.

use glam::{DMat3, DVec3};
use goblet::image::estimate::Estimate;
use goblet::image::film::LUMINANCE;
use goblet::scene::Scene;
use goblet::{Options, Renderer};

use crate::support::{self, command};

/// A glass ball in coloured light, through a film with a parameter.
fn scene(film: &str) -> Scene {
    let text = command::scene("[ 5 5 5 ]", "[ 5 3 2 ]").replace("Film \"rgb\"", &format!("Film \"rgb\" {film}"));
    Scene::parse(&text, "test.pbrt", support::root()).expect("a scene")
}

/// The sums after one iteration, which is of the first half, and after a second one, of the other half.
fn render(scene: &Scene) -> [Estimate; 2] {
    let device = support::device();
    let mut renderer = Renderer::new(device.clone(), scene, &Options::default()).expect("a renderer");
    let estimates = [(); 2].map(|()| {
        renderer.step().expect("an iteration");
        renderer.estimate().expect("an estimate")
    });
    support::assert_silent(&device);
    estimates
}

fn pixels(estimate: &Estimate) -> Vec<DVec3> {
    estimate.image().pixels.into_iter().map(|pixel| DVec3::from(pixel.map(f64::from))).collect()
}

fn luminance(pixel: DVec3) -> f64 {
    pixel.dot(DVec3::from(LUMINANCE))
}

fn matrix(scene: &Scene) -> DMat3 {
    scene.film.white_balance.expect("a white balance").matrix
}

/// The sums are those of the light itself. A pixel is rounded to f32 once without the matrix and once after it.
#[test]
fn the_image_is_the_matrix_times_that_of_the_light() {
    let [_, plain] = render(&scene("\"float iso\" 200"));
    for kelvin in [3000, 5000, 9000] {
        let scene = scene(&format!("\"float iso\" 200 \"float whitebalance\" {kelvin}"));
        let [_, balanced] = render(&scene);
        assert!(balanced.radiance == plain.radiance && balanced.unit == plain.unit, "{kelvin} K");
        let (mut shift, mut brightest) = (0.0_f64, 0.0_f64);
        for (from, to) in pixels(&plain).into_iter().zip(pixels(&balanced)) {
            let expected = matrix(&scene) * from;
            let tolerance = 2e-7 * (5.0 * from.abs().element_sum());
            assert!((to - expected).abs().max_element() <= tolerance, "{kelvin} K: {from} {to}, not {expected}");
            shift = shift.max((to - from).abs().max_element());
            brightest = brightest.max(from.max_element());
        }
        assert!(shift > 0.05 * brightest, "{kelvin} K: the image has hardly changed: {shift}, {brightest}");
    }
}

/// The device sums the luminance of the second half with weights of f32, and the host that of all iterations
/// with weights of f64.
#[test]
fn errors_are_those_of_the_balanced_luminance() {
    let [first, both] = render(&scene("\"float whitebalance\" 3000"));
    assert_eq!((first.halves, both.halves), ([1, 0], [1, 1]));
    let half_luminances = both.half_luminances().expect("both halves");
    let standard_errors = both.standard_error().expect("both halves");
    let mut largest = 0.0_f64;
    for (((one, mean), halves), error) in
        pixels(&first).into_iter().zip(pixels(&both)).zip(half_luminances).zip(standard_errors)
    {
        let expected = [one, 2.0 * mean - one].map(luminance);
        let found = halves.map(|half| half * both.unit);
        let tolerance = 1e-6 * (one + mean).abs().element_sum();
        for (found, expected) in found.into_iter().zip(expected) {
            assert!((found - expected).abs() <= 4.0 * tolerance, "{found}, not {expected}");
        }
        let expected = (expected[0] - expected[1]).abs() / 2.0;
        assert!((f64::from(error) - expected).abs() <= 8.0 * tolerance, "{error}, not {expected}");
        largest = largest.max(expected);
    }
    assert!(largest > 0.0);
}

/// CIE D50 is daylight of a nominal 5000 K. Its colour comes from a table every 10 nm, its white from a formula.
#[test]
fn light_of_the_temperature_is_white() {
    let see = |film: &str| {
        let text = format!(
            "{film} Camera \"orthographic\"\nWorldBegin\nMaterial \"diffuse\" \"rgb reflectance\" [0 0 0]\n\
             AreaLightSource \"diffuse\" \"spectrum L\" \"stdillum-D50\" \"bool twosided\" true\n\
             Translate 0 0 3 Shape \"disk\" \"float radius\" 9"
        );
        let options = Options { resolution: Some([4, 4]), photons: Some(1), radius: Some(0.1), ..Options::default() };
        support::mean(&support::render(&text, &options, 1).image)
    };
    let [red, _, blue] = see("");
    assert!(red > 1.2 * blue, "{red} {blue}");
    let balanced = see("Film \"rgb\" \"float whitebalance\" 5000");
    assert!(balanced.iter().all(|channel| (channel - 1.0).abs() < 0.01), "{balanced:?}");
}
