//! What cameras, films and pixel filters make of emission alone, which has no noise of light.

use std::f64::consts::PI;

use goblet::image::film::Image;
use goblet::{Options, Renderer};

use super::{assert_near, square};
use crate::support::{device, mean, render};

/// A lamp whose radiance is 1, and that reflects nothing.
fn lamp(shape: &str) -> String {
    format!(
        "AttributeBegin\nMaterial \"diffuse\" \"rgb reflectance\" [0 0 0]\n\
         AreaLightSource \"diffuse\" \"rgb L\" [1 1 1] \"bool twosided\" true\n{shape}\nAttributeEnd\n"
    )
}

fn look(options: &str, camera: &str, world: &str, resolution: [u32; 2], iterations: u32) -> Image {
    let eye_paths = if iterations > 1 { Some(64) } else { None };
    let options_of_render =
        Options { resolution: Some(resolution), photons: Some(1), radius: Some(0.1), eye_paths, ..Options::default() };
    let text = format!("{options}\n{camera}\nWorldBegin\n{world}");
    render(&text, &options_of_render, iterations).image
}

#[test]
fn an_orthographic_camera_sees_areas_as_they_are() {
    let world = lamp("Translate 0.3 0.2 9 Shape \"disk\" \"float radius\" 0.7");
    let camera = "Camera \"orthographic\" \"float screenwindow\" [-1 3 -1 1]";
    let share = PI * 0.7 * 0.7 / 8.0;
    let image = look("PixelFilter \"box\"", camera, &world, [64, 32], 4);
    assert_near("disk", mean(&image), [share; 3], 0.005);
    // Its middle is where the window says, x to the right and y up.
    let lit: Vec<[f64; 2]> = (0..64 * 32)
        .filter(|i| image.pixels[*i][0] > 0.5)
        .map(|i| [-1.0 + (0.5 + (i % 64) as f64) / 16.0, 1.0 - (0.5 + (i / 64) as f64) / 16.0])
        .collect();
    let middle = [0, 1].map(|axis| lit.iter().map(|at| at[axis]).sum::<f64>() / lit.len() as f64);
    assert!((middle[0] - 0.3).abs() < 0.02 && (middle[1] - 0.2).abs() < 0.02, "{middle:?}");
}

/// A radius that nobody gave follows the pixels, which are as wide everywhere.
#[test]
fn orthographic_radii_are_those_of_pixels() {
    let text = format!(
        "LookAt 0 0 5  0 0 0  0 1 0\nCamera \"orthographic\"\nWorldBegin\nLightSource \"point\" \"point3 from\" [0 0 1]\n{}",
        square(2.0, 0.0)
    );
    let scene = goblet::scene::Scene::parse(&text, "test.pbrt", "").unwrap();
    let options = Options { resolution: Some([16, 16]), ..Options::default() };
    let mut renderer = Renderer::new(device(), &scene, &options).unwrap();
    renderer.step().unwrap();
    let [least, most] = renderer.radius_range().unwrap();
    assert!((least - 3.0 / 8.0).abs() < 1e-4 && least == most, "{least} {most}");
}

/// A ball takes the same part of the sphere of directions wherever it stands; the mean over
/// an equal-area image is that part.
#[test]
fn a_spherical_camera_sees_solid_angles() {
    let (distance, radius) = (3.0, 1.0_f64);
    let part = 0.5 * (1.0 - (1.0 - (radius / distance).powi(2)).sqrt());
    for (direction, column, row) in [([1.0, 0.0, 0.0], 0, 31), ([0.0, 0.0, 1.0], 32, 31), ([0.0, 1.0, 0.0], 32, 0)] {
        let [x, y, z] = direction.map(|axis: f64| axis * distance);
        let world = lamp(&format!("Translate {x} {y} {z} Shape \"sphere\" \"float radius\" {radius}"));
        let image = look("PixelFilter \"box\"", "Camera \"spherical\"", &world, [64, 64], 4);
        assert_near("equal area", mean(&image), [part; 3], 0.01);

        let camera = "Camera \"spherical\" \"string mapping\" \"equirectangular\"";
        let image = look("Option \"bool disablepixeljitter\" true", camera, &world, [128, 64], 1);
        // x goes around from +x over +z, y from the pole +y down.
        let lit = image.pixels[row * 128 + column][0];
        assert_eq!(lit, 1.0, "{direction:?} at {column}, {row}");
        let rows = |row: usize| (PI * (row as f64 + 0.5) / 64.0).sin() * PI / 64.0 * (2.0 * PI / 128.0);
        let angle: f64 = (0..128 * 64).map(|i| f64::from(image.pixels[i][0]) * rows(i / 128)).sum();
        assert!((angle / (4.0 * PI * part) - 1.0).abs() < 0.03, "{direction:?}: {angle}");
    }
}

const STILL: &str = "Option \"bool disablepixeljitter\" true";

#[test]
fn a_crop_is_a_part_of_the_whole_image() {
    let world = lamp("Rotate 20 1 0.5 0.3 Shape \"disk\" \"float radius\" 0.7 Translate 1.5 .5 .5 Shape \"sphere\"");
    for camera in [
        "LookAt 1 2 5 0 0 0 0 1 0 Camera \"perspective\" \"float fov\" 40",
        "LookAt 1 2 5 0 0 0 0 1 0 Camera \"spherical\"",
    ] {
        let whole = look(STILL, camera, &world, [40, 30], 1);
        let film = format!("{STILL} Film \"rgb\" \"float cropwindow\" [.25 .7 .3 .9]");
        let crop = look(&film, camera, &world, [40, 30], 1);
        assert_eq!([crop.width, crop.height], [18, 18]);
        let differing =
            (0..18 * 18).filter(|i| crop.pixels[*i] != whole.pixels[(i / 18 + 9) * 40 + i % 18 + 10]).count();
        // Roundings may move an edge over a pixel's centre.
        assert!(differing <= 2, "{camera}: {differing}");
        assert!(crop.pixels.iter().any(|pixel| pixel[0] > 0.0), "{camera}");
    }
}

#[test]
fn exposure_scales_the_image() {
    let world = lamp("Translate 0 0 5 Shape \"sphere\"");
    let pixels = |film: &str| look(&format!("{STILL} {film}"), "Camera \"perspective\"", &world, [16, 16], 1).pixels;
    let plain = pixels("");
    assert!(plain.contains(&[1.0; 3]));
    let exposed = pixels("Film \"rgb\" \"float iso\" 250");
    assert!(plain.iter().zip(&exposed).all(|(a, b)| a.map(|v| 2.5 * v) == *b));
}

/// Across an edge between light and dark, a filter with negative lobes undershoots and
/// overshoots; all of it is known.
#[test]
fn filters_with_negative_lobes_make_their_step_response() {
    // The plane z = 1 of a pixel of width 1; light where x < -1/2, on a pixel's centre.
    let half = "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \
                \"point3 P\" [-50 -50 1 -.5 -50 1 -.5 50 1 -50 50 1]";
    let camera = "Camera \"orthographic\" \"float screenwindow\" [-4 4 -1 1]";
    for (filter, radius, kernel) in [
        ("\"mitchell\"", 2.0, mitchell as fn(f64) -> f64),
        ("\"sinc\" \"float xradius\" 3 \"float yradius\" 3", 3.0, lanczos as fn(f64) -> f64),
    ] {
        let image = look(&format!("PixelFilter {filter}"), camera, &lamp(half), [8, 2], 256);
        let integral = |end: f64| {
            let end = end.clamp(-radius, radius);
            let step = (end + radius) / 1e4;
            (0..10_000).map(|i| kernel(-radius + (f64::from(i) + 0.5) * step) * step).sum::<f64>()
        };
        let mut under = false;
        for (i, pixel) in image.pixels.iter().enumerate() {
            let center = -3.5 + (i % 8) as f64;
            let expected = integral(-0.5 - center) / integral(radius);
            under |= expected < -0.01;
            assert!((f64::from(pixel[0]) - expected).abs() < 0.005, "{filter} at {center}: {} {expected}", pixel[0]);
        }
        assert!(under, "{filter}");
    }
}

/// B = C = 1/3, up to a factor.
fn mitchell(x: f64) -> f64 {
    let x = x.abs();
    if x < 1.0 {
        7.0 * x.powi(3) - 12.0 * x * x + 16.0 / 3.0
    } else {
        -7.0 / 3.0 * x.powi(3) + 12.0 * x * x - 20.0 * x + 32.0 / 3.0
    }
}

fn lanczos(x: f64) -> f64 {
    let sinc = |x: f64| if x == 0.0 { 1.0 } else { (PI * x).sin() / (PI * x) };
    sinc(x) * sinc(x / 3.0)
}

/// The visible point's throughput has the sign of its sample: photons bring the same mean
/// through any filter.
#[test]
fn photons_are_filtered_as_direct_light_is() {
    let world = format!(
        "LookAt 0 0 0 0 0 1 0 1 0 LightSource \"point\" \"point3 from\" [0 0 0]\nTranslate 0 0 2\n{}",
        square(4.0, 0.0)
    );
    let image = |filter: &str, direct| {
        let options = Options {
            resolution: Some([4, 4]),
            photons: Some(5_000),
            radius: Some(0.5),
            direct,
            max_depth: Some(1),
            ..Options::default()
        };
        let text = format!("PixelFilter {filter}\nCamera \"perspective\" \"float fov\" 20\nWorldBegin\n{world}");
        mean(&render(&text, &options, 64).image)
    };
    let expected = image("\"box\"", goblet::DirectLight::Nee);
    for direct in [goblet::DirectLight::Nee, goblet::DirectLight::Photons] {
        assert_near("mitchell", image("\"mitchell\"", direct), expected, 0.03);
    }
}
