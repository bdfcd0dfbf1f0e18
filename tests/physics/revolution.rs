//! Bodies of revolution in renders: furnaces, lights, units and places.

use std::process::Command;

use glam::DVec3;
use goblet::image::compare::{Comparison, compare};
use goblet::image::film::Image;
use goblet::scene::{Geometry, Scene};
use goblet::{ByPass, Envelopes, Options, RevolutionSolver, Tally};

use super::assert_near;
use crate::support::{self, mean, work};

/// A thin-walled cup of nine segments, an hourglass of degree 7 and a lens of degree 4.
const CUP: &str = "Shape \"revolution\" \"integer degree\" 3 \"point2 P\" [ 0 0.02  0.25 0.02  0.55 0.02  0.62 0.03 \
    0.69 0.04  0.69 0.09  0.55 0.1  0.3 0.12  0.09 0.16  0.075 0.45  0.06 0.75  0.055 0.95  0.11 1.06  0.2 1.2  \
    0.62 1.28  0.66 1.75  0.69 2.05  0.62 2.3  0.55 2.52  0.54 2.56  0.5 2.56  0.505 2.52  0.57 2.3  0.63 2.05  \
    0.605 1.75  0.575 1.36  0.2 1.3  0 1.3 ]\n";
const HOURGLASS: &str = "Shape \"revolution\" \"integer degree\" 7 \
    \"point2 P\" [ 0 0  0.9 0  1.15 0.5  0.5 1.1  0.25 1.6  0.62 1.95  0.3 2.2  0 2.2 ]\n";
const LENS: &str = "Shape \"revolution\" \"integer degree\" 4 \"point2 P\" [ 0 0  0.55 0  0.75 0.55  0.3 1  0 1 ]\n";

/// What enters glass leaves it: with light from everywhere, nothing is to be seen.
#[test]
fn glass_vanishes_in_a_furnace() {
    let mut world = String::new();
    for (i, shape) in [CUP, HOURGLASS, LENS].iter().enumerate() {
        let x = 2.0 * i as f64 - 2.0;
        world += &format!("AttributeBegin\nTranslate {x} 0 0\nRotate -90 1 0 0\n{shape}AttributeEnd\n");
        world += &format!(
            "AttributeBegin\nTranslate {x} -1.5 0\nRotate 50 1 2 {x}\nScale -.7 .5 .6\nReverseOrientation\n{shape}\
             AttributeEnd\n"
        );
    }
    let text = format!(
        "LookAt 0 .4 9  0 .4 0  0 1 0\nCamera \"perspective\" \"float fov\" 40\nWorldBegin\n\
         LightSource \"infinite\" \"rgb L\" [1 1 1]\nMaterial \"dielectric\" \"float eta\" 1.5\n{world}"
    );
    let options = Options {
        resolution: Some([96, 64]),
        photons: Some(100_000),
        radius: Some(0.1),
        max_depth: Some(400),
        ..Options::default()
    };
    let rendered = support::render(&text, &options, 4);
    // A path in 10^5 is led around in a thin wall for more than 400 reflections.
    let value = mean(&rendered.image)[0];
    assert!((value - 1.0).abs() < 5e-4, "{value}");
    let off = rendered.image.pixels.iter().filter(|pixel| (pixel[0] - 1.0).abs() > 0.005).count();
    assert!(off <= 6, "{off} pixels are off");
    let Tally { lost_in_glass, emitted, non_finite, .. } = rendered.tally;
    assert_eq!((lost_in_glass, emitted, non_finite), (0, 400_000, ByPass::default()));
}

/// A room with one lamp, a disk or a body of revolution. Light that `nee` may find at once
/// reaches a floor; without, only photons that a mirror turns back do.
fn lamp_room(lamp: &str, nee: bool) -> [f64; 3] {
    let mirror = "Material \"conductor\" \"rgb eta\" [.2 .9 1.5] \"rgb k\" [3.9 2.4 1.9] \"float roughness\" 0\n\
        Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point3 P\" [-2 -2 1.6  -2 2 1.6  2 2 1.6  2 -2 1.6]";
    let text = format!(
        "LookAt 0 -3 1  0 0 0  0 0 1\nCamera \"perspective\" \"float fov\" 12\nWorldBegin\n\
         Material \"diffuse\" \"rgb reflectance\" [.6 .6 .6]\n\
         Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point3 P\" [-2 -2 0  2 -2 0  2 2 0  -2 2 0]\n\
         {}\nMaterial \"diffuse\" \"rgb reflectance\" [0 0 0]\nTranslate .3 .2 1\n\
         AreaLightSource \"diffuse\" \"rgb L\" [3 2 1] \"float power\" 5 \"bool twosided\" {}\n{lamp}",
        if nee { "" } else { mirror },
        if nee { "true" } else { "false" }
    );
    let options = Options {
        resolution: Some([24, 24]),
        // Both lamps take the same random numbers, so that the ratio has less noise than either.
        eye_paths: Some(64),
        photons: Some(if nee { 1 } else { work(1 << 18, 1 << 20) }),
        radius: Some(0.1),
        alpha: Some(1.0),
        max_depth: Some(if nee { 1 } else { 2 }),
        ..Options::default()
    };
    mean(&support::render(&text, &options, 4).image)
}

/// A straight profile to the axis is a disk, of the same power. The squeeze makes rings
/// ellipses.
#[test]
fn a_flat_body_shines_as_a_disk_does() {
    // The mirror is above: the lamp that lights it faces up.
    let cases = [(true, "Scale 1 .5 1\n"), (false, "Scale .4 1 1\n"), (true, ""), (false, "")];
    for (nee, turn) in work(&cases[..2], &cases[..]).iter().copied() {
        let disk = lamp_room(&format!("{turn}Shape \"disk\" \"float radius\" .4"), nee);
        let flat =
            lamp_room(&format!("{turn}Shape \"revolution\" \"integer degree\" 1 \"point2 P\" [.4 0  .3 0  0 0]"), nee);
        assert!(disk[0] > 0.01);
        assert_near(&format!("flat lamp, nee {nee}, {turn:?}"), flat, disk, 0.005);
    }
}

/// The showpiece, with lengths times `factor` and moved by `shift` of the new unit.
fn wine_cup(factor: f64, shift: DVec3) -> Scene {
    let path = support::root().join("tests/reference/wine-cup.pbrt");
    let text = std::fs::read_to_string(path).expect("a scene");
    let [x, y, z] = (shift * factor).to_array();
    let place = format!("WorldBegin\nTranslate {x:?} {y:?} {z:?}\nScale {factor:?} {factor:?} {factor:?}\n");
    let mut scene =
        Scene::parse(&text.replace("WorldBegin", &place), "wine-cup.pbrt", support::root()).expect("a scene");
    scene.camera.world_from_camera.translation = (scene.camera.world_from_camera.translation + shift) * factor;
    scene
}

fn shoot_wine_cup(factor: f64, shift: DVec3) -> Image {
    let options = Options {
        resolution: Some(work([40, 40], [80, 80])),
        photons: Some(20_000),
        radius: Some(0.15 * factor),
        ..Options::default()
    };
    let rendered = support::render_scene(&support::device(), &wine_cup(factor, shift), &options, work(4, 8));
    let Tally { lost_in_glass, immersed, non_finite, .. } = rendered.tally;
    assert_eq!((lost_in_glass, immersed, non_finite), (0, 0, ByPass::default()));
    rendered.image
}

/// Roundings send a few paths another way, no more.
#[test]
fn a_wine_glass_of_any_size_anywhere_is_the_same_picture() {
    let expected = shoot_wine_cup(1.0, DVec3::ZERO);
    assert!(expected.pixels.iter().all(|pixel| pixel.iter().all(|value| *value > 0.0)), "a black pixel");
    for (factor, shift) in
        [(1e-4, DVec3::ZERO), (1e4, DVec3::ZERO), (1.0, DVec3::new(1e5, -2e5, 3e5)), (1e-4, DVec3::splat(1e5))]
    {
        let image = shoot_wine_cup(factor, shift);
        assert!(image.pixels.iter().all(|pixel| pixel.iter().all(|value| *value > 0.0)), "a black pixel");
        let Comparison { relmse, energy_ratio, .. } = compare(&image, &expected).expect("images of one size");
        println!("times {factor}, moved by {shift}: relMSE {relmse:.2e}, energy {energy_ratio:.5}");
        assert!(relmse < 1e-3, "times {factor}, moved by {shift}: {relmse}");
        assert!((energy_ratio - 1.0).abs() < 0.005, "times {factor}, moved by {shift}: {energy_ratio}");
    }
}

/// Fine meshes in place of the bodies carry the same light.
#[test]
fn a_tessellated_scene_has_the_same_energy() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = folder.path().join("meshes.pbrt");
    let status = Command::new(support::command::goblet())
        .arg("tessellate")
        .arg(support::root().join("tests/reference/wine-cup.pbrt"))
        .args(["--tolerance", "1e-4", "-o"])
        .arg(&output)
        .status()
        .expect("a process");
    assert!(status.success());
    let meshes = Scene::load(output).expect("a scene");
    assert!(meshes.shapes.iter().all(|shape| !matches!(shape.geometry, Geometry::Revolution(_))));
    let [exact, meshed] = [wine_cup(1.0, DVec3::ZERO), meshes].map(|scene| {
        let options = Options {
            resolution: Some(work([48, 48], [96, 96])),
            photons: Some(50_000),
            radius: Some(0.1),
            max_depth: Some(12),
            ..Options::default()
        };
        support::render_scene(&support::device(), &scene, &options, work(6, 16)).image
    });
    let comparison = compare(&meshed, &exact).expect("images of one size");
    let energy = comparison.energy_ratio_trimmed;
    println!("meshes: relMSE {:.2e}, energy {energy:.5}", comparison.relmse_trimmed);
    assert!((energy - 1.0).abs() < 0.005, "{comparison:#?}");
}

/// The classical solver loses a path here and there, but not the picture; and its cost does
/// not go to photons that a driver cuts short, whatever the workgroups.
#[test]
fn both_solvers_make_one_picture() {
    let text = format!(
        "LookAt 0 2 6  0 .8 0  0 1 0\nCamera \"perspective\" \"float fov\" 40\nWorldBegin\n\
         LightSource \"point\" \"point3 from\" [-1 5 3] \"rgb I\" [30 30 30]\nMaterial \"diffuse\"\n\
         Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point3 P\" [-9 0 -9  -9 0 9  9 0 9  9 0 -9]\n\
         AttributeBegin\nTranslate -.9 0 0\nRotate -90 1 0 0\n{HOURGLASS}AttributeEnd\n\
         Material \"dielectric\" \"float eta\" 1.5\nTranslate .9 .1 .5\nRotate -90 1 0 0\n{LENS}"
    );
    let scene = Scene::parse(&text, "test.pbrt", support::root()).expect("a scene");
    let shoot = |revolution_solver, workgroup_size| {
        let options = Options {
            resolution: Some([48, 32]),
            photons: Some(20_000),
            radius: Some(0.1),
            max_depth: Some(12),
            workgroup_size: Some(workgroup_size),
            revolution_solver,
            ..Options::default()
        };
        support::render_scene(&support::device(), &scene, &options, 8).image
    };
    let expected = shoot(RevolutionSolver::Certified, 64);
    for envelopes in [Envelopes::Chord, Envelopes::Tangent, Envelopes::Both] {
        let newton = RevolutionSolver::Newton { segments: 16, envelopes };
        let image = shoot(newton, 64);
        let Comparison { relmse, energy_ratio, .. } = compare(&image, &expected).expect("images of one size");
        println!("{envelopes:?}: relMSE {relmse:.2e}, energy {energy_ratio:.5}");
        assert!(image.pixels != expected.pixels, "{envelopes:?} has not been used");
        assert!(relmse < 0.02 && (energy_ratio - 1.0).abs() < 0.02, "{envelopes:?}: {relmse}, {energy_ratio}");
        assert!(shoot(newton, 32).pixels == image.pixels, "{envelopes:?}: workgroups of 32 make another picture");
    }
}
