//! Sizes, brightnesses, materials and counts at their ends: the image is right, or there is a
//! clear refusal. docs/accuracy.md has the table.

mod bounds;
mod cameras;
mod few_photons;
mod film;
mod geometry;
mod light;
mod optics;
mod paths;
mod refusals;
mod scale;

use std::sync::Arc;

use goblet::image::compare::compare;
use goblet::image::film::Image;
use goblet::scene::Scene;
use goblet::{ByPass, Options};
use goblet_host::Device;

use super::{Shot, assert_near, assert_pixels, camera, scene_text, solid, square};
use crate::support::{self, Rendered, mean};

/// Light that reaches the eye without photons.
const EYE_ONLY: Shot = Shot { resolution: [16; 2], iterations: 1, depth: 1000, ..super::EYE_ONLY };

impl Shot {
    /// Renders on a device that a test uses several times, and checks what no image may have.
    fn take_checked(&self, device: &Arc<Device>, camera: &str, world: &str) -> Rendered {
        render(device, camera, world, &self.options(), self.iterations)
    }
}

/// Renders, and checks what no image may have.
fn render(device: &Arc<Device>, camera: &str, world: &str, options: &Options, iterations: u32) -> Rendered {
    let scene = Scene::parse(&scene_text(camera, world), "test.pbrt", support::root()).expect("a scene");
    let rendered = support::render_scene(device, &scene, options, iterations);
    assert_eq!([rendered.tally.non_finite, rendered.tally.saturated], [ByPass::default(); 2], "{world}");
    let sound = |value: &f32| value.is_finite() && *value >= 0.0;
    assert!(rendered.image.pixels.iter().flatten().all(sound), "{world}");
    rendered
}

/// Directives in a block of their own.
fn block(directives: &str) -> String {
    format!("AttributeBegin\n{directives}\nAttributeEnd\n")
}

/// A shape of this radiance, which reflects nothing.
fn lamp(radiance: f64, shape: &str) -> String {
    block(&format!(
        "AreaLightSource \"diffuse\" \"rgb L\" [{radiance} {radiance} {radiance}]\n\
         Material \"diffuse\" \"rgb reflectance\" [0 0 0]\n{shape}"
    ))
}

fn diffuse(albedo: f64) -> String {
    format!("Material \"diffuse\" \"rgb reflectance\" [{albedo} {albedo} {albedo}]\n")
}

const SKY: &str = "LightSource \"infinite\" \"rgb L\" [1 1 1]\n";

/// The mean over the image is right.
fn assert_mean(what: &str, image: &Image, expected: f64, tolerance: f64) {
    assert_near(what, mean(image), [expected; 3], tolerance);
}

/// Every pixel is right.
fn assert_exact(what: &str, image: &Image, expected: f64, tolerance: f64) {
    assert_pixels(what, image, [expected; 3], tolerance);
}

/// Two images of the same random numbers: equal but for roundings.
fn assert_same(what: &str, image: &Image, expected: &Image, most_relmse: f64) {
    let comparison = compare(image, expected).expect("images of one size");
    println!("{what}: relMSE {:.2e}, energy {:.6}", comparison.relmse, comparison.energy_ratio);
    assert!(comparison.relmse <= most_relmse, "{what}: {comparison:#?}");
    assert!((comparison.energy_ratio - 1.0).abs() < 0.01, "{what}: {comparison:#?}");
}
