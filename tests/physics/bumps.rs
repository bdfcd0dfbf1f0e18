//! Bumps: displacements and normal maps, which bend shading normals.

use goblet::image::compare::compare;
use goblet::image::film::Image;
use goblet::{DirectLight, Guidance, Options};

use super::shading::{Floor, floor_by_eye_paths, floor_by_photons};
use super::{EYE_ONLY, assert_uniform, camera, scene_text, solid, square};
use crate::support::{self, mean, work};

/// Waves of about `length`, whose slopes are up to about `steepness`.
fn waves(length: f64, steepness: f64) -> String {
    format!(
        "AttributeBegin\nScale {length} {length} {length}\nTexture \"noise\" \"float\" \"fbm\" \"integer octaves\" 2\n\
         AttributeEnd\nTexture \"waves\" \"float\" \"scale\" \"texture tex\" \"noise\" \"float scale\" {}\n",
        0.5 * length * steepness
    )
}

const BUMPED: &str = "\"texture displacement\" \"waves\"\n";
const FURNACE: &str = "LightSource \"infinite\" \"rgb L\" [1 1 1]\n";

/// A lamp of two triangles that shines to the right of the direction from one corner to the next.
fn lamp(corners: &str) -> String {
    format!(
        "AttributeBegin\nAreaLightSource \"diffuse\" \"rgb L\" [5 5 5]\nMaterial \"diffuse\" \"rgb reflectance\" [0 0 0]\n\
         Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point3 P\" [{corners}]\nAttributeEnd\n"
    )
}

/// The light of a large lamp through a pane of waves, on a floor: by eye paths that look up from there, and by
/// photons. From a lamp near the horizon, much of the light meets normals that face away from it, and is reflected
/// below the surface.
#[test]
fn a_bumped_pane_passes_as_much_light_either_way() {
    let above = lamp("-2 -2 3  -2 2 3  2 2 3  2 -2 3");
    let grazing = lamp("6 2 1.2  6 -2 1.2  6 -2 3  6 2 3");
    let dielectric = format!("{}Material \"dielectric\" \"float eta\" 1.33 {BUMPED}", waves(0.4, 0.5));
    let water = format!("{dielectric}Shape \"disk\" \"float radius\" 5.5 \"float height\" 1\n");
    let slab = format!("{dielectric}{}", solid([-3.0, -3.0, 0.9], [3.0, 3.0, 1.1]));
    let wide_slab = format!(
        "{}Material \"dielectric\" \"float eta\" 1.33 {BUMPED}{}",
        waves(0.4, 0.3),
        solid([-5.5, -5.5, 1.0], [5.5, 5.5, 1.02])
    );
    let rough = format!(
        "{}Material \"dielectric\" \"float roughness\" .1 \"bool remaproughness\" false {BUMPED}\
         Shape \"disk\" \"float radius\" 5.5 \"float height\" 1\n",
        waves(0.4, 0.3)
    );
    // The floor's normal is between those of the pane and of the wall that is the lamp: all light comes within 65° of it.
    let tilted = |world: &str| format!("AttributeBegin\nRotate -45 0 1 0\n{world}AttributeEnd\n");
    let cases = [
        ("slab", format!("{above}{slab}"), 1.0, 65.0, 2),
        ("water at grazing angles", tilted(&format!("{grazing}{water}")), 0.5, 65.0, 6),
        ("water", format!("{above}{water}"), 1.0, 65.0, 2),
        ("rough", format!("{above}{rough}"), 1.0, 65.0, 2),
        ("slab at grazing angles", tilted(&format!("{grazing}{wide_slab}")), 0.5, 75.0, 6),
    ];
    for (what, world, radius, angle, iterations) in cases.into_iter().take(work(2, 5)) {
        let floor = Floor { radius, angle };
        let expected = floor_by_eye_paths(floor, &world, work(iterations, 4 * iterations));
        let measured = floor_by_photons(floor, &world, work(iterations / 2, 2 * iterations));
        println!("{what}: {expected:.6} by eye paths, {measured:.6} by photons, {:.4}", measured / expected);
        assert!((measured / expected - 1.0).abs() < 0.01, "{what}: {expected} {measured}");
    }
}

/// Diffuse bumps are lit straight from a light: by eye paths, and by photons, also where it shines at a grazing angle and
/// where they are seen at one. Most photons fall into the image.
#[test]
fn bumped_floors_are_lit_alike_by_eye_paths_and_photons() {
    let spot = |from: &str, angle: f64| {
        format!(
            "LightSource \"spot\" \"point3 from\" [{from}] \"point3 to\" [0 0 0] \"float coneangle\" {angle} \"rgb I\" [9 9 9]\n"
        )
    };
    let lights = [spot("2 -1 3", 12.0), spot("5 0 1", 5.0)];
    let views = ["0 -4 3  0 0 0  0 0 1", "0 -4 .8  0 0 0  0 0 1"];
    for (light, view) in lights.iter().flat_map(|light| views.map(|view| (light, view))) {
        let world = format!("{light}{}Material \"diffuse\" {BUMPED}{}", waves(2.0, 0.8), square(8.0, 0.0));
        let by = |direct: DirectLight| {
            let options = Options {
                resolution: Some([256; 2]),
                photons: Some(200_000),
                radius: Some(0.02),
                alpha: Some(1.0),
                max_depth: Some(1),
                direct,
                ..Options::default()
            };
            mean(&support::render(&scene_text(&camera(view, 30.0), &world), &options, work(4, 24)).image)[0]
        };
        let [eye, photons] = [DirectLight::Nee, DirectLight::Photons].map(by);
        println!("seen from {view}: {eye:.5} by eye paths, {photons:.5} by photons, {:.4}", photons / eye);
        assert!((photons / eye - 1.0).abs() < 0.01, "{view}: {eye} {photons}");
    }
}

/// Whatever normals do, what they refract and reflect is all that there is.
#[test]
fn bumped_glass_vanishes_in_a_furnace() {
    for (steepness, view) in
        [(0.5, "0 -6 4  0 0 0  0 0 1"), (0.5, "0 -6 .4  0 0 0  0 0 1"), (2.0, "0 -6 .4  0 0 0  0 0 1")]
    {
        let world = format!(
            "{FURNACE}{}Material \"dielectric\" {BUMPED}{}",
            waves(0.4, steepness),
            solid([-1.0, -1.0, -0.2], [1.0, 1.0, 0.2])
        );
        let rendered = super::Shot { resolution: [64, 32], iterations: 1, depth: 1000, ..EYE_ONLY }
            .take(&camera(view, 20.0), &world);
        assert_uniform(&format!("steepness {steepness} from {view}"), &rendered.image, [1.0; 3], 0.01);
        assert_eq!(rendered.tally.lost_in_glass, 0);
    }
}

/// Nothing that is bumped is brighter than what lights it, seen from above or at a grazing angle.
#[test]
fn nothing_that_is_bumped_outshines_a_furnace() {
    for material in [
        "\"dielectric\" \"float eta\" 1.33",
        "\"thindielectric\"",
        "\"diffuse\" \"rgb reflectance\" [1 1 1]",
        "\"diffusetransmission\" \"rgb reflectance\" [.5 .5 .5] \"rgb transmittance\" [.5 .5 .5]",
        "\"conductor\" \"rgb reflectance\" [1 1 1] \"float roughness\" 0",
        "\"coateddiffuse\" \"rgb reflectance\" [1 1 1] \"float roughness\" 0",
    ] {
        for view in ["0 -6 4  0 0 0  0 0 1", "0 -6 .4  0 0 0  0 0 1"] {
            let world = format!("{FURNACE}{}Material {material} {BUMPED}{}", waves(0.4, 1.0), square(3.0, 0.0));
            let rendered = super::Shot { iterations: 4, ..EYE_ONLY }.take(&camera(view, 12.0), &world);
            let brightest = rendered.image.pixels.iter().flatten().fold(0.0_f32, |most, value| most.max(*value));
            println!("{material} from {view}: mean {:.4}, up to {brightest:.4}", mean(&rendered.image)[0]);
            assert!(mean(&rendered.image)[0] <= 1.001, "{material} from {view}");
            // A coat's lobes are chosen at random: 256 paths have a noise of some percent.
            let noise = if material.contains("coat") { 0.1 } else { 0.002 };
            assert!(brightest <= 1.0 + noise, "{material} from {view}: {brightest}");
        }
    }
}

/// A view, a lamp and a floor, and a shape of a bumped or an even material, all `scale` times as large, by paths of up to
/// `depth` segments.
fn stage(scale: f64, depth: u32, material: &str, shape: &str) -> Image {
    let [x, y, z] = [0.5, -4.0, 2.5].map(|x| scale * x);
    let world = format!(
        "Scale {scale} {scale} {scale}\n{}Material \"diffuse\"\n{}{material}{shape}",
        lamp("-1 -1 3  -1 1 3  1 1 3  1 -1 3"),
        square(2.0, 0.0)
    );
    let options = Options {
        resolution: Some([48; 2]),
        photons: Some(20_000),
        radius: Some(0.1 * scale),
        max_depth: Some(depth),
        seed: Some(3),
        // The pilots of two scenes would begin other photons in each.
        guidance: Guidance::Off,
        ..Options::default()
    };
    let look = camera(&format!("{x} {y} {z}  0 0 {}  0 0 1", 0.5 * scale), 30.0);
    support::render(&scene_text(&look, &world), &options, 8).image
}

/// A ramp of height bends all normals alike, as normals at the corners do.
#[test]
fn a_ramp_is_shaded_as_a_tilted_plane() {
    let plane = "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point2 uv\" [0 0 1 0 1 1 0 1] \
                 \"point3 P\" [-.8 -.8 .5  .8 -.8 .5  .8 .8 .5  -.8 .8 .5]";
    // Rises by .8 over a length of 1.6 along x, and by .4 along y.
    let ramp =
        "Texture \"ramp\" \"float\" \"bilerp\" \"float v00\" 0 \"float v10\" .8 \"float v01\" .4 \"float v11\" 1.2\n";
    let tilted = format!("{plane} \"normal N\" [-.5 -.25 1 -.5 -.25 1 -.5 -.25 1 -.5 -.25 1]\n");
    // Photons that a diffuse surface sends below itself are left out where normals at corners disagree with it.
    for (material, depth) in [
        ("\"diffuse\"", 1),
        ("\"conductor\"", 6),
        ("\"thindielectric\"", 6),
        ("\"coateddiffuse\" \"float roughness\" .1", 1),
    ] {
        let bumped =
            stage(1.0, depth, &format!("{ramp}Material {material} \"texture displacement\" \"ramp\"\n"), plane);
        let expected = stage(1.0, depth, &format!("Material {material}\n"), &tilted);
        let even = stage(1.0, depth, &format!("Material {material}\n"), plane);
        let [same, other] = [&expected, &even].map(|image| compare(&bumped, image).expect("one size").relmse);
        println!("{material}: relMSE {same:.1e} to the tilted plane, {other:.1e} to the even one");
        assert!(same < 1e-3 && other > 20.0 * same, "{material}: {same} {other}");
    }
}

/// A texture of one height raises the surface without a change of its normals.
#[test]
fn a_constant_height_bends_nothing() {
    let flat = "Texture \"h\" \"float\" \"bilerp\" \"float v00\" .1 \"float v10\" .1 \"float v01\" .1 \"float v11\" .1\n\
                Material \"conductor\" \"texture displacement\" \"h\"\n";
    for shape in ["Translate 0 0 .6 Shape \"sphere\" \"float radius\" .6", "Shape \"cylinder\" \"float radius\" .5"] {
        let [bumped, even] = [flat, "Material \"conductor\"\n"].map(|material| stage(1.0, 6, material, shape));
        let difference = compare(&bumped, &even).expect("one size").relmse;
        println!("{shape}: relMSE {difference:.1e}");
        assert!(difference < 1e-4, "{shape}: {difference}");
    }
}

/// Heights are lengths: they grow with the scene.
#[test]
fn bumps_grow_with_the_scene() {
    let bumped = |scale: f64| {
        let height = 0.05 * scale;
        let material = format!(
            "Texture \"noise\" \"float\" \"fbm\"\n\
             Texture \"h\" \"float\" \"scale\" \"texture tex\" \"noise\" \"float scale\" {height}\n\
             Material \"conductor\" \"texture displacement\" \"h\"\nTranslate 0 0 .6\nScale 1 .7 1\n"
        );
        stage(scale, 6, &material, "Shape \"sphere\" \"float radius\" .6")
    };
    let even = stage(
        1.0,
        6,
        "Material \"conductor\"\nTranslate 0 0 .6\nScale 1 .7 1\n",
        "Shape \"sphere\" \"float radius\" .6",
    );
    let [small, large] = [1.0, 1000.0].map(bumped);
    let [same, other] = [&large, &even].map(|image| compare(&small, image).expect("one size").relmse);
    println!("relMSE {same:.1e} to the larger scene, {other:.1e} to the even ball");
    assert!(same < 0.02 && other > 5.0 * same, "{same} {other}");
}

/// An image of one normal bends all normals alike, also those of bytes: they are linear, and z leaves the surface.
#[test]
fn a_normal_map_is_shaded_as_a_tilted_plane() {
    let normal = [0.5, 0.25, 1.0];
    let length = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
    let pixel = normal.map(|x| (0.5 + 0.5 * x / length) as f32);
    let file = support::ImageFile::new(&Image::from_pixels(1, 1, vec![pixel]).expect("an image"));
    let plane = "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point2 uv\" [0 0 1 0 1 1 0 1] \
                 \"point3 P\" [-.8 -.8 .5  .8 -.8 .5  .8 .8 .5  -.8 .8 .5]";
    let tilted = format!("{plane} \"normal N\" [.5 .25 1 .5 .25 1 .5 .25 1 .5 .25 1]\n");
    let mapped = format!("Material \"coateddiffuse\" \"string normalmap\" \"{}\"\n", file.path().display());
    let bumped = stage(1.0, 6, &mapped, plane);
    let [expected, even] = [tilted.as_str(), plane].map(|shape| stage(1.0, 6, "Material \"coateddiffuse\"\n", shape));
    let [same, other] = [&expected, &even].map(|image| compare(&bumped, image).expect("one size").relmse);
    println!("relMSE {same:.1e} to the tilted plane, {other:.1e} to the even one");
    assert!(same < 1e-3 && other > 20.0 * same, "{same} {other}");
}
