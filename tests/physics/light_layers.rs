//! The light of an image by its ways: direct, photons, caustics.

use goblet::image::estimate::Estimate;
use goblet::image::layers::{Group, Groups};
use goblet::render::aov::Aov;
use goblet::scene::Scene;
use goblet::{Guidance, Integrator, LookupKind, Options, Renderer, Submission};

use crate::support::{self, command};

fn options() -> Options {
    Options { layers: Groups::of(&Group::ALL), photons: Some(5000), guidance: Guidance::Off, ..Options::default() }
}

fn render(text: &str, options: &Options, iterations: u32) -> Estimate {
    let scene = Scene::parse(text, "test.pbrt", support::root()).expect("a scene");
    let device = support::device();
    let mut renderer = Renderer::new(device.clone(), &scene, options).expect("a renderer");
    (0..iterations).for_each(|_| renderer.step().expect("an iteration"));
    let estimate = renderer.estimate().expect("an estimate");
    support::assert_silent(&device);
    estimate
}

/// The pixels of a layer of light.
fn layer(estimate: &Estimate, name: &str) -> Vec<[f64; 3]> {
    let planes = Aov::named(name).expect("a layer").planes(estimate).expect("its sums");
    (0..planes[0].len()).map(|pixel| [0, 1, 2].map(|channel| f64::from(planes[channel][pixel]))).collect()
}

fn total(pixels: &[[f64; 3]]) -> f64 {
    pixels.iter().flatten().sum()
}

/// The light of direct and photons is the image, to rounding.
fn assert_adds_up(estimate: &Estimate) {
    let (direct, photons) = (layer(estimate, "direct"), layer(estimate, "photons"));
    for ((pixel, direct), photons) in estimate.image().pixels.iter().zip(&direct).zip(&photons) {
        for channel in 0..3 {
            let sum = direct[channel] + photons[channel];
            let size = direct[channel].abs() + photons[channel].abs();
            assert!((f64::from(pixel[channel]) - sum).abs() <= 2e-7 * size, "{pixel:?}: {direct:?} + {photons:?}");
        }
    }
    assert!(total(&direct) > 0.0 && total(&photons) > 0.0);
}

#[test]
fn direct_light_and_that_of_photons_add_up_to_the_image() {
    for film in ["", "\"float iso\" 300 \"float whitebalance\" 4000"] {
        let text = command::scene("Film \"rgb\"", &format!("Film \"rgb\" {film}"));
        let estimate = render(&text, &options(), 6);
        assert_adds_up(&estimate);
        let (photons, caustic) = (layer(&estimate, "photons"), layer(&estimate, "caustic"));
        assert!(total(&caustic) > 0.01 * total(&photons), "{} of {}", total(&caustic), total(&photons));
        if film.is_empty() {
            // After a balance, channels may be negative.
            for ((photons, caustic), pixel) in photons.iter().zip(&caustic).zip(estimate.image().pixels) {
                for channel in 0..3 {
                    let slack = 2e-7 * f64::from(pixel[channel]);
                    assert!((0.0..=photons[channel] + slack).contains(&caustic[channel]), "{caustic:?} {photons:?}");
                }
            }
        }
    }
}

#[test]
fn there_is_no_caustic_without_a_specular_surface() {
    let text = command::scene("Material \"dielectric\"", "Material \"diffuse\"");
    let estimate = render(&text, &options(), 4);
    assert_adds_up(&estimate);
    assert_eq!(total(&layer(&estimate, "caustic")), 0.0);
}

/// A mirror at 45 degrees is the only way to the floor, so that all light of photons is caustic; and the light that a
/// white floor sends on to a wall is none.
#[test]
fn the_light_of_a_mirror_is_a_caustic_until_it_is_scattered() {
    let metal = "Material \"conductor\" \"rgb reflectance\" [.9 .9 .9] \"float roughness\" 0";
    let floor = "Material \"diffuse\" \"rgb reflectance\" [.8 .8 .8]\nShape \"trianglemesh\" \
                 \"integer indices\" [0 1 2 0 2 3] \"point3 P\" [-1 -1 0 1 -1 0 1 1 0 -1 1 0]";
    let mirror = "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \
                  \"point3 P\" [-1 -1 2.2  1 -1 .2  1 1 .2  -1 1 2.2]";
    let lamp = "LightSource \"distant\" \"point3 from\" [-1 0 0] \"point3 to\" [0 0 0] \"rgb L\" [3 3 3]";
    let text = format!(
        "LookAt 0 -1 .6  0 0 0  0 0 1\nCamera \"perspective\" \"float fov\" 20\nWorldBegin\n{lamp}\n{floor}\n{metal}\n{mirror}"
    );
    // A guide would depend on the length of paths.
    let guidance = goblet::Guidance::Off;
    let discs = Options { radius: Some(0.1), alpha: Some(1.0), ..options() };
    let small = Options { resolution: Some([16, 16]), max_depth: Some(2), guidance, ..discs };
    let estimate = render(&text, &small, 4);
    let (photons, caustic) = (layer(&estimate, "photons"), layer(&estimate, "caustic"));
    assert!(total(&caustic) > 0.0);
    for (photons, caustic) in photons.iter().flatten().zip(caustic.iter().flatten()) {
        assert!((photons - caustic).abs() <= 1e-6 * photons, "{photons} {caustic}");
    }
    // With longer paths, light comes back from the mirror and the floor again.
    let longer = Options { max_depth: Some(8), ..small };
    let estimate = render(&text, &longer, 4);
    let [all, of_caustic] = ["photons", "caustic"].map(|name| total(&layer(&estimate, name)));
    assert!((of_caustic / total(&caustic) - 1.0).abs() < 1e-5 && all > 1.05 * of_caustic, "{all} {of_caustic}");
}

/// Layers change no bit of the image, and no choice that leaves the image alone changes a bit of the layers.
#[test]
fn layers_leave_the_image_alone_and_do_not_depend_on_how_it_is_made() {
    for integrator in [Integrator::Sppm, Integrator::Ppm] {
        let options = Options { integrator, ..options() };
        let expected = render(command::SCENE, &options, 5);
        let plain = render(command::SCENE, &Options { layers: Groups::default(), ..options.clone() }, 5);
        assert!(plain.radiance == expected.radiance && plain.second_half == expected.second_half, "{integrator:?}");
        for (what, other) in [
            ("a tree", Options { lookup: LookupKind::KdTree, ..options.clone() }),
            ("one submission", Options { submission: Submission::Whole, ..options.clone() }),
            ("small batches", Options { batch_size: Some(777), submission: Submission::Pieces, ..options.clone() }),
            ("a workgroup", Options { workgroup_size: Some(128), ..options.clone() }),
        ] {
            assert!(render(command::SCENE, &other, 5) == expected, "{what}, {integrator:?}");
        }
        // Each layer has the same sums alone.
        for group in Group::ALL {
            let layers = Groups::of(&[group]);
            let alone = render(command::SCENE, &Options { layers, ..options.clone() }, 5).layers;
            let place = Groups::of(&Group::ALL).place(group).expect("a place");
            assert!(alone.sums[0] == expected.layers.sums[place], "{group:?}, {integrator:?}");
        }
    }
}

/// The radius stays, and a floor gets as many photons as are emitted onto it, which bring all its light.
#[test]
fn radius_and_density_are_those_of_the_discs() {
    let text = "LookAt 0 0 5  0 0 0  0 1 0\nCamera \"orthographic\" \"float screenwindow\" [-1 1 -1 1]\nWorldBegin\n\
                LightSource \"distant\" \"point3 from\" [0 0 1] \"point3 to\" [0 0 0] \"rgb L\" [3 3 3]\n\
                Material \"diffuse\" \"rgb reflectance\" [.8 .8 .8]\nShape \"trianglemesh\" \
                \"integer indices\" [0 1 2 0 2 3] \"point3 P\" [-20 -20 0 20 -20 0 20 20 0 -20 20 0]";
    let options = Options {
        resolution: Some([16, 16]),
        photons: Some(400_000),
        radius: Some(0.5),
        alpha: Some(1.0),
        direct: goblet::DirectLight::Photons,
        layers: Groups::of(&[Group::Light, Group::Square]),
        guidance: Guidance::Off,
        ..Options::default()
    };
    let estimate = render(text, &options, 4);
    let value = |name: &str| {
        let planes = Aov::named(name).expect("a layer").planes(&estimate).expect("its sums");
        planes[0].iter().map(|value| f64::from(*value)).sum::<f64>() / planes[0].len() as f64
    };
    assert!((value("radius") - 0.5).abs() < 1e-5, "{}", value("radius"));
    // The lamp's photons fall evenly onto the floor.
    let expected = 400_000.0 / (40.0 * 40.0);
    assert!((value("density") / expected - 1.0).abs() < 0.02, "{}, not {expected}", value("density"));
    assert_eq!(value("photon-share"), 1.0);
    // Each photon brings the same light, so that there is no noise: a 400,000th of what the lamp sends to the floor,
    // 3 W/m², of which the floor reflects 0.8. The lamp lights the scene's bounding box, which is wider by 1e-5 render
    // units on each side: 1.6e-5 of the floor, so that each photon has 3.2e-5 more. The rest is roundings of floats.
    let radiance = 0.8 / std::f64::consts::PI * 3.0;
    let each = value("light-per-photon");
    assert!((each * expected / radiance - 1.0 - 3.2e-5).abs() < 1e-5, "{each}, not {}", radiance / expected);
}
