//! Lights that show an image, on a floor.

use std::f64::consts::PI;

use glam::{DMat3, DVec2, DVec3};
use goblet::geometry::equal_area;
use goblet::image::compare::{Gates, compare};
use goblet::image::film::Image;

use super::lights::assert_lights_floor;
use super::{EYE_ONLY, Shot, camera};
use crate::support::ImageFile;

const SIDE: u32 = 64;

fn image(value: impl Fn(DVec2) -> f64) -> Image {
    let place = |i: u32| DVec2::new(f64::from(i % SIDE) + 0.5, f64::from(i / SIDE) + 0.5) / f64::from(SIDE);
    let pixels = (0..SIDE * SIDE).map(|i| [value(place(i)) as f32; 3]).collect();
    Image::from_pixels(SIDE, SIDE, pixels).expect("an image")
}

fn value(image: &Image, place: DVec2) -> f64 {
    let at = (place * f64::from(SIDE)).as_uvec2().min(glam::UVec2::splat(SIDE - 1));
    image.pixels[(at.y * SIDE + at.x) as usize][0].into()
}

/// Between 0.2 and 1.8, wavy.
fn waves(place: DVec2) -> f64 {
    1.0 + 0.5 * (9.0 * place.x).sin() + 0.3 * (7.0 * place.y).cos()
}

fn turn() -> DMat3 {
    DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 0.0).normalize(), 70_f64.to_radians())
}

fn sky(file: &ImageFile) -> String {
    let path = file.path();
    format!(
        "AttributeBegin\nRotate 70 1 2 0\nLightSource \"infinite\" \"string filename\" \"{}\"\nAttributeEnd\n",
        path.display()
    )
}

/// Irradiance on a floor under a sky that [`turn`] has turned.
fn irradiance(image: &Image) -> f64 {
    const STEPS: u32 = 8 * SIDE;
    let middle = |i: u32| (f64::from(i) + 0.5) / f64::from(STEPS);
    let term = |i: u32| {
        let place = DVec2::new(middle(i % STEPS), middle(i / STEPS));
        value(image, place) * (turn() * equal_area::direction(place)).z.max(0.0)
    };
    (0..STEPS * STEPS).map(term).sum::<f64>() * 4.0 * PI / f64::from(STEPS * STEPS)
}

#[test]
fn a_white_sky_is_constant_infinite_light() {
    let file = ImageFile::new(&image(|_| 2.0));
    assert_lights_floor("white sky", &sky(&file), 0.25, &|_| 2.0 * PI);
}

/// A third of the light is a sun of one texel: neither directions of the bsdf nor photons of a
/// uniform sky would find it.
#[test]
fn a_sky_with_a_tiny_sun_has_its_closed_form_by_eye_and_by_photons() {
    let mut image = image(waves);
    let sun = equal_area::place(turn().transpose() * DVec3::new(0.3, -0.2, 0.9).normalize()) * f64::from(SIDE);
    image.pixels[(sun.y as u32 * SIDE + sun.x as u32) as usize] = [600.0; 3];
    let expected = irradiance(&image);
    let file = ImageFile::new(&image);
    assert_lights_floor("sky", &sky(&file), 0.25, &|_| expected);
    let lamps = format!("{0}{0}LightSource \"infinite\" \"rgb L\" [2 2 2]\n", sky(&file));
    assert_lights_floor("two skies and a constant one", &lamps, 0.25, &|_| 2.0 * expected + 2.0 * PI);
}

/// Rough spheres of metal and of glass look alike under both lights.
fn assert_alike_on_rough(a: &str, b: &str, max_relmse: f64) {
    let shot = Shot { iterations: 3, ..EYE_ONLY };
    let take = |light: &str| {
        let spheres = "Material \"conductor\" \"float roughness\" .4\nShape \"sphere\"\n\
                       Material \"dielectric\" \"float roughness\" .3\nTranslate 2 0 0\nShape \"sphere\"";
        shot.take(&camera("1 -6 1  1 0 0  0 0 1", 40.0), &format!("{light}{spheres}")).image
    };
    let comparison = compare(&take(a), &take(b)).expect("images of one size");
    println!("{:.4}, relMSE {:.5}", comparison.energy_ratio, comparison.relmse);
    let gates = Gates { max_relmse: Some(max_relmse), max_energy: Some(0.005) };
    assert!(comparison.failures(&gates).is_empty(), "{comparison:#?}");
}

#[test]
fn rough_surfaces_weigh_a_sky_by_both_techniques() {
    let file = ImageFile::new(&image(|_| 2.0));
    let constant = "LightSource \"infinite\" \"rgb L\" [2 2 2]\n";
    assert_alike_on_rough(&sky(&file), constant, 0.001);

    let towards = DVec3::new(-0.3, -0.8, 0.5).normalize();
    let texel = (equal_area::place(turn().transpose() * towards) * f64::from(SIDE)).as_uvec2();
    let mut image = image(|_| 0.0);
    image.pixels[(texel.y * SIDE + texel.x) as usize] = [1000.0; 3];
    let irradiance = 1000.0 * 4.0 * PI / f64::from(SIDE * SIDE);
    let w = turn() * equal_area::direction((texel.as_dvec2() + 0.5) / f64::from(SIDE));
    let sun = format!(
        "LightSource \"distant\" \"rgb L\" [{irradiance} {irradiance} {irradiance}] \
         \"point3 from\" [{} {} {}] \"point3 to\" [0 0 0]\n",
        w.x, w.y, w.z
    );
    assert_alike_on_rough(&sky(&ImageFile::new(&image)), &sun, 0.001);
}

const LAMP: DVec3 = DVec3::new(0.3, 0.2, 1.2);

fn lamp(kind: &str, degrees: i32, file: &ImageFile) -> String {
    let path = file.path();
    format!(
        "AttributeBegin\nTranslate .3 .2 1.2\nRotate {degrees} 1 0 0\n\
         LightSource {kind} \"string filename\" \"{}\"\nAttributeEnd\n",
        path.display()
    )
}

fn from_lamp(p: DVec3, intensity: impl Fn(DVec3) -> f64) -> f64 {
    let d = p - LAMP;
    intensity(d.normalize()) * -d.z / d.length().powi(3)
}

#[test]
fn a_goniometric_light_has_its_closed_form_by_eye_and_by_photons() {
    let image = image(waves);
    let file = ImageFile::new(&image);
    let text = lamp("\"goniometric\" \"rgb I\" [4 4 4]", -90, &file);
    // The light's axes y and z are the world's -z and y; the map's pole is y.
    let image = &image;
    let intensity = move |w: DVec3| 4.0 * value(image, equal_area::place(DVec3::new(w.x, w.y, -w.z)));
    assert_lights_floor("goniometric", &text, 0.06, &|p| from_lamp(p, intensity));
}

#[test]
fn a_projector_has_its_closed_form_by_eye_and_by_photons() {
    let image = image(waves);
    let file = ImageFile::new(&image);
    let text = lamp("\"projection\" \"float scale\" 4 \"float fov\" 130", 180, &file);
    // The light's axes y and z are the world's -y and -z. The image's top is at +y.
    let half = 65_f64.to_radians().tan();
    let image = &image;
    let intensity = move |w: DVec3| 4.0 * value(image, 0.5 + 0.5 * DVec2::new(w.x, w.y) / -w.z / half);
    assert_lights_floor("projection", &text, 0.06, &|p| from_lamp(p, intensity));
}

/// Whatever its row, by longitude and latitude: what it sends to a floor is its radiance times
/// its solid angle times the cosine.
#[test]
fn a_sun_of_one_texel_has_its_power() {
    let (width, height) = (64, 32);
    for (row, column) in [(0, 0), (0, 37), (1, 16), (7, 63), (11, 5)] {
        let mut pixels = vec![[0.0; 3]; width * height];
        pixels[row * width + column] = [500.0; 3];
        let file = ImageFile::new(&Image::from_pixels(width as u32, height as u32, pixels).expect("an image"));
        let light = format!("LightSource \"infinite\" \"string filename\" \"{}\"\n", file.path().display());
        let [top, bottom] = [row, row + 1].map(|row| (PI * row as f64 / height as f64).sin());
        let irradiance = 500.0 * 2.0 * PI / width as f64 * 0.5 * (bottom * bottom - top * top);
        assert_lights_floor(&format!("sun in row {row}"), &light, 0.25, &|_| irradiance);
    }
}
