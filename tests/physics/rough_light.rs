//! Light of lamps that no ray meets, by way of smooth glass, on rough surfaces: photons bring it there.

use std::sync::Arc;

use goblet::image::estimate::Estimate;
use goblet::image::layers::{Group, Groups};
use goblet::scene::Scene;
use goblet::{
    ArrayKind, ByPass, DeviceOptions, DirectLight, Integrator, LookupKind, Options, RadiusSchedule, Renderer,
    Submission, open_device,
};
use goblet_host::Device;

use super::{Shot, assert_near, camera, scene_text, square};
use crate::support::{self, Rendered, mean};

const LAMP: &str = "LightSource \"point\" \"rgb I\" [10 8 6]\n";
const METAL: &str = "Material \"conductor\" \"float roughness\" .3\n";

/// A lamp at a place, and a ball of glass around it or elsewhere.
fn lamp_at(at: &str, lamp: &str, ball: &str) -> String {
    format!("AttributeBegin\nTranslate {at}\n{lamp}\n{ball}AttributeEnd\n")
}

/// Glass that does not refract: all light passes, and next-event estimation does not know that.
const BULB: &str = "Material \"dielectric\" \"float eta\" 1\nShape \"sphere\" \"float radius\" .25\n";
const ABOVE: &str = ".5 .4 1.2";
const BELOW: &str = ".1 .8 -1.2";

/// Two specks, with which a scene has the same bounds with and without a bulb: which material of a mix is at a place
/// depends on numbers of render space.
const BOUNDS: &str = "Material \"diffuse\" \"rgb reflectance\" [0 0 0]\nShape \"trianglemesh\" \"integer indices\" [0 1 2 3 4 5] \
                      \"point3 P\" [0 0 2  .01 0 2  0 .01 2  0 0 -2  .01 0 -2  0 .01 -2]\n";

/// The camera sees the middle of a large square, so that no disc reaches over its edge.
fn middle() -> String {
    camera("0 -2.2 2  0 0 0  0 0 1", 25.0)
}

const SHOT: Shot =
    Shot { resolution: [32; 2], photons: 1 << 15, iterations: 8, radius: 0.05, alpha: 1.0, depth: 6, eye_paths: 1 };

/// A rough floor under a bare lamp, and under a lamp in a bulb that does nothing. Photons on the discs of the floor: 2^16
/// of them over a sphere about the lamp are 4000 per unit of area, so that the mean over the image has a noise of some
/// tenths of a percent; the blur of a disc of .05 at a distance of 1.2 changes the mean by (.05 / 1.2)^2 = .2 %.
#[test]
fn a_bulb_that_does_nothing_changes_nothing() {
    let glass = "Material \"dielectric\" \"float roughness\" .3\n";
    let splitting = "Material \"dielectric\" \"float roughness\" .3 \"spectrum eta\" \"glass-F11\"\n";
    let waves = "Texture \"waves\" \"float\" \"wrinkled\"\nTexture \"low\" \"float\" \"scale\" \"texture tex\" \"waves\" \
                 \"float scale\" .1\n";
    let mix = "MakeNamedMaterial \"steel\" \"string type\" \"conductor\" \"float roughness\" .3\n\
               MakeNamedMaterial \"chalk\" \"string type\" \"diffuse\"\n\
               Material \"mix\" \"string materials\" [\"steel\" \"chalk\"] \"float amount\" .4\n";
    let mix_of = |a: &str, b: &str| {
        format!(
            "MakeNamedMaterial \"a\" \"string type\" {a}\nMakeNamedMaterial \"b\" \"string type\" {b}\n\
             Material \"mix\" \"string materials\" [\"a\" \"b\"] \"float amount\" .6\n"
        )
    };
    let mirror = mix_of("\"conductor\" \"float roughness\" 0", "\"coateddiffuse\" \"float roughness\" 0");
    let coated = mix_of("\"coateddiffuse\" \"float roughness\" 0", "\"diffuse\"");
    let bumped = format!("{waves}Material \"conductor\" \"float roughness\" .3 \"texture displacement\" \"low\"\n");
    for (name, material, at) in [
        ("metal", METAL, ABOVE),
        ("brushed metal", "Material \"conductor\" \"float uroughness\" .05 \"float vroughness\" .4\n", ABOVE),
        ("a coat", "Material \"coateddiffuse\" \"float roughness\" .2\n", ABOVE),
        (
            "coated metal",
            "Material \"coatedconductor\" \"float interface.roughness\" .1 \"float conductor.roughness\" .2\n",
            ABOVE,
        ),
        (
            "metal under a smooth coat",
            "Material \"coatedconductor\" \"float interface.roughness\" 0 \"float conductor.roughness\" .3\n",
            ABOVE,
        ),
        ("a mix", mix, ABOVE),
        ("a mix of a mirror and a coat", &mirror, ABOVE),
        ("a mix of a coat and chalk", &coated, ABOVE),
        ("bumps", &bumped, ABOVE),
        ("glass that reflects", glass, ABOVE),
        ("glass that transmits", glass, BELOW),
        ("glass that splits light", splitting, BELOW),
    ] {
        let [bare, behind] = ["", BULB].map(|bulb| {
            let world = lamp_at(at, LAMP, bulb) + material + &square(9.0, 0.0) + BOUNDS;
            let Rendered { image, tally, .. } = SHOT.take(&middle(), &world);
            assert_eq!([tally.non_finite, tally.saturated], [ByPass::default(); 2], "{name}");
            mean(&image)
        });
        assert_near(name, behind, bare, 0.01);
    }
}

/// A spherical lamp of an intensity of 10 W/sr.
fn sphere_lamp(radius: f64, alpha: &str) -> String {
    let radiance = 10.0 / (std::f64::consts::PI * radius * radius);
    format!(
        "AttributeBegin\nMaterial \"diffuse\" \"rgb reflectance\" [0 0 0]\n\
         AreaLightSource \"diffuse\" \"rgb L\" [{radiance} {radiance} {radiance}]\n\
         Shape \"sphere\" \"float radius\" {radius} {alpha}\nAttributeEnd\n"
    )
}

/// The caustic of a glass ball on matt metal. Rays that the metal reflects meet a lamp of radius .2 behind the ball; if
/// the lamp has an alpha of 0 they do not, and photons bring the same light. The visible lamp has a noise of 1 % after
/// so many paths. A point has the light of a lamp that is small. The photons of both differ, of which the ball gets a
/// twenty-fifth: 40,000, whose caustic has a noise of about 1 % with their weights.
#[test]
fn a_lens_lights_metal_as_it_does_if_rays_meet_the_lamp() {
    let ball = "AttributeBegin\nMaterial \"dielectric\" \"float eta\" 1.5\nTranslate 0 0 1\nShape \"sphere\" \
                \"float radius\" .4\nAttributeEnd\nMaterial \"conductor\" \"float roughness\" .6\n";
    let look = camera("0 -.9 .4  0 0 0  0 0 1", 40.0);
    let see = |shot: &Shot, lamp: &str| {
        mean(&shot.take(&look, &(lamp_at("0 0 2", lamp, "") + ball + &square(3.0, 0.0))).image)
    };
    let by_photons = Shot { photons: 1 << 17, iterations: 8, resolution: [16; 2], depth: 8, ..SHOT };
    let by_rays = Shot { photons: 1, iterations: 64, eye_paths: 64, ..by_photons };
    let met = see(&by_rays, &sphere_lamp(0.2, ""));
    assert_near("a lamp of alpha 0", see(&by_photons, &sphere_lamp(0.2, "\"float alpha\" 0")), met, 0.03);
    let small = see(&by_photons, &sphere_lamp(0.01, "\"float alpha\" 0"));
    assert_near("a point", see(&by_photons, "LightSource \"point\" \"rgb I\" [10 10 10]\n"), small, 0.015);
}

/// Metal and a white wall, under a lamp in a bulb.
fn room() -> Scene {
    let wall = "Material \"diffuse\"\nShape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \
                \"point3 P\" [-1 .5 0  1 .5 0  1 .5 1  -1 .5 1]\n";
    let bulb = BULB.replace("\"float eta\" 1", "\"float eta\" 1.5");
    let text = scene_text(&middle(), &(lamp_at(ABOVE, LAMP, &bulb) + METAL + &square(2.0, 0.0) + wall));
    Scene::parse(&text, "test.pbrt", support::root()).expect("a scene")
}

fn few() -> Options {
    Options { resolution: Some([29, 23]), photons: Some(5003), ..Options::default() }
}

fn render(device: &Arc<Device>, scene: &Scene, options: &Options, iterations: u32) -> Renderer {
    let mut renderer = Renderer::new(Arc::clone(device), scene, options).expect("a renderer");
    (0..iterations).for_each(|_| renderer.step().expect("an iteration"));
    renderer
}

fn estimate(device: &Arc<Device>, options: &Options) -> Estimate {
    render(device, &room(), options, 4).estimate().expect("an estimate")
}

/// Arrays in buffers have guard zones, which no pass reads or writes.
#[test]
fn arrays_in_buffers_give_the_same_bits() {
    let options = DeviceOptions { arrays: Some(ArrayKind::Buffers), ..support::device_options() };
    let mut device = open_device(&options).expect("a device");
    device.guard(u32::MAX).expect("guard zones");
    let device = Arc::new(device);
    let options = Options { layers: Groups::of(&Group::ALL), ..few() };
    assert!(estimate(&device, &options) == estimate(&support::device(), &options));
    assert_eq!(device.broken_guards(), Vec::<String>::new());
    support::assert_silent(&device);
}

/// The radii of rough points do not follow the photons that they find, so that no choice of how photons are looked up
/// changes a bit; nor does it where one dispatch cannot gather all photons of a disc.
#[test]
fn how_photons_are_gathered_changes_no_bit() {
    let device = support::device();
    let wide = Options { radius: Some(1.0), photons: Some(1 << 16), resolution: Some([8, 8]), ..few() };
    for options in [
        few(),
        Options { integrator: Integrator::Ppm, photons_per_round: Some(10_006), ..few() },
        Options { radius_schedule: RadiusSchedule::Global, direct: DirectLight::Photons, ..few() },
        Options { layers: Groups::of(&Group::ALL), ..few() },
        wide,
    ] {
        let expected = estimate(&device, &options);
        for (what, other) in [
            ("a tree", Options { lookup: LookupKind::KdTree, ..options.clone() }),
            ("one submission", Options { submission: Submission::Whole, ..options.clone() }),
            ("small batches", Options { batch_size: Some(777), submission: Submission::Pieces, ..options.clone() }),
            ("a workgroup", Options { workgroup_size: Some(128), ..options.clone() }),
        ] {
            assert!(estimate(&device, &other) == expected, "{what}, {options:?}");
        }
    }
    support::assert_silent(&device);
}

#[test]
fn a_render_that_is_resumed_has_the_same_bits() {
    let device = support::device();
    let scene = room();
    let expected = estimate(&device, &few());
    let first = render(&device, &scene, &few(), 2);
    let mut rest = Renderer::new(Arc::clone(&device), &scene, &few()).expect("a renderer");
    rest.resume(&first.checkpoint("").expect("a checkpoint")).expect("the same render");
    (0..2).for_each(|_| rest.step().expect("an iteration"));
    assert!(rest.estimate().expect("an estimate") == expected);
}
