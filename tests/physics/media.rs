//! Media that absorb light, against the law of Beer and Lambert.

use std::f64::consts::PI;

use goblet::scene::Scene;
use goblet::{DirectLight, Options};

use super::{EYE_ONLY, Shot, assert_near, assert_pixels, camera, scene_text, solid, square};
use crate::support::{self, Rendered, mean};

/// Absorption coefficients, 1/scene unit.
const A: [f64; 3] = [0.3, 1.0, 2.5];
const B: [f64; 3] = [1.2, 0.1, 0.6];
/// Absorbs in two channels.
const C: [f64; 3] = [0.0, 1.0, 2.0];

const SKY: &str = "LightSource \"infinite\" \"rgb L\" [1 1 1]\n";
const INTERFACE: &str = "Material \"interface\"\n";
const GRAY: &str = "Material \"diffuse\" \"rgb reflectance\" [.4 .4 .4]\n";
/// So dark that light between it and other surfaces does not count.
const DARK: &str = "Material \"diffuse\" \"rgb reflectance\" [.0005 .0005 .0005]\n";
const DOWN: &str = "LightSource \"distant\" \"point3 from\" [0 0 1] \"point3 to\" [0 0 0] \"rgb L\" [2 2 2]\n";

fn medium(name: &str, [r, g, b]: [f64; 3]) -> String {
    format!(
        "MakeNamedMedium \"{name}\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [{r} {g} {b}] \"rgb sigma_s\" [0 0 0]\n"
    )
}

fn media() -> String {
    medium("a", A) + &medium("b", B) + &medium("c", C)
}

/// A shape with media inside and outside.
fn between(inside: &str, outside: &str, shape: &str) -> String {
    format!("AttributeBegin\nMediumInterface \"{inside}\" \"{outside}\"\n{shape}\nAttributeEnd\n")
}

fn slab(low: f64, high: f64) -> String {
    solid([-2.0, -2.0, low], [2.0, 2.0, high])
}

/// What is left after a way through two media.
fn left([way_a, way_b]: [f64; 2]) -> [f64; 3] {
    [0, 1, 2].map(|c| (-A[c] * way_a - B[c] * way_b).exp())
}

/// Looks down along the z axis, from a height.
fn from_above(height: f64, half: f64) -> String {
    format!(
        "LookAt 0 0 {height}  0 0 0  0 1 0\nCamera \"orthographic\" \"float screenwindow\" [-{half} {half} -{half} {half}]"
    )
}

const SPHERE: &str = "Shape \"sphere\" \"float radius\"";

#[test]
fn eye_paths_see_the_sky_through_what_bounds_a_medium() {
    let unit = slab(0.0, 1.0);
    let clear = "Material \"dielectric\" \"float eta\" 1\n";
    let cylinder = "Shape \"revolution\" \"integer degree\" 1 \"point2 P\" [0 0  .8 0  .8 1  0 1]";
    let object = format!(
        "ObjectBegin \"o\"\n{}ObjectEnd\n",
        between("a", "", &format!("{INTERFACE}{}", solid([-0.5; 3], [0.5; 3])))
    );
    let row = |place: &str| {
        let others: String = (1..400)
            .map(|i| {
                format!(
                    "AttributeBegin\nTranslate {} {} 0\nObjectInstance \"o\"\nAttributeEnd\n",
                    2 * (i % 20),
                    2 * (i / 20)
                )
            })
            .collect();
        format!("{object}{others}AttributeBegin\n{place}\nObjectInstance \"o\"\nAttributeEnd\n")
    };
    for (name, world, ways) in [
        ("an interface", between("a", "", &format!("{INTERFACE}{unit}")), [1.0, 0.0]),
        ("a body without refraction", between("a", "", &format!("{clear}{unit}")), [1.0, 0.0]),
        ("a reversed box", between("", "a", &format!("{INTERFACE}ReverseOrientation\n{unit}")), [1.0, 0.0]),
        ("a mirrored box", between("a", "", &format!("{INTERFACE}Scale 1 1 -1\n{unit}")), [1.0, 0.0]),
        ("a mirrored ball", between("", "a", &format!("{INTERFACE}Scale 1 1 -.5\n{SPHERE} 1")), [1.0, 0.0]),
        ("one medium on both sides", between("a", "a", &format!("{INTERFACE}{unit}")), [0.0, 0.0]),
        (
            "boxes in contact",
            between("a", "", &format!("{INTERFACE}{}", slab(0.0, 0.5)))
                + &between("b", "", &format!("{clear}{}", slab(0.5, 1.0))),
            [0.5, 0.5],
        ),
        (
            "a liquid between panes that it touches",
            format!("{clear}{}{}", slab(-0.5, 0.0), slab(0.6, 1.0))
                + &between("a", "", &format!("{clear}{}", slab(0.0, 0.6))),
            [0.6, 0.0],
        ),
        (
            "a ball with a hole",
            between("a", "", &format!("{clear}{SPHERE} 1")) + &between("", "a", &format!("{clear}{SPHERE} .5")),
            [1.0, 0.0],
        ),
        (
            "a liquid in a shell",
            between("b", "", &format!("{clear}{SPHERE} 1")) + &between("a", "b", &format!("{INTERFACE}{SPHERE} .5")),
            [1.0, 1.0],
        ),
        ("a body of revolution", between("a", "", &format!("{INTERFACE}{cylinder}")), [1.0, 0.0]),
        ("a reversed body", between("", "a", &format!("{clear}ReverseOrientation\n{cylinder}")), [1.0, 0.0]),
        ("an instance", row("Scale 1 1 2"), [2.0, 0.0]),
        ("a mirrored instance", row("Scale -1 1 1"), [1.0, 0.0]),
    ] {
        let shot = Shot { resolution: [4; 2], iterations: 1, eye_paths: 4, ..EYE_ONLY };
        let rendered = shot.take(&from_above(5.0, 0.001), &format!("{}{SKY}{world}", media()));
        assert_near(name, mean(&rendered.image), left(ways), 0.0005);
    }
}

/// The reflectance of a slab's faces at normal incidence, and what a slab of this thickness lets pass of light that falls on it:
/// a geometric series.
fn glass_slab(eta: f64, thickness: f64) -> ([f64; 3], [f64; 3]) {
    let r = ((eta - 1.0) / (eta + 1.0)).powi(2);
    let once = A.map(|a| (-a * thickness).exp());
    let passed = once.map(|t| (1.0 - r).powi(2) * t / (1.0 - r * r * t * t));
    let reflected = once.map(|t| r + r * (1.0 - r).powi(2) * t * t / (1.0 - r * r * t * t));
    (passed, reflected)
}

#[test]
fn coloured_glass_passes_what_its_thickness_leaves() {
    let glass = between("a", "", &format!("Material \"dielectric\" \"float eta\" 1.5\n{}", slab(1.0, 1.7)));
    let (passed, reflected) = glass_slab(1.5, 0.7);
    let by_eye = EYE_ONLY.take(&from_above(5.0, 0.1), &format!("{}{SKY}{glass}", media()));
    let expected = [0, 1, 2].map(|c| passed[c] + reflected[c]);
    assert_near("by eye paths", mean(&by_eye.image), expected, 0.003);
    let by_photons = on_the_floor(&format!("{DOWN}{glass}"), 0.5, DirectLight::Nee, DARK);
    let expected = passed.map(|passed| 0.0005 / PI * 2.0 * passed);
    assert_near("by photons", mean(&by_photons.image), expected, 0.003);
}

/// The floor z = 0 under something, seen from a height.
fn on_the_floor(above: &str, height: f64, direct: DirectLight, material: &str) -> Rendered {
    let shot = Shot {
        resolution: [8; 2],
        photons: 131_072,
        iterations: 16,
        radius: 0.1,
        alpha: 1.0,
        depth: 40,
        eye_paths: 16,
    };
    let world = format!("{}{above}{material}{}", media(), square(2.0, 0.0));
    support::render(
        &scene_text(&from_above(height, 0.5), &world),
        &Options { direct, ..shot.options() },
        shot.iterations,
    )
}

#[test]
fn light_that_reaches_a_floor_has_crossed_the_media_above_it() {
    let stack = between("a", "", &format!("{INTERFACE}{}", slab(1.0, 1.4)))
        + &between("b", "", &format!("{INTERFACE}{}", slab(1.4, 2.0)));
    let expected = left([0.4, 0.6]).map(|left| 0.4 / PI * 2.0 * left);
    for direct in [DirectLight::Nee, DirectLight::Photons] {
        let rendered = on_the_floor(&format!("{DOWN}{stack}"), 0.5, direct, GRAY);
        assert_near(&format!("{direct} through interfaces"), mean(&rendered.image), expected, 0.003);
    }
    // Light of a point is seen, and looked for, through the wall of a ball of the medium in which it stands.
    let ball = between("", "a", "LightSource \"point\" \"point3 from\" [0 0 1.5] \"rgb I\" [3 3 3]\n")
        + &between("a", "", &format!("{INTERFACE}Translate 0 0 1.5\n{SPHERE} 1"));
    let vacuum = "LightSource \"point\" \"point3 from\" [0 0 1.5] \"rgb I\" [3 3 3]\n";
    for direct in [DirectLight::Nee, DirectLight::Photons] {
        let [with, without] = [ball.as_str(), vacuum].map(|above| mean(&on_the_floor(above, 0.4, direct, DARK).image));
        let ratio = [0, 1, 2].map(|c| with[c] / without[c]);
        assert_near(&format!("{direct} from a ball"), ratio, left([1.0, 0.0]), 0.003);
    }
}

#[test]
fn rough_surfaces_find_light_through_media() {
    let fog = between("a", "", &format!("{INTERFACE}{}", slab(1.0, 2.0)));
    let metal = "Material \"conductor\" \"float roughness\" .3\n";
    let [with, without] =
        [fog.as_str(), ""].map(|fog| mean(&on_the_floor(&format!("{DOWN}{fog}"), 0.5, DirectLight::Nee, metal).image));
    assert_near("rough metal", [0, 1, 2].map(|c| with[c] / without[c]), left([1.0, 0.0]), 0.003);
}

#[test]
fn a_lamp_in_a_medium_lights_alike_by_photons_and_by_next_event_estimation() {
    let lamp =
        between("", "a", &format!("AreaLightSource \"diffuse\" \"rgb L\" [9 9 9]\nTranslate 0 0 1.5\n{SPHERE} .2"));
    let ball = between("a", "", &format!("{INTERFACE}Translate 0 0 1.5\n{SPHERE} 1"));
    let [nee, photons] = [DirectLight::Nee, DirectLight::Photons]
        .map(|direct| mean(&on_the_floor(&format!("{lamp}{ball}"), 0.4, direct, DARK).image));
    assert_near("by photons", photons, nee, 0.01);
    let bare = mean(&on_the_floor(&lamp.replace("\"a\"", "\"\""), 0.4, DirectLight::Nee, DARK).image);
    // The nearest point of the lamp is 0.8 away from the wall of the ball, and all that shine are less than 1.
    let [most, least] = [0.8, 1.0].map(|way| left([way, 0.0]));
    for c in 0..3 {
        let kept = nee[c] / bare[c];
        assert!(kept < most[c] && kept > least[c], "channel {c}: {kept}, not from {} to {}", least[c], most[c]);
    }
}

/// The camera's medium is the one outside where the camera stands, and stays in force until another
/// `MediumInterface`.
#[test]
fn a_camera_stands_in_a_medium() {
    let shot = Shot { resolution: [8; 2], iterations: 1, eye_paths: 4, ..EYE_ONLY };
    let glow = "MediumInterface \"\" \"\"\nReverseOrientation\nMaterial \"diffuse\" \"rgb reflectance\" [0 0 0]\n\
                AreaLightSource \"diffuse\" \"rgb L\" [1 1 1]\nShape \"sphere\" \"float radius\" 1.5";
    let fog = |outside: &str| format!("{}MediumInterface \"\" \"{outside}\"\n", media());
    let inside = camera("0 0 0  0 0 1  0 1 0", 60.0);
    let rendered = shot.take(&(fog("a") + &inside), glow);
    assert_pixels("in fog", &rendered.image, left([1.5, 0.0]), 0.001);
    // A wall around the camera, whose medium it is in.
    let wall = between("a", "b", &format!("{INTERFACE}{SPHERE} .5"));
    let rendered = shot.take(&(fog("a") + &inside), &format!("{wall}{glow}"));
    assert_pixels("in a ball", &rendered.image, left([0.5, 1.0]), 0.001);
}

/// Infinitely far away, only those channels arrive that a medium does not absorb.
#[test]
fn nothing_comes_through_an_endless_medium() {
    let shot = Shot { resolution: [4; 2], photons: 1024, iterations: 2, eye_paths: 4, ..EYE_ONLY };
    let fog = format!("{}MediumInterface \"\" \"c\"\n", media());
    let floor = format!("{GRAY}{}", square(2.0, 0.0));
    let camera = |look_at: &str| fog.clone() + &camera(look_at, 20.0);
    let up = mean(&shot.take(&camera("0 0 1  0 0 2  0 1 0"), &format!("{SKY}{floor}")).image);
    assert_eq!(up, [1.0, 0.0, 0.0]);
    for (light, expected) in [(SKY, 0.4), (DOWN, 0.4 / PI * 2.0)] {
        let eye = mean(&shot.take(&camera("0 0 .001  0 0 0  0 1 0"), &format!("{light}{floor}")).image);
        println!("{light}: {eye:?}");
        assert!((eye[0] / expected - 1.0).abs() < 0.01 && eye[1..] == [0.0; 2], "{light}: {eye:?}");
    }
}

/// Lengths of any size.
#[test]
fn absorption_does_not_depend_on_the_unit_of_length() {
    let shot = Shot { resolution: [4; 2], iterations: 1, eye_paths: 4, ..EYE_ONLY };
    for unit in [1e-9, 1e-3, 1e6, 1e15] {
        let shot = Shot { radius: 0.1 * unit, ..shot };
        let world = format!(
            "{}{SKY}{}",
            medium("a", A.map(|a| a / unit)),
            between("a", "", &format!("{INTERFACE}Scale {unit} {unit} {unit}\n{}", slab(0.0, 1.0)))
        );
        let half = 0.001 * unit;
        let image = shot.take(&from_above(5.0 * unit, half), &world).image;
        assert_near(&format!("unit {unit:e}"), mean(&image), left([1.0, 0.0]), 0.001);
    }
    for (name, sigma, expected) in
        [("opaque", 1e20, 0.0), ("most", 1e300, 0.0), ("none", 0.0, 1.0), ("least", 1e-300, 1.0)]
    {
        let box_of = between("a", "", &format!("{INTERFACE}{}", slab(0.0, 1.0)));
        let image = shot.take(&from_above(5.0, 0.001), &format!("{}{SKY}{box_of}", medium("a", [sigma; 3]))).image;
        assert_eq!(mean(&image), [expected; 3], "{name}");
    }
}

/// An interface without a medium is not there, and media that nothing is in change nothing.
#[test]
fn media_out_of_use_change_no_bit() {
    let shot =
        Shot { resolution: [8; 2], photons: 4096, iterations: 2, radius: 0.3, alpha: 1.0, depth: 9, eye_paths: 2 };
    let ball = "Material \"dielectric\" \"float eta\" 1.5\nTranslate 0 0 .8\nShape \"sphere\" \"float radius\" .5\n";
    let world = format!("{DOWN}{GRAY}{}{ball}", square(2.0, 0.0));
    let text = |world: &str| scene_text(&camera("0 -2 2  0 0 0  0 0 1", 40.0), world);
    let scene = |world: &str| Scene::parse(&text(world), "t.pbrt", "").expect("a scene");
    assert!(scene(&world).media.is_empty());
    let bits = |world: &str| {
        let image = support::render(&text(world), &shot.options(), 2).image;
        image.pixels.iter().map(|pixel| pixel.map(f32::to_bits)).collect::<Vec<_>>()
    };
    let unused = format!("{}{}{world}", media(), between("", "", &format!("{INTERFACE}{SPHERE} 40")));
    assert!(bits(&world) == bits(&unused));
}
