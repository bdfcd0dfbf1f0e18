//! Lights of any brightness and size.

use std::f64::consts::PI;
use std::sync::Arc;

use goblet::image::film::Image;
use goblet_host::Device;

use super::{Shot, assert_exact, assert_mean, assert_same, block, camera, diffuse, lamp, square};
use crate::support::{device, mean};

/// A glass ball over a floor under a lamp and a point, this many times as bright.
fn lit(device: &Arc<Device>, brightness: f64) -> Image {
    let shot =
        Shot { resolution: [16, 16], photons: 5000, iterations: 3, radius: 0.3, alpha: 1.0, depth: 6, eye_paths: 4 };
    let world = format!(
        "LightSource \"point\" \"point3 from\" [1 0 3] \"rgb I\" [4 3 2] \"float scale\" {brightness:?}\n\
         AttributeBegin\nTranslate -1 0 3\nAreaLightSource \"diffuse\" \"rgb L\" [9 8 7] \"float scale\" {brightness:?}\n\
         Shape \"sphere\" \"float radius\" .3\nAttributeEnd\n{}{}{}",
        diffuse(0.5),
        square(2.0, 0.0),
        block("Material \"dielectric\"\nTranslate 0 0 .7\nShape \"sphere\" \"float radius\" .5")
    );
    shot.take_checked(device, &camera("0 -4 3  0 0 .3  0 0 1", 40.0), &world).image
}

fn brighter(image: &Image, factor: f64) -> Image {
    let pixels = image.pixels.iter().map(|pixel| pixel.map(|value| (f64::from(value) * factor) as f32)).collect();
    Image::from_pixels(image.width, image.height, pixels).expect("an image")
}

/// Light in units of a power of two is the same numbers. Others round otherwise.
#[test]
fn brightness_scales_the_image() {
    let device = device();
    let plain = lit(&device, 1.0);
    assert!(mean(&plain)[0] > 0.01);
    for exponent in [-90, 27, 90] {
        let factor = f64::from(exponent).exp2();
        let image = lit(&device, factor);
        let same = image.pixels.iter().zip(brighter(&plain, factor).pixels).filter(|(a, b)| **a == *b).count();
        assert_eq!(same, plain.pixels.len(), "pixels that are 2^{exponent} times as bright");
    }
    for factor in [1e-6, 1e8] {
        let image = brighter(&lit(&device, factor), 1.0 / factor);
        assert_same(&format!("{factor:e} times as bright"), &image, &plain, 1e-9);
    }
}

const FLOOR: Shot =
    Shot { resolution: [8, 8], photons: 1, iterations: 1, radius: 0.1, alpha: 1.0, depth: 4, eye_paths: 64 };

/// What lights a small part of a floor from 2 above its middle.
fn floor_under(device: &Arc<Device>, light: &str) -> Image {
    let world = format!("{light}{}{}", diffuse(0.5), square(1.0, 0.0));
    FLOOR.take_checked(device, &camera("0 -.5 1  0 0 0  0 0 1", 1.0), &world).image
}

/// A lamp of a hundred-thousandth of the scene's size lights it as a point of its power does.
#[test]
fn small_lamps_are_points() {
    let device = device();
    for size in [1e-2, 1e-5] {
        let tolerance = f64::max(size * size, 1e-3);
        // Radiance of a floor under intensity 1 at height 2.
        let expected = 0.5 / PI / 4.0;
        let disk = lamp(
            1.0 / (PI * size * size),
            &format!("Translate 0 0 2 ReverseOrientation Shape \"disk\" \"float radius\" {size}"),
        );
        assert_mean(&format!("disk of {size}"), &floor_under(&device, &disk), expected, tolerance);
        let ball = lamp(1.0 / (PI * size * size), &format!("Translate 0 0 2 Shape \"sphere\" \"float radius\" {size}"));
        assert_mean(&format!("ball of {size}"), &floor_under(&device, &ball), expected, tolerance);
        let quad = lamp(0.25 / (size * size), &format!("ReverseOrientation {}", square(size, 2.0)));
        assert_mean(&format!("quad of {size}"), &floor_under(&device, &quad), expected, tolerance);
    }
}

/// Photons find their way from such lamps, too: all light of the floor is theirs.
#[test]
fn photons_of_small_lamps_are_all_there() {
    let device = device();
    let shot =
        Shot { resolution: [4, 4], photons: 50_000, iterations: 2, radius: 0.3, alpha: 1.0, depth: 1, eye_paths: 4 };
    let options = goblet::Options { direct: goblet::DirectLight::Photons, ..shot.options() };
    for size in [1e-3, 1e-5] {
        let ball = lamp(1.0 / (PI * size * size), &format!("Translate 0 0 2 Shape \"sphere\" \"float radius\" {size}"));
        let world = format!("{ball}{}{}", diffuse(0.5), square(1.0, 0.0));
        let look = camera("0 0 1  0 0 0  0 1 0", 1.0);
        let rendered = super::render(&device, &look, &world, &options, shot.iterations);
        // The mean over the disc, in which the light falls off as cos^4.
        let disc = 4.0 / 0.09 * 2.0 * (1.0 - 2.0 / (4.0_f64 + 0.09).sqrt());
        assert_mean(&format!("photons of {size}"), &rendered.image, 0.5 / PI / 4.0 * disc, 0.05);
    }
}

/// A lamp a thousand times the size of what it lights is a sky.
#[test]
fn large_lamps_are_skies() {
    let device = device();
    let around = lamp(1.0, "ReverseOrientation Shape \"sphere\" \"float radius\" 1000");
    let image = floor_under(&device, &around);
    assert_exact("ball", &image, 0.5, 0.05);
    assert_mean("ball", &image, 0.5, 0.002);
    let above = lamp(1.0, &format!("ReverseOrientation {}", square(1000.0, 2.0)));
    assert_mean("quad", &floor_under(&device, &above), 0.5, 0.002);
    // Far away and as large: a share of pi that is known.
    let disk = lamp(1.0, "Translate 0 0 1000 ReverseOrientation Shape \"disk\" \"float radius\" 1000");
    assert_mean("disk", &floor_under(&device, &disk), 0.25, 0.005);
}
