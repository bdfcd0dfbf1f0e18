//! What must not change a bit: how a render is scheduled, and dispersion where nothing splits light.

use std::sync::Arc;

use goblet::image::file;
use goblet::image::film::Image;
use goblet::render::options::Dispersion;
use goblet::scene::Scene;
use goblet::{Guidance, LookupKind, Options, RadiusSchedule};
use goblet_host::Device;

use crate::support;

/// Bodies of glass on a floor, and what else refracts.
const WORLD: &str = r#"
LookAt .3 1.6 4.5  0 .7 0  0 1 0
Camera "perspective" "float fov" 40
WorldBegin
LightSource "point" "point3 from" [1.2 2.6 .8] "rgb I" [8 7 6]
AttributeBegin
  Translate -.3 2.2 -.6
  AreaLightSource "diffuse" "rgb L" [9 9 9]
  Shape "sphere" "float radius" .3
AttributeEnd
Material "coateddiffuse" "rgb reflectance" [.6 .58 .5] "float roughness" 0
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-3 0 -3  -3 0 3  3 0 3  3 0 -3]
Material "dielectric" "float eta" 1.5
AttributeBegin
  Translate .7 .6 .4
  Shape "sphere" "float radius" .5
AttributeEnd
Material "dielectric" "float eta" 1.5 "float roughness" .2
AttributeBegin
  Translate -.6 .6 .7
  Shape "sphere" "float radius" .5
AttributeEnd
Material "thindielectric" "float eta" 1.5
AttributeBegin
  Translate 0 .8 -1
  Shape "disk" "float radius" .7
AttributeEnd
"#;

/// The world with another index.
fn scene(eta: &str) -> Scene {
    let text = WORLD.replace("\"float eta\" 1.5", eta);
    Scene::parse(&text, "test.pbrt", support::root()).expect("a scene")
}

fn split() -> Scene {
    scene("\"spectrum eta\" \"glass-F11\"")
}

fn options() -> Options {
    Options {
        resolution: Some([32, 24]),
        photons: Some(5003),
        radius: Some(0.1),
        max_depth: Some(8),
        seed: Some(7),
        ..Options::default()
    }
}

fn shoot(device: &Arc<Device>, scene: &Scene, options: &Options) -> Image {
    support::render_scene(device, scene, options, 4).image
}

fn bits(image: &Image) -> Vec<[u32; 3]> {
    image.pixels.iter().map(|pixel| pixel.map(f32::to_bits)).collect()
}

fn differing(image: &Image, expected: &Image) -> usize {
    bits(image).iter().zip(bits(expected)).filter(|(a, b)| **a != *b).count()
}

/// Several things at once, since each render compiles its kernels.
#[test]
fn the_schedule_of_a_render_that_splits_light_does_not_change_a_bit() {
    let device = support::device();
    let unguided = Options { guidance: Guidance::Off, radius_schedule: RadiusSchedule::Data, ..options() };
    let guided = Options { guidance: Guidance::On, ..options() };
    for options in [unguided, guided] {
        let expected = shoot(&device, &split(), &options);
        assert!(support::mean(&expected)[0] > 0.1);
        for other in [
            Options { batch_size: Some(777), workgroup_size: Some(32), cell_scale: Some(0.25), ..options.clone() },
            Options { lookup: LookupKind::KdTree, responsive: true, ..options.clone() },
        ] {
            assert_eq!(differing(&shoot(&device, &split(), &other), &expected), 0, "{other:?}");
        }
    }
}

/// Glass of one index, given by a number or by wavelength, splits nothing. Glass that splits light does so only if asked.
#[test]
fn dispersion_changes_no_bit_where_nothing_splits_light() {
    let device = support::device();
    let off = Options { dispersion: Dispersion::Off, ..options() };
    let plain = shoot(&device, &scene("\"float eta\" 1.5"), &off);
    for eta in ["\"float eta\" 1.5", "\"spectrum eta\" [400 1.5 500 1.5 700 1.5]"] {
        assert_eq!(differing(&shoot(&device, &scene(eta), &options()), &plain), 0, "{eta}");
    }
    let [split, unsplit] = [options(), off].map(|options| shoot(&device, &split(), &options));
    assert!(differing(&split, &unsplit) > split.pixels.len() / 4);
    assert!(unsplit.pixels.iter().flatten().all(|value| *value >= 0.0));
}

/// Colours outside of sRGB have channels below 0. All light comes through glass, from a lamp near the edge of a ball.
#[test]
fn files_keep_negative_channels() {
    let text = WORLD.replace("\"float eta\" 1.5", "\"spectrum eta\" \"glass-F11\"");
    let text = text.replace("[1.2 2.6 .8]", "[.7 1 .4]").replace("[9 9 9]", "[.01 .01 .01]");
    let scene = Scene::parse(&text, "test.pbrt", support::root()).expect("a scene");
    let image = shoot(&support::device(), &scene, &Options { radius: Some(0.02), ..options() });
    let negative = image.pixels.iter().flatten().filter(|value| **value < 0.0).count();
    assert!(negative > 0, "no channel is below 0");
    let file = support::ImageFile::new(&image);
    assert_eq!(differing(&file::read(&file.path()).expect("an image"), &image), 0);
}
