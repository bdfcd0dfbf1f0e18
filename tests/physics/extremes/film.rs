//! Images of any form, any number of photons, and radii of any size.

use std::f64::consts::PI;
use std::sync::Arc;

use goblet::{DirectLight, Options};
use goblet_host::Device;

use super::{SKY, Shot, assert_exact, assert_mean, camera, diffuse, render, square};
use crate::support::{Rendered, device, mean, work};

/// A floor under a sky, whose pixels have no noise.
#[test]
fn images_of_any_form_have_all_their_pixels() {
    let device = device();
    for resolution in [[1, 1], [16_384, 16], [16, 16_384], [1, 3000]] {
        let shot = Shot { resolution, photons: 100, iterations: 1, radius: 0.1, alpha: 1.0, depth: 2, eye_paths: 4 };
        let options = Options { eye_paths: Some(1), ..shot.options() };
        let world = format!("{SKY}{}{}", diffuse(0.5), square(1e4, 0.0));
        let view = "LookAt 0 0 1  0 0 0  0 1 0\nCamera \"perspective\" \"float fov\" 40";
        let image = render(&device, view, &world, &options, shot.iterations).image;
        assert_eq!([image.width, image.height], resolution);
        assert_exact(&format!("{resolution:?}"), &image, 0.5, 1e-5);
    }
}

/// One pixel sees what many see, in the mean.
#[test]
fn an_image_of_one_pixel_is_the_mean_of_a_larger_one() {
    let device = device();
    let world = format!(
        "LightSource \"point\" \"point3 from\" [.5 0 1.5] \"rgb I\" [9 9 9]\n{}{}Shape \"sphere\" \"float radius\" .4",
        diffuse(0.5),
        square(2.0, 0.0)
    );
    let means = [1, 32].map(|side| {
        let shot = Shot {
            resolution: [side; 2],
            photons: 10_000,
            iterations: 512 / side,
            radius: 0.2,
            alpha: 1.0,
            depth: 5,
            eye_paths: 4,
        };
        let eye_paths = if side == 1 { 64 } else { 4 };
        let options = Options { eye_paths: Some(eye_paths), ..shot.options() };
        mean(&render(&device, &camera("0 -3 3  0 0 0  0 0 1", 40.0), &world, &options, shot.iterations).image)[0]
    });
    assert!((means[0] / means[1] - 1.0).abs() < 0.02, "{means:?}");
}

/// All photons of a narrow spot are on the disc of the one pixel's point.
fn spot(device: &Arc<Device>, photons: u64, iterations: u32, radius: f64) -> (Rendered, f64) {
    let (angle, falloff) = (1.0_f64, 0.5_f64);
    let world = format!(
        "LightSource \"spot\" \"point3 from\" [0 0 1] \"point3 to\" [0 0 0] \"rgb I\" [7 7 7] \
         \"float coneangle\" {angle} \"float conedeltaangle\" {falloff}\n{}{}",
        diffuse(0.5),
        square(0.5, 0.0)
    );
    let shot = Shot { resolution: [1, 1], photons, iterations, radius, alpha: 1.0, depth: 1, eye_paths: 4 };
    let options = Options { direct: DirectLight::Photons, eye_paths: Some(1), ..shot.options() };
    let rendered = render(device, &camera("0 0 2  0 0 0  0 1 0", 0.1), &world, &options, iterations);
    assert_eq!(rendered.tally.recorded, photons * u64::from(iterations));
    // The falloff is symmetric in the cosine between the two angles.
    let [inner, outer] = [angle - falloff, angle].map(|angle| 1.0 - angle.to_radians().cos());
    let flux = 7.0 * 2.0 * PI * 0.5 * (inner + outer);
    (rendered, 0.5 / PI * flux / (PI * radius * radius))
}

#[test]
fn any_number_of_photons_an_iteration_is_counted_whole() {
    let device = device();
    for (photons, iterations) in [(1, 40), (3, 40), (work(1_000_000, 100_000_000), 1)] {
        let (rendered, expected) = spot(&device, photons, iterations, 0.1);
        assert_mean(&format!("{photons} photons"), &rendered.image, expected, 2e-4);
    }
}

/// A disc that is larger than the scene finds every photon on its plane.
#[test]
fn radii_larger_than_the_scene_gather_everything() {
    let device = device();
    for radius in [1.0, 100.0, 700.0] {
        let (rendered, expected) = spot(&device, 10_000, 2, radius);
        assert_mean(&format!("radius {radius}"), &rendered.image, expected, 2e-4);
    }
}

/// All photons on a spot that is five times as wide as the discs. Positions are rounded to 6e-8:
/// on discs of 1e-7, single pixels are as bright only as that allows.
#[test]
fn radii_of_a_millionth_gather_what_is_there() {
    let device = device();
    for (radius, tolerance) in [(1e-4, 0.04), (1e-6, 0.06), (1.2e-7, 0.4)] {
        let world = format!(
            "LightSource \"spot\" \"point3 from\" [0 0 .1] \"point3 to\" [0 0 0] \"rgb I\" [7 7 7] \
             \"float coneangle\" {} \"float conedeltaangle\" 0\n{}{}",
            3e3 * radius,
            diffuse(0.5),
            square(0.7, 0.0)
        );
        let view = format!(
            "LookAt 0 0 1  0 0 0  0 1 0\nCamera \"orthographic\" \"float screenwindow\" [-{radius:?} {radius:?} -{radius:?} {radius:?}]"
        );
        let shot =
            Shot { resolution: [4, 4], photons: 300_000, iterations: 1, radius, alpha: 1.0, depth: 1, eye_paths: 4 };
        let options = Options { direct: DirectLight::Photons, eye_paths: Some(1), ..shot.options() };
        let rendered = render(&device, &view, &world, &options, shot.iterations);
        // Of intensity 7 at a distance of 0.1.
        assert_mean(&format!("radius {radius}"), &rendered.image, 0.5 / PI * 700.0, tolerance);
    }
}
