//! Light between diffuse surfaces.

use std::f64::consts::PI;

use glam::DVec3;
use goblet::image::compare::compare;
use goblet::image::film::Image;

use super::{EYE_ONLY, Shot, assert_closed, assert_near, assert_uniform, camera};
use crate::support::mean;

const IN_A_SPHERE: Shot =
    Shot { resolution: [16; 2], photons: 16_384, iterations: 32, radius: 0.5, alpha: 1.0, depth: 60, eye_paths: 4 };

#[test]
fn a_glowing_diffuse_sphere_has_radiance_l_over_1_minus_albedo_inside() {
    let inside = camera("0.3 0.2 0.1  1 0.5 2  0 1 0", 90.0);
    for (albedo, radiance) in [([0.5; 3], [1.0; 3]), ([0.8, 0.5, 0.2], [1.0, 2.0, 3.0])] {
        let world = format!(
            "Material \"diffuse\" \"rgb reflectance\" {albedo:?}\nReverseOrientation\n\
             AreaLightSource \"diffuse\" \"rgb L\" {radiance:?}\nShape \"sphere\" \"float radius\" 2"
        )
        .replace(',', " ");
        let rendered = IN_A_SPHERE.take(&inside, &world);
        let expected = [0, 1, 2].map(|c| radiance[c] / (1.0 - albedo[c]));
        assert_uniform("glowing sphere", &rendered.image, expected, 0.5);
        assert_eq!(rendered.tally.escaped, 0);
    }
}

/// After its first bounce, light is uniform in a diffuse sphere: only the direct part varies.
#[test]
fn a_point_light_in_a_diffuse_sphere_adds_a_uniform_share_to_direct_light() {
    const RADIUS: f64 = 2.0;
    const INTENSITY: f64 = 3.0;
    let albedo = [0.8, 0.5, 0.2];
    let world = format!(
        "LightSource \"point\" \"point3 from\" [0 .6 1] \"rgb I\" [{INTENSITY} {INTENSITY} {INTENSITY}]\n\
         Material \"diffuse\" \"rgb reflectance\" [.8 .5 .2]\nShape \"sphere\" \"float radius\" {RADIUS}"
    );
    let rendered = IN_A_SPHERE.take(&camera("0 0 0  0 0 1  0 1 0", 90.0), &world);
    let pixels = IN_A_SPHERE.resolution[0];
    let place = |i: u32| 1.0 - 2.0 * (f64::from(i) + 0.5) / f64::from(pixels);
    let radiance = |i: u32| {
        let wall = RADIUS * DVec3::new(place(i % pixels), place(i / pixels), 1.0).normalize();
        let to_light = DVec3::new(0.0, 0.6, 1.0) - wall;
        let direct = INTENSITY * to_light.dot(-wall) / RADIUS / to_light.length().powi(3);
        albedo.map(|albedo| {
            let indirect = albedo / (1.0 - albedo) * INTENSITY / RADIUS.powi(2);
            (albedo / PI * (direct + indirect)) as f32
        })
    };
    let expected = Image::from_pixels(pixels, pixels, (0..pixels * pixels).map(radiance).collect()).expect("an image");
    assert_near("point light in a sphere", mean(&rendered.image), mean(&expected), 0.005);
    let comparison = compare(&rendered.image, &expected).expect("images of one size");
    assert!(comparison.relmse < 0.002, "{comparison:#?}");
    assert_closed(&rendered.tally, IN_A_SPHERE.photons * 32);
    assert_eq!(rendered.tally.escaped, 0);
}

/// The hash grid of so few visible points has so few cells that most neighbours share one.
#[test]
fn an_image_of_one_pixel_counts_each_photon_once() {
    let world = "LightSource \"point\" \"rgb I\" [1 1 1]\nMaterial \"diffuse\" \"rgb reflectance\" [.5 .5 .5]\n\
                 Shape \"sphere\"";
    for pixels in [1, 2] {
        let shot = Shot { resolution: [pixels; 2], radius: 0.25, ..IN_A_SPHERE };
        let rendered = shot.take(&camera("0 0 0  0 0 1  0 1 0", 20.0), world);
        assert_near(&format!("{pixels} pixels wide"), mean(&rendered.image), [1.0 / PI; 3], 0.03);
    }
}

#[test]
fn a_white_ball_vanishes_in_a_furnace() {
    let world = "LightSource \"infinite\" \"rgb L\" [1 1 1]\nMaterial \"diffuse\" \"rgb reflectance\" [1 1 1]\n\
                 Shape \"sphere\"";
    let rendered = Shot { photons: 1000, ..EYE_ONLY }.take(&camera("0 0 4  0 0 0  0 1 0", 40.0), world);
    assert_uniform("white ball", &rendered.image, [1.0; 3], 0.001);
}

/// Light that bounces many times between the two, so that most of it is photons'.
#[test]
fn a_white_ball_in_a_white_bowl_vanishes_in_a_furnace() {
    let world = "LightSource \"infinite\" \"rgb L\" [1 1 1]\nMaterial \"diffuse\" \"rgb reflectance\" [1 1 1]\n\
                 Shape \"sphere\" \"float zmax\" 0\nShape \"sphere\" \"float radius\" .6";
    let shot = Shot {
        resolution: [32; 2],
        photons: 32768,
        iterations: 48,
        radius: 0.1,
        alpha: 0.667,
        depth: 200,
        eye_paths: 4,
    };
    // The rim, where a disc reaches past the edge, is out of view.
    let rendered = shot.take(&camera("0 0 2.5  0 0 0  0 1 0", 24.0), world);
    assert_uniform("ball in a bowl", &rendered.image, [1.0; 3], 0.5);
    assert_closed(&rendered.tally, 32768 * 48);
}
