//! Renders against closed forms: what light must do, whatever the scene.

mod arrays;
mod auto;
mod bumps;
mod camera;
mod contact;
mod convergence;
mod diffuse;
mod dispersion;
mod error_estimate;
mod extremes;
mod focus;
mod gbuffer;
mod guide;
mod images;
mod invisible;
mod layers;
mod leaks;
mod light_layers;
mod lights;
mod measured;
mod media;
mod metamorphic;
mod noise;
mod portals;
mod reference;
mod revolution;
mod rough_light;
mod scattering_coat;
mod shading;
mod specular;
mod submission;
#[path = "../support/mod.rs"]
mod support;
mod textures;
mod white_balance;

use goblet::image::film::Image;
use goblet::scene::Scene;
use goblet::{ByPass, Guidance, Options, Tally};
use support::{Rendered, mean};

/// How a test renders: with one seed.
#[derive(Clone, Copy)]
struct Shot {
    resolution: [u32; 2],
    photons: u64,
    iterations: u32,
    radius: f64,
    /// 1 keeps the radius: less noise in a mean, where blur does no harm.
    alpha: f64,
    depth: u32,
    /// Per pixel and iteration. An iteration costs more than 64 paths of a small image.
    eye_paths: u32,
}

/// Light that reaches the eye without photons.
const EYE_ONLY: Shot =
    Shot { resolution: [32; 2], photons: 1, iterations: 4, radius: 0.1, alpha: 1.0, depth: 200, eye_paths: 64 };

impl Shot {
    fn options(&self) -> Options {
        Options {
            resolution: Some(self.resolution),
            photons: Some(self.photons),
            radius: Some(self.radius),
            alpha: Some(self.alpha),
            max_depth: Some(self.depth),
            eye_paths: Some(self.eye_paths),
            // Renders are compared with each other, and a guide follows other photons in each.
            guidance: Guidance::Off,
            ..Options::default()
        }
    }

    fn take(&self, camera: &str, world: &str) -> Rendered {
        support::render(&scene_text(camera, world), &self.options(), self.iterations)
    }
}

/// A scene whose pixels are boxes, so that they are means over their squares.
fn scene_text(camera: &str, world: &str) -> String {
    format!("PixelFilter \"box\" \"float xradius\" .5 \"float yradius\" .5\n{camera}\nWorldBegin\n{world}")
}

fn camera(look_at: &str, fov: f64) -> String {
    format!("LookAt {look_at}\nCamera \"perspective\" \"float fov\" {fov}")
}

/// A closed box with normals outward.
fn solid([x0, y0, z0]: [f64; 3], [x1, y1, z1]: [f64; 3]) -> String {
    format!(
        "Shape \"trianglemesh\" \"point3 P\" [{x0} {y0} {z0} {x1} {y0} {z0} {x1} {y1} {z0} {x0} {y1} {z0} \
         {x0} {y0} {z1} {x1} {y0} {z1} {x1} {y1} {z1} {x0} {y1} {z1}] \"integer indices\" \
         [0 2 1 0 3 2 4 5 6 4 6 7 0 1 5 0 5 4 2 3 7 2 7 6 1 2 6 1 6 5 0 4 7 0 7 3]\n"
    )
}

/// A square about the z axis, with its normal up.
fn square(half: f64, z: f64) -> String {
    format!(
        "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \
         \"point3 P\" [-{half} -{half} {z} {half} -{half} {z} {half} {half} {z} -{half} {half} {z}]\n"
    )
}

fn assert_near(what: &str, measured: [f64; 3], expected: [f64; 3], tolerance: f64) {
    println!("{what}: {measured:.5?}, expected {expected:.5?}");
    for (measured, expected) in measured.iter().zip(expected) {
        let error = (measured / expected - 1.0).abs();
        assert!(error <= tolerance, "{what}: {measured} is {error:.5} off {expected}, more than {tolerance}");
    }
}

/// The mean is within 0.5 %, and no pixel is out by more than `noise`.
fn assert_uniform(what: &str, image: &Image, expected: [f64; 3], noise: f64) {
    assert_near(what, mean(image), expected, 0.005);
    assert_pixels(what, image, expected, noise);
}

/// No pixel is off by more than this share of the expected value.
fn assert_pixels(what: &str, image: &Image, expected: [f64; 3], tolerance: f64) {
    for (index, pixel) in image.pixels.iter().enumerate() {
        for (value, expected) in pixel.iter().zip(expected) {
            let error = (f64::from(*value) / expected - 1.0).abs();
            assert!(error <= tolerance, "{what}: pixel {index} is {pixel:?}, expected {expected}");
        }
    }
}

/// Every photon that was asked for was emitted once and ended once.
fn assert_closed(tally: &Tally, emitted: u64) {
    assert_eq!(tally.emitted, emitted, "{tally:?}");
    let photons_lost_in_glass = tally.lost_in_glass - tally.eye_lost_in_glass;
    let ended = tally.deposited + tally.absorbed + tally.escaped + tally.truncated + photons_lost_in_glass;
    assert_eq!(ended, emitted, "{tally:?}");
    assert_eq!([tally.non_finite, tally.saturated], [ByPass::default(); 2], "{tally:?}");
}

#[test]
fn every_photon_is_emitted_once_and_ends_once() {
    let folder = support::root().join("tests/reference");
    let device = support::device();
    let mut sums = [0; 5];
    for name in ["cornell-caustic", "caustic-point", "lights"] {
        let scene = Scene::load(folder.join(format!("{name}.pbrt"))).expect("a scene");
        // Neither count is a multiple of a workgroup or of a batch.
        for (photons, batch_size) in [(5001, None), (5001, Some(777)), (1, None)] {
            let options = Options {
                resolution: Some([16, 16]),
                photons: Some(photons),
                batch_size,
                max_depth: Some(6),
                ..Options::default()
            };
            let rendered = support::render_scene(&device, &scene, &options, 3);
            assert_closed(&rendered.tally, 3 * photons);
            assert_eq!(rendered.tally.lost_in_glass, 0);
            let Tally { recorded, deposited, absorbed, escaped, truncated, .. } = rendered.tally;
            for (sum, count) in sums.iter_mut().zip([recorded, deposited, absorbed, escaped, truncated]) {
                *sum += count;
            }
        }
    }
    for sum in sums {
        assert!(sum > 0, "{sums:?}");
    }
}
