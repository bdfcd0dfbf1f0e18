//! Sizes, brightnesses, materials and counts at their ends: the image is right, or there is a
//! clear refusal. docs/accuracy.md has the table.

mod bounds;
mod camera;
#[path = "../support/command.rs"]
mod command;
mod few_photons;
mod film;
mod geometry;
mod light;
mod optics;
mod paths;
mod refusals;
mod scale;
#[path = "../support/mod.rs"]
mod support;

use std::sync::Arc;

use goblet::image::compare::compare;
use goblet::image::film::Image;
use goblet::scene::Scene;
use goblet::{ByPass, Options};
use goblet_host::Device;
use support::{Rendered, mean};

/// How a test renders.
#[derive(Clone, Copy)]
struct Shot {
    resolution: [u32; 2],
    photons: u64,
    iterations: u32,
    radius: f64,
    depth: u32,
}

/// Light that reaches the eye without photons.
const EYE_ONLY: Shot = Shot { resolution: [16, 16], photons: 1, iterations: 16, radius: 0.1, depth: 1000 };

impl Shot {
    fn options(&self) -> Options {
        Options {
            resolution: Some(self.resolution),
            photons: Some(self.photons),
            radius: Some(self.radius),
            // Radii stay: what is known is known for one radius.
            alpha: Some(1.0),
            max_depth: Some(self.depth),
            ..Options::default()
        }
    }

    fn take(&self, device: &Arc<Device>, camera: &str, world: &str) -> Rendered {
        render(device, camera, world, &self.options(), self.iterations)
    }
}

/// Renders, and checks what no image may have.
fn render(device: &Arc<Device>, camera: &str, world: &str, options: &Options, iterations: u32) -> Rendered {
    let filter = "PixelFilter \"box\" \"float xradius\" .5 \"float yradius\" .5";
    let text = format!("{filter}\n{camera}\nWorldBegin\n{world}");
    let scene = Scene::parse(&text, "test.pbrt", support::root()).expect("a scene");
    let rendered = support::render_scene(device, &scene, options, iterations);
    assert_eq!([rendered.tally.non_finite, rendered.tally.saturated], [ByPass::default(); 2], "{world}");
    let sound = |value: &f32| value.is_finite() && *value >= 0.0;
    assert!(rendered.image.pixels.iter().flatten().all(sound), "{world}");
    rendered
}

fn camera(look_at: &str, fov: f64) -> String {
    format!("LookAt {look_at}\nCamera \"perspective\" \"float fov\" {fov}")
}

/// A square about the z axis, with its normal up.
fn square(half: f64, z: f64) -> String {
    format!(
        "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \
         \"point3 P\" [-{half} -{half} {z} {half} -{half} {z} {half} {half} {z} -{half} {half} {z}]\n"
    )
}

/// A closed box with normals outward.
fn solid([x0, y0, z0]: [f64; 3], [x1, y1, z1]: [f64; 3]) -> String {
    format!(
        "Shape \"trianglemesh\" \"point3 P\" [{x0} {y0} {z0} {x1} {y0} {z0} {x1} {y1} {z0} {x0} {y1} {z0} \
         {x0} {y0} {z1} {x1} {y0} {z1} {x1} {y1} {z1} {x0} {y1} {z1}] \"integer indices\" \
         [0 2 1 0 3 2 4 5 6 4 6 7 0 1 5 0 5 4 2 3 7 2 7 6 1 2 6 1 6 5 0 4 7 0 7 3]\n"
    )
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

/// The mean is right.
fn assert_near(what: &str, image: &Image, expected: f64, tolerance: f64) {
    let measured = mean(image);
    println!("{what}: {measured:.6?}, expected {expected:.6}");
    for value in measured {
        let error = (value / expected - 1.0).abs();
        assert!(error <= tolerance, "{what}: {value} is {error:.2e} off {expected}");
    }
}

/// Every pixel is right.
fn assert_uniform(what: &str, image: &Image, expected: f64, tolerance: f64) {
    for (index, pixel) in image.pixels.iter().enumerate() {
        let error = pixel.map(|value| (f64::from(value) / expected - 1.0).abs());
        assert!(error.iter().all(|error| *error <= tolerance), "{what}: pixel {index} is {pixel:?}, not {expected}");
    }
}

/// Two images of the same random numbers: equal but for roundings.
fn assert_same(what: &str, image: &Image, expected: &Image, most_relmse: f64) {
    let comparison = compare(image, expected).expect("images of one size");
    println!("{what}: relMSE {:.2e}, energy {:.6}", comparison.relmse, comparison.energy_ratio);
    assert!(comparison.relmse <= most_relmse, "{what}: {comparison:#?}");
    assert!((comparison.energy_ratio - 1.0).abs() < 0.01, "{what}: {comparison:#?}");
}
