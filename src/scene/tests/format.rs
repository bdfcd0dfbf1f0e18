//! Tests of film, filters, cameras, moving transforms, colour spaces and files of scene text.

use std::fs;

use glam::DVec3;

use crate::image::film::CoordinateSystem;
use crate::scene::*;

const WORLD: &str = "WorldBegin LightSource \"infinite\" Shape \"sphere\"";

fn parse(text: &str) -> Scene {
    Scene::parse(text, "t.pbrt", "").unwrap()
}

/// Returns a scene with one line of options.
fn with(options: &str) -> Scene {
    parse(&format!("{options}\n{WORLD}"))
}

fn refusal(text: &str) -> String {
    Scene::parse(text, "t.pbrt", "").unwrap_err().to_string()
}

/// Returns the position of the first shape's point (1, 0, 0).
fn place(world: &str) -> (DVec3, Vec<String>) {
    let scene = parse(&format!("WorldBegin LightSource \"infinite\"\n{world} Shape \"sphere\""));
    (scene.shapes[0].world_from_object.transform_point3(DVec3::X), scene.warnings)
}

#[test]
fn crops_are_the_pixels_that_pbrt_would_render() {
    let bounds = |film: &str| {
        let scene = with(&format!("Film \"rgb\" \"integer xresolution\" 200 \"integer yresolution\" 100 {film}"));
        scene.film.bounds(scene.film.resolution)
    };
    assert_eq!(bounds(""), [[0, 0], [200, 100]]);
    assert_eq!(bounds("\"float cropwindow\" [.25 .5 0 .301]"), [[50, 0], [100, 31]]);
    assert_eq!(bounds("\"float cropwindow\" [.5 .25 -1 2]"), [[50, 0], [100, 100]]);
    assert_eq!(bounds("\"integer pixelbounds\" [7 13 99 300]"), [[7, 99], [13, 100]]);
    assert_eq!(bounds("\"integer pixelbounds\" [7 13 9 30] \"float cropwindow\" [0 .5 0 1]"), [[0, 0], [100, 100]]);
    for side in [1, 3, 199, 4093, 65_536] {
        let scene = with(&format!(
            "Film \"rgb\" \"integer xresolution\" {side} \"integer pixelbounds\" [{} {side} 0 1]",
            side - 1
        ));
        assert_eq!(scene.film.bounds([side, 720]), [[side - 1, 0], [side, 1]]);
    }
    let scene = with("Film \"rgb\" \"float cropwindow\" [.5 .50001 .5 1]");
    assert_eq!(scene.film.bounds([2, 4]), [[1, 2], [2, 4]], "at least one pixel is left");
    for film in ["\"integer pixelbounds\" [5 5 0 9]", "\"float cropwindow\" [2 3 0 1]", "\"float cropwindow\" [0 1]"] {
        assert!(refusal(&format!("Film \"rgb\" {film}\n{WORLD}")).starts_with("t.pbrt:1:12: "), "{film}");
    }
}

#[test]
fn exposure_is_shutter_time_times_iso() {
    let film = "Film \"rgb\" \"float iso\" 50 \"float exposuretime\" 3 \"float maxcomponentvalue\" 9";
    assert_eq!(with(film).film.exposure, 1.5);
    let shutter = "Camera \"perspective\" \"float shutteropen\" .25 \"float shutterclose\" .75";
    assert_eq!(with(&format!("{film} {shutter}")).film.exposure, 0.75);
    let error = refusal(&format!("Camera \"perspective\" \"float shutterclose\" 0\n{WORLD}"));
    assert!(error.contains("1:22: \"float shutterclose\" is 0; expected a shutter"), "{error}");
    let error = refusal(&format!("Film \"rgb\" \"float iso\" 1e300\n{WORLD}"));
    assert!(error.contains("expected an exposure"), "{error}");
}

#[test]
fn the_white_balance_is_a_temperature() {
    let of = |text: &str| with(&format!("Film \"rgb\" {text}")).film.white_balance;
    assert_eq!([of(""), of("\"float whitebalance\" 0")], [None; 2]);
    for (text, kelvin) in [("1000", 1e3), ("[ 5000 ]", 5e3), ("1e6", 1e6)] {
        let balance = of(&format!("\"string sensor\" \"cie1931\" \"float whitebalance\" {text}")).unwrap();
        assert!(balance.kelvin == kelvin && (balance.matrix * DVec3::ONE).is_finite(), "{balance:?}");
    }
    for value in ["-5000", "-0.5", "999", "1000001", "1e300"] {
        let error = refusal(&format!("Film \"rgb\" \"float whitebalance\" {value}\n{WORLD}"));
        let expected = "expected 0 for none, or a temperature from 1000 to 1000000 K";
        assert!(error.starts_with("t.pbrt:1:12: ") && error.contains(expected), "{value}: {error}");
    }
    for value in ["[ 5000 6000 ]", "[ ]", "\"warm\"", "nan", "1e999"] {
        let error = refusal(&format!("Film \"rgb\" \"float whitebalance\" {value}\n{WORLD}"));
        assert!(error.starts_with("t.pbrt:1:"), "{value}: {error}");
    }
}

#[test]
fn films_and_sensors_that_are_approximated_are_named() {
    let scene = with("Film \"spectral\" \"string sensor\" \"nikon_d850\" \"integer nbuckets\" 16");
    let expected = [
        "t.pbrt:1:6: Film \"spectral\" is written as an RGB image, without spectra",
        "t.pbrt:1:6: the sensor \"nikon_d850\" is rendered as \"cie1931\"",
    ];
    assert_eq!(scene.warnings[..2], expected);
}

#[test]
fn filters_have_the_defaults_of_pbrt() {
    let filter = |text: &str| with(&format!("PixelFilter {text}")).film.filter;
    let third = 1.0 / 3.0;
    let mitchell = filter("\"mitchell\"");
    assert_eq!((mitchell.kind, mitchell.radius.x), (FilterKind::Mitchell { b: third, c: third }, 2.0));
    assert_eq!(filter("\"mitchell\" \"float B\" 1 \"float C\" 0").kind, FilterKind::Mitchell { b: 1.0, c: 0.0 });
    let sinc = filter("\"sinc\" \"float xradius\" 3");
    assert_eq!((sinc.kind, sinc.radius.to_array()), (FilterKind::Sinc { tau: 3.0 }, [3.0, 4.0]));
    let still = with("Option \"bool disablepixeljitter\" true Camera \"perspective\" \"float lensradius\" 1");
    assert_eq!((still.film.filter.radius.to_array(), still.camera.lens_radius), ([0.0; 2], 0.0));
}

#[test]
fn cameras_have_the_projections_of_pbrt() {
    let camera = with("Camera \"orthographic\" \"float screenwindow\" [-3 3 -2 2]").camera;
    assert_eq!((camera.projection, camera.screen_window), (Projection::Orthographic, [-3.0, 3.0, -2.0, 2.0]));
    let projection = |text: &str| with(&format!("Camera \"spherical\" {text}")).camera.projection;
    assert_eq!(projection(""), Projection::EqualArea);
    assert_eq!(projection("\"string mapping\" \"equirectangular\""), Projection::Equirectangular);
    let error = refusal(&format!("Camera \"spherical\" \"string mapping\" \"cube\"\n{WORLD}"));
    assert!(error.contains("expected \"equalarea\" or \"equirectangular\""), "{error}");
}

#[test]
fn the_seed_is_the_integrators_else_the_options() {
    assert_eq!(with("Option \"integer seed\" 7").integrator.seed, 7);
    assert_eq!(with("Option \"integer seed\" 7 Integrator \"sppm\" \"integer seed\" 3").integrator.seed, 3);
}

#[test]
fn what_moves_stands_as_at_the_start() {
    let (at, warnings) =
        place("Translate 1 0 0 ActiveTransform EndTime Translate 0 5 0 ActiveTransform All Scale 2 2 2");
    assert_eq!(at, DVec3::new(3.0, 0.0, 0.0));
    assert!(warnings[0].contains("2:95: motion is not rendered"), "{warnings:?}");
    let both = "ActiveTransform StartTime Translate 1 0 0 ActiveTransform EndTime Translate 1 0 0";
    let (at, warnings) = place(both);
    assert_eq!((at, warnings.len()), (DVec3::new(2.0, 0.0, 0.0), 1), "{warnings:?}");
    // Named systems keep both transforms; the end of a block restores which are active.
    let (at, warnings) = place(&format!(
        "AttributeBegin ActiveTransform EndTime AttributeEnd Translate 0 1 0 CoordinateSystem \"a\" Identity {both} \
         CoordSysTransform \"a\""
    ));
    assert_eq!((at, warnings.len()), (DVec3::new(1.0, 1.0, 0.0), 1), "{warnings:?}");
}

#[test]
fn colour_spaces_are_part_of_the_graphics_state() {
    let scene = parse(
        "WorldBegin AttributeBegin ColorSpace \"rec2020\"
        LightSource \"infinite\" \"rgb L\" [0 2 0]
        Material \"diffuse\" \"rgb reflectance\" [0 .5 0] Shape \"sphere\"
        Material \"diffuse\" \"rgb reflectance\" [1 1 1] Shape \"sphere\" AttributeEnd
        Material \"diffuse\" \"rgb reflectance\" [0 .5 0] Shape \"sphere\"",
    );
    let Light::Infinite { radiance } = scene.lights[0] else {
        panic!("not an infinite light");
    };
    // By BT.2087 the other channels are negative.
    assert!(radiance.distance(Rgb::new(0.0, 2.0 * 1.1329, 0.0)) < 1e-3, "{radiance}");
    let reflectance = |index: usize| match &scene.materials[index] {
        Material::Diffuse { reflectance: Input::Constant(reflectance) } => *reflectance,
        other => panic!("{other:?}"),
    };
    assert!(reflectance(0).distance(Rgb::new(0.0, 0.5 * 1.1329, 0.0)) < 1e-3);
    assert!(reflectance(1).distance(Rgb::ONE) < 1e-9);
    assert_eq!(reflectance(2), Rgb::new(0.0, 0.5, 0.0));
    let error =
        refusal(&format!("WorldBegin ColorSpace \"aces2065-1\" LightSource \"point\" \"rgb I\" [-1 0 0] {WORLD}"));
    assert!(error.contains("expected channels of 0 or more"), "{error}");
    let error = refusal("WorldBegin ColorSpace \"rec709\"");
    assert!(error.contains("expected one of: \"srgb\", \"dci-p3\""), "{error}");
}

#[test]
fn spectra_are_read_from_files() {
    let folder = tempfile::tempdir().unwrap();
    let write = |text: &str| fs::write(folder.path().join("eta.spd"), text).unwrap();
    let text =
        "WorldBegin LightSource \"infinite\" Material \"dielectric\" \"spectrum eta\" \"eta.spd\" Shape \"sphere\"";
    let load = || Scene::parse(text, "t.pbrt", folder.path());
    write("# wavelength, eta\n300 1.5\n900\t1.5 # the end");
    let scene = load().unwrap();
    assert!(matches!(scene.materials[0], Material::Dielectric { ref eta, .. } if (eta.mean - 1.5).abs() < 1e-9));
    for (text, expected) in [
        ("300 1.5 900", "1:57: \"spectrum eta\" is [300.0, 1.5, 900.0]; expected pairs"),
        ("900 1 300 1", "wavelengths ascending"),
        ("300 eta", "eta.spd is no spectrum; expected numbers"),
        ("300 inf", "eta.spd is no spectrum; expected numbers"),
        ("", "expected pairs"),
    ] {
        write(text);
        let error = load().unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
    fs::remove_file(folder.path().join("eta.spd")).unwrap();
    let error = load().unwrap_err().to_string();
    assert!(error.starts_with("t.pbrt:1:57: cannot read "), "{error}");
}

#[test]
fn imports_leave_the_graphics_state_alone() {
    let folder = tempfile::tempdir().unwrap();
    let import = "Translate 5 0 0 MakeNamedMaterial \"m\" \"string type\" \"dielectric\" Shape \"sphere\" # end";
    fs::write(folder.path().join("i.pbrt"), import).unwrap();
    let text =
        "WorldBegin LightSource \"infinite\" Translate 1 0 0 Import \"i.pbrt\" NamedMaterial \"m\" Shape \"sphere\"";
    let path = folder.path().join("s.pbrt");
    fs::write(&path, text).unwrap();
    let check = |scene: Scene| {
        let at: Vec<f64> = scene.shapes.iter().map(|shape| shape.world_from_object.translation.x).collect();
        assert_eq!(at, [6.0, 1.0]);
        assert!(matches!(scene.materials[scene.shapes[1].material], Material::Dielectric { .. }));
    };
    let (scene, flat) = load_with_text(&path, Budget::default()).unwrap();
    check(scene);
    check(parse(&flat.text));
    assert!(refusal("Import \"i.pbrt\"").contains("1:1: Import stands before WorldBegin"));
    fs::write(folder.path().join("i.pbrt"), "Import \"i.pbrt\"").unwrap();
    let error = Scene::load(&path).unwrap_err().to_string();
    assert!(error.contains("includes itself"), "{error}");
}

#[test]
fn a_gbuffer_film_asks_for_layers_in_a_coordinate_system() {
    assert_eq!(with("Film \"rgb\" \"string coordinatesystem\" \"world\"").film.gbuffer, None);
    assert_eq!(with("Film \"spectral\"").film.gbuffer, None);
    let scene = with("Film \"gbuffer\" \"integer xresolution\" 7 \"bool savefp16\" true");
    assert_eq!((scene.film.gbuffer, scene.film.resolution[0]), (Some(CoordinateSystem::Camera), 7));
    assert!(scene.warnings.iter().all(|warning| !warning.contains("Film")), "{:?}", scene.warnings);
    for (name, system) in [("camera", CoordinateSystem::Camera), ("world", CoordinateSystem::World)] {
        let film = format!("Film \"gbuffer\" \"string coordinatesystem\" \"{name}\"");
        assert_eq!(with(&film).film.gbuffer, Some(system));
    }
    let error = refusal(&format!("Film \"gbuffer\" \"string coordinatesystem\" \"Camera\"\n{WORLD}"));
    assert!(error.starts_with("t.pbrt:1:16: ") && error.contains("\"camera\" or \"world\""), "{error}");
}
