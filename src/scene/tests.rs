//! Tests of whole scenes: their resolved form, or the error.

use std::f64::consts::PI;
use std::fs;

use glam::DVec3;
use proptest::prelude::*;

use super::*;

mod format;
mod material;
mod medium;
mod objects;

const SCENE: &str = "\
Film \"rgb\" \"integer xresolution\" 200 \"integer yresolution\" 100 \"string filename\" \"a.exr\"
Sampler \"halton\" \"integer pixelsamples\" 64
Integrator \"sppm\" \"integer maxdepth\" 20 \"float radius\" 0.05 \"integer photonsperiteration\" 1000
LookAt 0 1 5  0 1 0  0 1 0
Camera \"perspective\" \"float fov\" 90
WorldBegin
MakeNamedMaterial \"gold\" \"string type\" \"conductor\" \"spectrum eta\" \"metal-Au-eta\" \"spectrum k\" \"metal-Au-k\"
AttributeBegin
  Translate 1 2 3
  Scale 2 2 2
  NamedMaterial \"gold\"
  ReverseOrientation
  AreaLightSource \"diffuse\" \"rgb L\" [1 2 3] \"float scale\" 2 \"bool twosided\" true \"float power\" 7
  Shape \"sphere\" \"float radius\" 0.5
AttributeEnd
Material \"dielectric\" \"spectrum eta\" \"glass-BK7\" \"rgb transmittance\" [1 .5 1]
Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"point2 uv\" [0 0 1 0 0 1]
Shape \"disk\" \"float innerradius\" .25 \"float phimax\" 180
LightSource \"point\" \"rgb I\" [1 1 1] \"float power\" 10 \"point3 from\" [1 0 0]
";

fn parse(text: &str) -> Result<Scene, SceneError> {
    Scene::parse(text, "t.pbrt", "")
}

/// Returns a scene with one line of `world` in a world that is complete without it.
fn in_world(world: &str) -> Result<Scene, SceneError> {
    parse(&format!("WorldBegin\n{world}\nLightSource \"infinite\"\nShape \"sphere\"\n"))
}

fn light(world: &str) -> Light {
    in_world(world).unwrap().lights.remove(0)
}

fn message(result: Result<Scene, SceneError>) -> String {
    result.unwrap_err().to_string()
}

fn assert_refused(world: &str, expected: &str) {
    let error = message(in_world(world));
    assert!(error.starts_with("t.pbrt:") && error.contains(expected), "{world}:\n{error}");
}

#[test]
fn a_scene_is_resolved() {
    let scene = parse(SCENE).unwrap();
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    assert_eq!(scene.film.resolution, [200, 100]);
    assert_eq!(scene.film.filename, Some("a.exr".into()));
    assert_eq!(scene.film.filter.kind, FilterKind::Gaussian { sigma: 0.5 });
    assert_eq!(scene.camera.screen_window, [-2.0, 2.0, -1.0, 1.0]);
    let Projection::Perspective { tan_half_fov } = scene.camera.projection else {
        panic!("not a perspective camera");
    };
    assert!((tan_half_fov - 1.0).abs() < 1e-12);
    let eye = scene.camera.world_from_camera.translation;
    assert!(eye.distance(DVec3::new(0.0, 1.0, 5.0)) < 1e-12);
    let expected =
        Integrator { max_depth: 20, photons_per_iteration: Some(1000), radius: Some(0.05), seed: 0, iterations: 64 };
    assert_eq!(scene.integrator, expected);

    let ball = &scene.shapes[0];
    assert_eq!(ball.location, "t.pbrt:14:3");
    assert!(ball.reverse_orientation);
    let point = ball.world_from_object.transform_point3(DVec3::X);
    assert_eq!(point, DVec3::new(3.0, 2.0, 3.0));
    let emission = ball.emission.as_ref().unwrap();
    assert_eq!(emission.radiance, Rgb::new(2.0, 4.0, 6.0));
    assert!(emission.two_sided && emission.power == Some(7.0));
    assert!(matches!(scene.materials[ball.material], Material::Conductor { .. }));

    let triangle = &scene.shapes[1];
    assert!(triangle.emission.is_none() && !triangle.reverse_orientation);
    let Geometry::Mesh(mesh) = &triangle.geometry else {
        panic!("not a mesh");
    };
    assert_eq!(mesh.triangles, [[0, 1, 2]]);
    assert_eq!(mesh.uvs.len(), 3);
    let glass = &scene.materials[triangle.material];
    assert!(matches!(glass, Material::Dielectric { eta, transmittance, .. }
        if (eta.mean - 1.518).abs() < 1e-3 && *transmittance == Rgb::new(1.0, 0.5, 1.0)));
    assert!(matches!(scene.shapes[2].geometry, Geometry::Disk { radius: 1.0, phi_max, .. }
        if (phi_max - PI).abs() < 1e-12));
}

#[test]
fn lights_have_the_units_of_pbrt() {
    let point = light("Translate 0 1 0 LightSource \"point\" \"rgb I\" [1 2 4] \"float power\" 8 \"float scale\" 3");
    let intensity = Rgb::new(1.0, 2.0, 4.0) * (3.0 * 8.0 / (4.0 * PI));
    let position = DVec3::Y;
    let expected = Light::Point { position, intensity };
    assert_eq!(point, expected);
    let Light::Spot { direction, falloff_start, falloff_end, intensity, .. } = light(
        "Rotate 90 0 1 0 LightSource \"spot\" \"float coneangle\" 60 \"float conedeltaangle\" 60 \"float power\" 1",
    ) else {
        panic!("not a spot light");
    };
    assert!(direction.distance(DVec3::X) < 1e-12);
    assert!(falloff_start.abs() < 1e-12 && (falloff_end - 0.5).abs() < 1e-12);
    assert!((intensity.x - 1.0 / (2.0 * PI * 0.25)).abs() < 1e-12);
    let distant =
        light("LightSource \"distant\" \"point3 from\" [0 9 0] \"point3 to\" [0 0 0] \"float illuminance\" 5");
    let expected = Light::Distant { direction: -DVec3::Y, irradiance: Rgb::splat(5.0) };
    assert_eq!(distant, expected);
    let default = Light::Distant { direction: DVec3::Z, irradiance: Rgb::ONE };
    assert_eq!(light("LightSource \"distant\""), default);
    let sky = light("LightSource \"infinite\" \"rgb L\" [2 2 2] \"float illuminance\" 6");
    assert_eq!(sky, Light::Infinite { radiance: Rgb::splat(12.0 / PI) });
}

#[test]
fn transforms_and_coordinate_systems_compose() {
    let place = |world: &str| {
        let scene = in_world(&format!("{world} Shape \"sphere\"")).unwrap();
        scene.shapes[0].world_from_object.transform_point3(DVec3::X)
    };
    let near = |a: DVec3, b: [f64; 3]| assert!(a.distance(b.into()) < 1e-12, "{a} {b:?}");
    near(place("Translate 1 0 0 Rotate 90 0 0 1"), [1.0, 1.0, 0.0]);
    near(place("Translate 5 5 5 Transform [2 0 0 0 0 1 0 0 0 0 1 0 7 8 9 1]"), [9.0, 8.0, 9.0]);
    near(place("Scale 2 1 1 ConcatTransform [1 0 0 0 0 1 0 0 0 0 1 0 1 0 0 1]"), [4.0, 0.0, 0.0]);
    near(place("Translate 0 3 0 CoordinateSystem \"a\" Identity CoordSysTransform \"a\""), [1.0, 3.0, 0.0]);
    near(place("Translate 0 3 0 CoordSysTransform \"world\" TransformTimes 0 1 ActiveTransform All"), [1.0, 0.0, 0.0]);
    near(place("Attribute \"shape\" \"float radius\" 2 TransformBegin Translate 1 1 1 TransformEnd"), [1.0, 0.0, 0.0]);
}

#[test]
fn what_cannot_change_the_image_is_passed_over() {
    let scene = parse(
        "Accelerator \"bvh\" \"string splitmethod\" \"sah\"
        Option \"integer seed\" 3 Option \"bool disablepixeljitter\" false
        Film \"gbuffer\" \"bool savefp16\" false \"string sensor\" \"cie1931\" \"float iso\" 100
        Integrator \"volpath\" \"integer maxdepth\" 9 \"bool regularize\" true
        WorldBegin
        MakeNamedMedium \"fog\" \"string type\" \"homogeneous\" MediumInterface \"\" \"\"
        Texture \"t\" \"float\" \"constant\" \"float value\" 1
        MakeNamedMaterial \"hair\" \"string type\" \"hair\" \"float whatever\" 3
        Material \"subsurface\" NamedMaterial \"later\"
        LightSource \"infinite\" LightSource \"point\" \"rgb I\" [0 0 0] Shape \"sphere\"
        MakeNamedMaterial \"later\" \"string type\" \"diffuse\" \"float roughness\" 0",
    );
    let error = message(scene);
    assert!(error.contains("11:59: unknown parameter \"float roughness\""), "{error}");
    let scene = parse(
        "Integrator \"volpath\" \"integer maxdepth\" 9 Camera \"perspective\" WorldBegin
        Texture \"t\" \"float\" \"constant\" \"float value\" 1
        Material \"subsurface\" NamedMaterial \"later\"
        LightSource \"infinite\" LightSource \"point\" \"rgb I\" [0 0 0] Shape \"sphere\"
        MakeNamedMaterial \"later\" \"string type\" \"diffuse\"",
    )
    .unwrap();
    let expected = ["t.pbrt:1:12: Integrator \"volpath\" is rendered as \"sppm\""];
    assert_eq!(scene.warnings, expected);
    assert_eq!(scene.integrator.max_depth, 9);
    assert_eq!((scene.lights.len(), scene.materials.len()), (1, 1));
}

#[test]
fn profiles_that_make_no_surface_are_refused() {
    for (parameters, expected) in [
        ("", "2:7: Shape \"revolution\" has no \"point2 P\"; expected the radius and height"),
        ("\"point2 P\" [1 0 1 1 0 1]", "2:20: \"point2 P\" has 3 points; expected 3 for each segment and one more"),
        ("\"integer degree\" 2 \"point2 P\" [1 0]", "has 1 points; expected 2 for each segment"),
        ("\"integer degree\" 0 \"point2 P\" [1 0 1 1]", "\"integer degree\" is 0; expected a whole number from 1 to 8"),
        ("\"integer degree\" 9 \"point2 P\" [1 0 1 1]", "\"integer degree\" is 9; expected a whole number from 1 to 8"),
        ("\"integer degree\" 1 \"point2 P\" [1 0 -.5 1]", "has (-0.5, 1) at position 1; expected a radius from 0"),
        (
            "\"integer degree\" 1 \"point2 P\" [1 0 1 1e31]",
            "at position 1; expected a radius from 0 and a height, up to",
        ),
        ("\"integer degree\" 1 \"point2 P\" [1 nan 1 1]", "found `nan` as a value of \"point2 P\""),
        ("\"integer degree\" 1 \"point2 P\" [0 0 0 1]", "stays on the axis; expected a profile that makes a surface"),
        ("\"integer degree\" 1 \"point2 P\" [1 2 1 2]", "is a single point; expected a profile"),
        ("\"integer degree\" 1 \"point2 P\" [1 2 1]", "has 3 values; expected a multiple of 2"),
        ("\"point3 P\" [1 2 1]", "\"point3 P\" has the wrong type; Shape \"revolution\" accepts"),
    ] {
        let error = message(in_world(&format!("Shape \"revolution\" {parameters}")));
        assert!(error.contains(expected), "{parameters}: {error}");
    }
}

#[test]
fn what_is_not_supported_yet_is_named_with_its_place() {
    for (world, expected) in [
        (
            "Material \"subsurface\" Shape \"sphere\"",
            "2:10: Material \"subsurface\" is not supported yet; supported here: \"diffuse\", \"conductor\", \"dielectric\"",
        ),
        (
            "Material \"coatedconductor\" \"rgb albedo\" [.5 .2 .2] \"float thickness\" 1 Shape \"sphere\"",
            "2:28: \"rgb albedo\" that scatters 0.30 of the light in the coat of a metal, by thickness times albedo, is not",
        ),
        (
            "Material \"dielectric\" \"spectrum eta\" \"stdillum-F1\" Shape \"sphere\"",
            "the spectrum \"stdillum-F1\" of \"spectrum eta\" is not supported yet",
        ),
        (
            "MakeNamedMedium \"fog\" \"string type\" \"uniformgrid\" MediumInterface \"fog\" \"\"",
            "2:17: MakeNamedMedium \"uniformgrid\" is not supported yet; supported here: \"homogeneous\"",
        ),
    ] {
        let result = in_world(world);
        assert!(matches!(result, Err(SceneError::Unsupported { .. })), "{world}");
        let error = message(result);
        assert!(error.starts_with("t.pbrt:") && error.contains(expected), "{error}");
    }
}

#[test]
fn broken_shapes_are_refused_with_a_reason() {
    for (world, expected) in [
        ("Shape \"sphere\" \"float radius\" -1", "2:16: \"float radius\" is -1; expected a number above 0"),
        ("Shape \"spere\"", "2:7: unknown Shape \"spere\"; expected one of: \"bilinearmesh\", "),
        ("Shape \"sphere\" \"float zmin\" 2", "expected cuts that leave some of the sphere"),
        ("Shape \"disk\" \"float innerradius\" 1", "expected 0 or more, below the radius"),
        (
            "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 3]",
            "2:53: \"integer indices\" has 3 at position 2; expected 0 to 2",
        ),
        (
            "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 -1]",
            "has -1 at position 2",
        ),
        (
            "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1]",
            "has 2 values; expected 3 for each face",
        ),
        ("Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 nan 0 0 1 0]", "2:42: found `nan`"),
        ("Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 1e999 0 0 1 0]", "2:42: `1e999` is not a finite number"),
        ("Shape \"trianglemesh\"", "2:7: Shape \"trianglemesh\" has no \"point3 P\""),
        ("Shape \"plymesh\"", "has no \"string filename\""),
        ("Shape \"plymesh\" \"string filename\" \"none.ply\"", "2:17: cannot read none.ply"),
    ] {
        assert_refused(world, expected);
    }
}

#[test]
fn broken_directives_are_refused_with_a_reason() {
    for (world, expected) in [
        ("Scale 1e200 1e200 1e200 Scale 1e200 1 1", "3:13: the transform overflows here"),
        ("Scale 0 1 1 LightSource \"spot\"", "2:25: the transform of the spot light is singular"),
        ("Scale 1 1 0 LightSource \"distant\"", "2:25: the transform takes the light's direction to 0"),
        ("Transform [1 0 0 0 0 1 0 0 0 0 1 .5 0 0 0 1]", "expected an affine matrix"),
        ("Transform [1 2", "3:1: found `LightSource`; expected 16 numbers after Transform"),
        ("Rotate 90 0 0 0", "Rotate is no transform; expected an axis that is not zero"),
        ("LookAt 1 1 1 1 1 1 0 1 0", "LookAt is no transform"),
        ("Translate 1 2 x", "2:15: found `x`; expected 3 numbers after Translate"),
        ("CoordSysTransform \"x\"", "unknown coordinate system \"x\""),
        ("AttributeBegin", "2:1: this block is never ended; expected AttributeEnd"),
        ("AttributeEnd", "2:1: this ends a block that was never begun"),
        ("NamedMaterial \"x\" Shape \"sphere\"", "2:15: unknown material \"x\""),
        (
            "MakeNamedMaterial \"x\" \"string type\" \"diffuse\" MakeNamedMaterial \"x\" \"string type\" \"diffuse\"",
            "a material \"x\" exists already",
        ),
        ("MakeNamedMaterial \"x\"", "has no \"string type\""),
        ("Material \"diffuse\" \"rgb reflectance\" [1.5 0 0]", "is [1.5, 0.0, 0.0]; expected channels from 0 to 1"),
        (
            "Material \"conductor\" \"rgb eta\" [1 1 1] \"rgb reflectance\" [1 1 1]",
            "expected either reflectance, or eta and k",
        ),
        ("Material \"dielectric\" \"float eta\" 0", "expected an index of refraction"),
        ("LightSource \"point\" \"rgb I\" [1 -1 1]", "expected channels of 0 or more"),
        ("LightSource \"point\" \"rgb I\" [1e308 1 1] \"float scale\" 1e308", "expected a smaller value"),
        ("LightSource \"spot\" \"point3 to\" [0 0 0]", "are the same point"),
        ("LightSource \"spot\" \"float coneangle\" 0", "expected an angle above 0"),
        ("LightSource \"infinite\" \"blackbody L\" 0", "expected one temperature"),
        (
            "AreaLightSource \"diffuse\" \"integer L\" 3",
            "\"integer L\" has the wrong type; AreaLightSource \"diffuse\" accepts: \"rgb L\"",
        ),
        ("Film \"rgb\"", "2:1: Film stands after WorldBegin; expected it before WorldBegin"),
        ("WorldBegin", "a second WorldBegin"),
        ("WorldEnd", "2:1: unknown directive `WorldEnd`; expected one of: Accelerator, "),
        ("Option \"sed\" 1", "2:8: unknown Option \"sed\"; expected one of: \"disablepixeljitter\" (bool)"),
        ("Option \"seed\" \"1\"", "2:15: found \"1\" as a value of \"integer seed\"; expected a whole number"),
        ("Option \"seed\" 1.0", "2:15: found `1.0` as a value of"),
        ("Option \"seed\" 4294967296", "is 4294967296; expected a whole number from -2147483648 to 4294967295"),
        ("Option \"wavefront\" 1", "found `1` as a value of \"bool wavefront\"; expected true or false"),
        ("Option \"rendercoordsys\" \"moon\"", "expected \"camera\", \"cameraworld\" or \"world\""),
        ("Option \"forcediffuse\" true", "2:8: \"bool forcediffuse\" true is not supported yet"),
        ("\"text\"", "2:1: found \"text\"; expected a directive"),
        ("Option \"integer sed\" 1", "unknown Option \"integer sed\""),
        ("Attribute \"x\"", "unknown Attribute \"x\""),
        ("Include \"no.pbrt\"", "2:9: cannot read no.pbrt"),
        ("Shape", "found `LightSource`; expected the type or name of Shape in quotes"),
    ] {
        assert_refused(world, expected);
    }
}

#[test]
fn broken_options_are_refused_with_a_reason() {
    let world = "WorldBegin LightSource \"infinite\" Shape \"sphere\"";
    for (options, expected) in [
        (
            "Film \"rgb\" \"integer xresolution\" 0",
            "1:12: \"integer xresolution\" is 0; expected a whole number from 1 to 65536",
        ),
        ("Film \"rgb\" \"integer yresolution\" -5", "from 1 to 65536"),
        ("Film \"rgb\" \"integer yresolution\" 99999999999999999999", "expected a whole number"),
        ("Camera \"perspective\" \"float fov\" 180", "expected an angle between 0 and 180"),
        ("Camera \"perspective\" \"float screenwindow\" [1 -1 0 1]", "x minimum < x maximum"),
        ("Camera \"perspective\" \"float screenwindow\" [1 2]", "2 values; expected 4 values"),
        ("Camera \"realistic\"", "1:8: Camera \"realistic\" is not supported yet"),
        ("Integrator \"sppm\" \"float radius\" 0", "expected a length from 1e-15 to 1e15"),
        ("Integrator \"sppm\" \"float radius\" -1", "expected a length"),
        ("Integrator \"sppm\" \"float radius\" 1e30", "expected a length"),
        ("Integrator \"sppm\" \"integer photonsperiteration\" 0", "expected at least 1"),
        ("Integrator \"sppm\" \"integer maxdepth\" 0", "from 1 to 65535"),
        ("Sampler \"halton\" \"integer pixelsamples\" 0", "a whole number from 1"),
        ("Shape \"sphere\"", "1:1: Shape stands before WorldBegin"),
        ("Film \"rgb", "1:6: unterminated string \"rgb"),
        ("Film \"rgb\" \"integer xresolution\" [", "found `WorldBegin` as a value of"),
    ] {
        let error = message(parse(&format!("{options}\n{world}")));
        assert!(error.starts_with("t.pbrt:") && error.contains(expected), "{error}");
    }
    for (text, expected) in [
        ("", "t.pbrt:1:1: the file ends before WorldBegin"),
        ("Scale 1 0 1 Camera \"perspective\" WorldBegin", "1:20: the transform of the camera is singular"),
        ("WorldBegin Shape \"sphere\" \"float radius\" [", "1:43: the file ends here"),
        ("WorldBegin Translate 1", "1:23: the file ends here; expected 3 numbers"),
    ] {
        let error = message(parse(text));
        assert!(error.contains(expected), "{error}");
    }
}

#[test]
fn includes_are_relative_to_the_scene_file() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    fs::create_dir(folder.path().join("sub")).unwrap();
    write("a.pbrt", "WorldBegin Include \"sub/b.pbrt\"");
    write("sub/b.pbrt", "LightSource \"infinite\"\n# caf\n Include \"sub/c.pbrt\"");
    write("sub/c.pbrt", "Shape \"sphere\" \"float radius\"");
    let load = || Scene::load(folder.path().join("a.pbrt"));
    let error = message(load());
    assert!(error.contains("expected the value of"), "{error}");
    write("sub/c.pbrt", "Shape \"sphere\" \"float radius\" 1 Include \"a.pbrt\"");
    let error = message(load());
    assert!(error.contains("c.pbrt:1:33: Include") && error.contains("includes itself"), "{error}");
    let mut latin = b"# caf\xe9\n".to_vec();
    latin.extend(b"Shape \"sphere\" \"float radius\" 1");
    fs::write(folder.path().join("sub/c.pbrt"), latin).unwrap();
    let scene = load().unwrap();
    assert!(scene.shapes[0].location.ends_with("sub/c.pbrt:2:1"));
    let missing = Scene::load(folder.path().join("missing.pbrt"));
    assert!(matches!(missing, Err(SceneError::Unreadable { location: None, .. })));
}

#[test]
fn meshes_name_the_directive_and_the_file() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("m.ply"), "ply\nformat ascii 1.0\nelement vertex 3\n").unwrap();
    let text = "WorldBegin\nShape \"plymesh\" \"string filename\" \"m.ply\"";
    let error = message(Scene::parse(text, "t.pbrt", folder.path()));
    assert!(error.starts_with("t.pbrt:2:17: ") && error.contains("m.ply: byte 38: "), "{error}");
}

const WORDS: [&str; 28] = [
    "WorldBegin",
    "AttributeBegin",
    "AttributeEnd",
    "Shape",
    "\"sphere\"",
    "\"trianglemesh\"",
    "\"float radius\"",
    "\"integer indices\"",
    "\"point3 P\"",
    "[",
    "]",
    "0",
    "1",
    "-1",
    "1e308",
    "99999999999999999999",
    "Scale",
    "Transform",
    "LookAt",
    "LightSource",
    "\"infinite\"",
    "\"blackbody L\"",
    "Material",
    "\"conductor\"",
    "\"spectrum eta\"",
    "true",
    "#",
    "\"",
];

proptest! {
    #[test]
    fn token_soup_never_panics(words in prop::collection::vec(prop::sample::select(&WORDS[..]), 0..60)) {
        let _ = parse(&words.join(" "));
        let _ = in_world(&words.join(" "));
    }

    #[test]
    fn mutations_never_panic(
        at in any::<prop::sample::Index>(),
        cut in 0usize..30,
        splice in "[-0-9a-zA-Z\\[\\]\" .\\n\\PC]{0,10}",
    ) {
        let mut characters: Vec<char> = SCENE.chars().collect();
        let start = at.index(characters.len());
        let end = (start + cut).min(characters.len());
        characters.splice(start..end, splice.chars());
        let text: String = characters.into_iter().collect();
        let _ = parse(&text);
    }
}
