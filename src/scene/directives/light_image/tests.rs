use std::fs;

use tempfile::TempDir;

use super::*;
use crate::scene::{Portal, Scene};

/// Returns a folder with a grey image in `image.pfm`; its rows are from bottom to top, as in every PFM.
fn folder(width: u32, height: u32, values: &[f32]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let mut file = format!("Pf {width} {height} -1\n").into_bytes();
    file.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    fs::write(folder.path().join("image.pfm"), file).unwrap();
    folder
}

fn parse(folder: &TempDir, light: &str) -> Result<Scene, SceneError> {
    Scene::parse(&format!("WorldBegin\n{light}\nShape \"sphere\"\n"), "t.pbrt", folder.path())
}

fn light(folder: &TempDir, kind: &str) -> Light {
    let text = format!("LightSource {kind} \"string filename\" \"image.pfm\"");
    parse(folder, &text).unwrap().lights.remove(0)
}

fn assert_refused(folder: &TempDir, text: &str, place: &str, expected: &str) {
    let error = parse(folder, text).unwrap_err().to_string();
    assert!(error.starts_with(place) && error.contains(expected), "{text}:\n{error}");
}

#[test]
fn a_sky_has_the_radiance_of_its_file_with_the_first_row_at_the_top() {
    let folder = folder(2, 2, &[1.0, 2.0, 3.0, -4.0]);
    let Light::Sky { image, radiance, portal: None } = light(&folder, "\"infinite\" \"float scale\" 3") else {
        panic!("not a sky");
    };
    assert_eq!(radiance, Rgb::splat(3.0));
    assert_eq!(image.pixels.pixels, [[3.0; 3], [0.0; 3], [1.0; 3], [2.0; 3]]);
    assert_eq!(image.world_from_image, DMat3::IDENTITY);
}

/// pbrt computes the illuminance with texels of half their solid angle, so that it is twice the parameter.
#[test]
fn the_illuminance_of_a_sky_is_that_of_pbrt() {
    let folder = folder(64, 64, &[0.25; 4096]);
    let Light::Sky { radiance, .. } = light(&folder, "\"infinite\" \"float illuminance\" 7") else {
        panic!("not a sky");
    };
    assert!((0.25 * radiance.x * PI / 14.0 - 1.0).abs() < 1e-3, "{radiance}");
}

#[test]
fn portals_are_rectangles() {
    let folder = folder(2, 2, &[1.0; 4]);
    let square = "\"infinite\" \"point3 portal\" [0 0 0  0 0 2  3 0 2  3 0 0]";
    let Light::Sky { portal: Some(portal), .. } = light(&folder, square) else {
        panic!("not a portal");
    };
    assert_eq!(portal, Portal { corner: DVec3::ZERO, edges: [2.0 * DVec3::Z, 3.0 * DVec3::X] });
    for points in [
        "0 0 0  0 0 2  3 0 2",
        "0 0 0  0 0 2  3 0 2  3 0 0  1 1 1",
        "0 0 0  0 0 2  3 0 0  3 0 2",
        "0 0 0  0 0 0  3 0 2  3 0 0",
        "0 0 0  0 0 0  0 0 0  0 0 0",
        "0 0 0  0 0 2  3 0.1 2  3 0 0",
        "0 0 0  0 0 2  4 0 3  4 0 1",
        "0 0 0  0 0 2  3e200 0 2  3e300 0 0",
    ] {
        let text = format!("WorldBegin\nLightSource \"infinite\" \"point3 portal\" [{points}]\nShape \"sphere\"");
        let error = Scene::parse(&text, "t.pbrt", "").unwrap_err().to_string();
        assert!(
            error.contains("t.pbrt:2:24:") && error.contains("expected the four corners of a rectangle"),
            "{error}"
        );
    }
}

#[test]
fn the_power_of_a_goniometric_light_is_over_all_directions() {
    let folder = folder(2, 2, &[1.0, 2.0, 3.0, 0.0]);
    let turned = "\"goniometric\" \"rgb I\" [1 2 4] \"float scale\" 2 \"float power\" 9";
    let Light::Goniometric { intensity, image, .. } = light(&folder, turned) else {
        panic!("not a goniometric light");
    };
    assert_eq!(intensity, Rgb::new(1.0, 2.0, 4.0) * (2.0 * 9.0 / (4.0 * PI * 1.5)));
    assert_eq!(image.world_from_image.z_axis, DVec3::Y);
}

#[test]
fn the_power_of_a_projector_is_over_its_window() {
    let folder = folder(128, 64, &[0.5; 128 * 64]);
    let Light::Projection { intensity, half_extent, .. } = light(&folder, "\"projection\" \"float power\" 9") else {
        panic!("not a projector");
    };
    assert!(half_extent.distance(DVec2::new(2.0, 1.0)) < 1e-12);
    // The solid angle of a rectangle of 4 x 2 at distance 1.
    let solid_angle = 4.0 * (2.0 / (5.0_f64 * 2.0).sqrt()).asin();
    assert!((0.5 * intensity.x * solid_angle / 9.0 - 1.0).abs() < 1e-3, "{intensity}");
}

#[test]
fn longitudes_and_latitudes_are_resampled_with_a_warning() {
    // The brightness shows the direction of +z, and a bright column that of +y.
    let value = |i: u32| 2.0 - f64::from(i / 256) / 127.0 + if (60..68).contains(&(i % 256)) { 5.0 } else { 0.0 };
    let pixels = (0..256 * 128).map(|i| [value(i) as f32; 3]).collect();
    let square = longitudes::equal_area(&Image { width: 256, height: 128, pixels });
    let at = |w: DVec3| {
        let place = equal_area::place(w.normalize()) * f64::from(square.width - 1);
        square.pixels[(place.y.round() as u32 * square.width + place.x.round() as u32) as usize][0]
    };
    assert!((at(DVec3::new(1.0, 1.0, 9.0)) - 1.96).abs() < 0.02 && at(DVec3::new(1.0, -1.0, -9.0)) < 1.1);
    assert!(at(DVec3::Y) > 6.4 && at(-DVec3::Y) < 1.6 && at(DVec3::X) < 1.6);
    // Energy: the mean over the sphere.
    let mean = |image: &Image| mean(image, |_| 1.0);
    assert!((mean(&square) / (1.5 + 5.0 * 8.0 / 256.0) - 1.0).abs() < 1e-6, "{}", mean(&square));

    let folder = folder(4, 2, &[1.0; 8]);
    let text = "LightSource \"infinite\" \"string filename\" \"image.pfm\"";
    let warnings = parse(&folder, text).unwrap().warnings.join("\n");
    assert!(
        warnings.contains("t.pbrt:2:13: image.pfm is twice as wide as high: it is read as longitude and latitude"),
        "{warnings}"
    );
}

/// Returns the integrals over a sky of its radiance, and of its radiance times the cosine to `normal`. All
/// bright texels must be on the side of `normal`.
fn power_and_irradiance(square: &Image, normal: DVec3) -> (f64, f64) {
    let side = f64::from(square.width);
    let mut sums = (0.0, 0.0);
    for (i, pixel) in square.pixels.iter().enumerate().filter(|(_, pixel)| pixel[1] > 0.0) {
        let (x, y) = (i % square.width as usize, i / square.width as usize);
        let power = f64::from(pixel[1]) * 4.0 * PI / (side * side);
        sums.0 += power;
        sums.1 += power * equal_area::direction((DVec2::new(x as f64, y as f64) + 0.5) / side).dot(normal);
    }
    sums
}

proptest::proptest! {
    /// A sun of one texel keeps its radiance times solid angle, and its direction, wherever it is.
    #[test]
    fn a_sun_of_one_texel_keeps_its_power(half in 1..160u32, row in 0.0..1.0, column in 0.0..1.0, edge in 0..4) {
        let (width, height) = (4 * half - 2 * u32::from(edge == 3), 2 * half - u32::from(edge == 3));
        let place = |at: f64, count: u32| ((at * f64::from(count)) as u32).min(count - 1);
        // Poles are where an earlier version failed.
        let row = [place(row, height), 0, height - 1, height / 2][edge as usize];
        let column = place(column, width);
        let mut image = Image::new(width, height);
        image.pixels[(row * width + column) as usize] = [0.0, 1e4, 0.0];
        let square = longitudes::equal_area(&image);

        let [top, bottom] = [row, row + 1].map(|row| PI * f64::from(row) / f64::from(height));
        let [left, right] = [column, column + 1].map(|column| TAU * f64::from(column) / f64::from(width));
        let power = 1e4 * (right - left) * (top.cos() - bottom.cos());
        // The integral of the direction over the texel.
        let across = 0.5 * ((bottom - top) - 0.5 * ((2.0 * bottom).sin() - (2.0 * top).sin()));
        let up = 0.5 * (bottom.sin().powi(2) - top.sin().powi(2)) * (right - left);
        let flux = 1e4 * DVec3::new((right.sin() - left.sin()) * across, (left.cos() - right.cos()) * across, up);
        let sun = flux.normalize();
        let (sent, facing) = power_and_irradiance(&square, sun);
        proptest::prop_assert!((sent / power - 1.0).abs() < 1e-6, "{sent} {power}");
        // A texel of the square is at most as wide as one on the image's equator.
        let blur = TAU / f64::from(width);
        proptest::prop_assert!((facing / flux.length() - 1.0).abs() < 2.0 * blur * blur + 1e-6, "{facing} {}", flux.length());
        let slanted = (sun + sun.any_orthonormal_vector()).normalize();
        let (_, irradiance) = power_and_irradiance(&square, slanted);
        proptest::prop_assert!((irradiance / flux.dot(slanted) - 1.0).abs() < blur, "{irradiance} {}", flux.dot(slanted));
    }
}

#[test]
fn what_is_no_image_of_a_light_is_refused() {
    let square = folder(2, 2, &[1.0; 4]);
    let file = "\"string filename\" \"image.pfm\"";
    let infinite = format!("LightSource \"infinite\" {file}");
    assert_refused(&square, "LightSource \"projection\"", "t.pbrt:2:13", "expected a \"string filename\"");
    assert_refused(&square, &format!("{infinite} \"rgb L\" [1 1 1]"), "t.pbrt:2:24", "expected one of them");
    assert_refused(&square, &format!("Scale 1 2 1 {infinite}"), "t.pbrt:2:25", "distorts its image");
    let none = "LightSource \"infinite\" \"string filename\" \"none.pfm\"";
    assert_refused(&square, none, "t.pbrt:2:24", "cannot read");
    let text = "LightSource \"infinite\" \"string filename\" \"image.txt\"";
    assert_refused(&square, text, "t.pbrt:2:24", ".pfm");
    let wide = format!("LightSource \"projection\" \"float fov\" 180 {file}");
    assert_refused(&square, &wide, "t.pbrt:2:", "below 180");
    assert_refused(&folder(2, 1, &[1.0; 2]), &infinite.replace("infinite", "goniometric"), "t.pbrt:2:", "square");
    assert_refused(&folder(3, 1, &[1.0; 3]), &infinite, "t.pbrt:2:24", "it has 3x1");
    assert_refused(&folder(1, 1, &[f32::NAN]), &infinite, "t.pbrt:2:24", "without infinities");
    let black = parse(&folder(1, 1, &[0.0]), &infinite).unwrap();
    assert!(black.lights.is_empty() && black.warnings[0].contains("the scene has no light"), "{:?}", black.warnings);
    let bomb = folder(70_000, 1, &[1.0; 70_000]);
    assert_refused(&bomb, &infinite.replace("infinite", "projection"), "t.pbrt:2:", "at most");
}
