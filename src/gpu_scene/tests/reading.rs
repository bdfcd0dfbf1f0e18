//! Tests of unusual input that pbrt-v4 accepts, against its interpretation.

use std::fs;

use glam::DVec3;

use crate::gpu_scene::pack::{PackedScene, RevolutionSolver, pack};
use crate::scene::*;

fn parse(text: &str) -> Result<Scene, SceneError> {
    Scene::parse(text, "t.pbrt", "")
}

/// Returns a scene with some text in a world that is complete without it.
fn in_world(world: &str) -> Scene {
    parse(&format!("WorldBegin\nLightSource \"infinite\"\nShape \"sphere\"\n{world}")).unwrap()
}

fn packed(scene: &Scene) -> PackedScene {
    pack(scene, RevolutionSolver::default()).unwrap()
}

fn assert_warned(scene: &Scene, expected: &str) {
    assert!(scene.warnings.iter().any(|warning| warning.starts_with(expected)), "{expected}: {:#?}", scene.warnings);
}

/// A triangle with normals at its three vertices. One with an invalid normal equals one without normals.
#[test]
fn normals_that_are_none_leave_the_triangle_its_own() {
    let folder = tempfile::tempdir().unwrap();
    let pack_with = |normals: [&str; 3], before: &str| {
        let corners = ["-1 0 0", "1 0 0", "0 1 0"];
        let vertices: String = corners.iter().zip(normals).map(|(p, n)| format!("{p} {n}\n")).collect();
        let properties: String = ["x", "y", "z", "nx", "ny", "nz"].map(|p| format!("property float {p}\n")).concat();
        let faces = "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
        let file = format!("ply\nformat ascii 1.0\nelement vertex 3\n{properties}{faces}{vertices}3 0 1 2\n");
        fs::write(folder.path().join("m.ply"), file).unwrap();
        let text =
            format!("WorldBegin LightSource \"infinite\" {before} Shape \"plymesh\" \"string filename\" \"m.ply\"");
        packed(&Scene::parse(&text, "t.pbrt", folder.path()).unwrap())
    };
    for before in ["", "ReverseOrientation", "Scale -1 1 1"] {
        let turned = before == "ReverseOrientation";
        for bad in ["nan nan nan", "0 inf 0", "-nan(ind) 0 1", "NaN 0 1"] {
            let packed = pack_with([bad, "0 0 -1", "0 0 -1"], before);
            assert!(packed.arrays.triangle_normals.is_empty() && !packed.features.has_shading_normals, "{bad}");
            let [a, b, c] =
                [packed.arrays.triangles[0].p0, packed.arrays.triangles[0].p1, packed.arrays.triangles[0].p2]
                    .map(DVec3::from_f32);
            assert_eq!((b - a).cross(c - a).z < 0.0, turned, "{bad} after {before:?}");
        }
        let packed = pack_with(["0 0 0"; 3], before);
        assert!(packed.arrays.triangle_normals.is_empty(), "no direction at all");
        // The sum of the other normals, which pbrt uses, has a direction.
        assert_eq!(pack_with(["0 0 0", "0 0 1", "0 0 1"], before).arrays.triangle_normals.len(), 1);
    }
}

trait FromF32 {
    fn from_f32(point: [f32; 3]) -> Self;
}

impl FromF32 for DVec3 {
    fn from_f32(point: [f32; 3]) -> Self {
        Self::from(point.map(f64::from))
    }
}

#[test]
fn other_meshes_fall_back_on_their_own_normals_too() {
    let patch = "\"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0]";
    let zero = in_world(&format!("Shape \"bilinearmesh\" {patch} \"normal N\" [0 0 0 0 0 0 0 0 0 0 0 0]"));
    assert!(packed(&zero).arrays.triangle_normals.is_empty());
    let mesh = "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"normal N\" [0 0 0 0 0 0 0 0 0]";
    assert!(packed(&in_world(mesh)).arrays.triangle_normals.is_empty());
}

#[test]
fn transforms_that_cannot_be_inverted_matter_only_to_what_needs_them() {
    let singular = "ConcatTransform [ 0 0 0 0  0 1 0 0  0 0 1 0  2 0 0 1 ]";
    let plain = in_world("");
    let unused = in_world(&format!("AttributeBegin\n{singular}\nAttributeEnd"));
    assert_eq!(unused.warnings.len(), plain.warnings.len());
    let undone = in_world(&format!("{singular} Identity Shape \"disk\""));
    assert_eq!(undone.shapes.len(), 2);
    // No ray meets a flattened quadric, as in pbrt.
    for shape in
        ["sphere", "disk", "cylinder", "revolution\" \"integer degree\" 1 \"point2 P\" [ 1 0 0 1 ] \"float alpha"]
    {
        let alpha = if shape.starts_with("rev") { " 1" } else { "" };
        let scene = in_world(&format!("{singular}\nShape \"{shape}\"{alpha}"));
        assert_eq!(scene.shapes.len(), 1, "{shape}");
        assert_warned(&scene, "t.pbrt:5:1: its transform flattens it to a plane, a line or a point");
    }
    let instance = in_world(&format!("ObjectBegin \"o\" Shape \"disk\" ObjectEnd {singular}\nObjectInstance \"o\""));
    assert!(instance.instances.is_empty());
    assert_warned(&instance, "t.pbrt:5:1: its transform flattens it to a plane");
    // A flattened mesh keeps its points; normals have no transform.
    let mesh = "Shape \"trianglemesh\" \"point3 P\" [0 0 0 0 1 0 0 0 1] \"normal N\" [1 0 0 1 0 0 1 0 0]";
    let scene = packed(&in_world(&format!("{singular} {mesh}")));
    assert_eq!((scene.arrays.triangles.len(), scene.arrays.triangle_normals.len()), (1, 0));
    let light = in_world(&format!("{singular} LightSource \"point\" \"point3 from\" [3 4 5]"));
    assert!(matches!(light.lights[1], Light::Point { position, .. } if position == DVec3::new(2.0, 4.0, 5.0)));
    // The place of a texture's declaration does not change a map from the surface.
    let texture = |mapping: &str| {
        let made =
            format!("{singular} Texture \"t\" \"float\" \"checkerboard\" \"string mapping\" \"{mapping}\" Identity");
        format!("WorldBegin {made} Shape \"disk\" \"texture alpha\" \"t\" LightSource \"infinite\"")
    };
    assert!(parse(&texture("uv")).is_ok());
    let error = parse(&texture("planar")).unwrap_err().to_string();
    assert!(error.contains("a texture in a space that cannot be inverted"), "{error}");
}

/// A transform may be finite and still move points to infinity.
#[test]
fn points_that_are_no_numbers_are_refused() {
    let huge = "Transform [ 1e100 1e100 0 0  -1e100 -2e100 0 0  0 0 1 0  0 0 0 1 ] Shape \"trianglemesh\" \"point3 P\"";
    for points in ["1e250 1e250 0 1e250 1e250 0 0 0 0", "1e250 1e250 0 1e250 1e250 0 1e250 1e250 0"] {
        let error = parse(&format!("WorldBegin {huge} [ {points} ]")).unwrap_err().to_string();
        assert!(error.contains("coordinates overflow"), "{error}");
    }
}

#[test]
fn of_a_parameter_that_is_given_twice_the_first_counts() {
    let scene = in_world(
        "LightSource \"point\" \"rgb I\" [ 1 1 1 ] \"float scale\" 2 \"rgb I\" [ 9 9 9 ] \"point3 from\" [ 0 3 0 ]\n\"float scale\" 7",
    );
    let expected = Light::Point { position: DVec3::new(0.0, 3.0, 0.0), intensity: Rgb::splat(2.0) };
    assert_eq!(scene.lights[1], expected);
    assert_warned(&scene, "t.pbrt:5:1: \"float scale\" is given again; its first value is used");
    let error = parse("WorldBegin Shape \"disk\" \"float alpha\" 1 \"texture alpha\" \"t\"").unwrap_err().to_string();
    assert!(error.contains("1:41: \"texture alpha\" is given a second time, before as \"float\""), "{error}");
}

#[test]
fn options_are_a_bare_name_and_a_value() {
    let with = |option: &str| parse(&format!("{option} WorldBegin LightSource \"infinite\" Shape \"sphere\"")).unwrap();
    for option in ["\"seed\" 42", "\"integer seed\" 42", "\"integer seed\" [ 42 ]", "\"Seed\" 42"] {
        assert_eq!(with(&format!("Option {option}")).integrator.seed, 42, "{option}");
    }
    assert_eq!(with("Option \"seed\" -1").integrator.seed, u32::MAX);
    for (option, radius) in [
        ("\"disablepixeljitter\" true", 0.0),
        ("\"disable-pixel_jitter\" true", 0.0),
        ("\"disablepixeljitter\" false", 1.5),
        ("\"bool disablepixeljitter\" true", 0.0),
    ] {
        assert_eq!(with(&format!("Option {option}")).film.filter.radius.x, radius, "{option}");
    }
    with("Option \"rendercoordsys\" \"world\" Option \"displacementedgescale\" 1.5 Option \"pixelstats\" false");
    with("Option \"forcediffuse\" false Option \"msereferenceimage\" \"a.exr\" Option \"msereferenceout\" \"b\"");
    with("Integrator \"path\" \"float rrthreshold\" 0.5 Option \"wavefront\" true");
    with("Camera \"spherical\" \"float lensradius\" 1 \"float screenwindow\" [ -1 1 -1 1 ]");
}

fn coat(params: &str) -> (Coat, Vec<String>) {
    let textures = "Texture \"t\" \"float\" \"checkerboard\" \"float tex1\" 0.01 \"float tex2\" 0.03\n\
        Texture \"a\" \"spectrum\" \"scale\" \"texture tex\" \"b\" \"texture scale\" \"t\"\n\
        Texture \"b\" \"spectrum\" \"bilerp\" \"rgb v00\" [ 1 1 1 ] \"rgb v11\" [ .2 .2 .2 ] \"rgb v01\" [ 0 0 0 ]\n";
    let scene = in_world(&format!("{textures}Material \"coatedconductor\" {params} Shape \"disk\""));
    match &scene.materials[scene.shapes[1].material] {
        Material::CoatedConductor { coat, .. } => (coat.clone(), scene.warnings.clone()),
        other => panic!("{other:?}"),
    }
}

#[test]
fn coats_take_the_mean_of_their_albedo() {
    let plain = coat("").1.len();
    let (textured, warnings) = coat("\"texture thickness\" \"t\" \"texture g\" \"t\"");
    assert!(matches!(textured.thickness, Input::Texture(_)), "{textured:?}");
    assert_eq!((textured.absorbed, warnings.len()), (1.0, plain), "{warnings:#?}");
    // 0.3 is the mean of the corners 1, 0, 0, 0.2; scattered light is not lost.
    let (scattering, warnings) = coat("\"float thickness\" 0.1 \"texture albedo\" \"b\"");
    assert_eq!(scattering.thickness, Input::Constant(0.1));
    assert!((scattering.absorbed - 0.7).abs() < 1e-15, "{}", scattering.absorbed);
    assert!(warnings.iter().any(|w| w.contains("\"texture albedo\" is rendered as its mean, 0.3000")), "{warnings:#?}");
    assert!(warnings.iter().any(|w| w.contains("is rendered as if it went straight on")), "{warnings:#?}");
    let (product, _) = coat("\"float thickness\" 1 \"texture albedo\" \"a\"");
    assert!((product.absorbed - (1.0 - 0.3 * 0.02)).abs() < 1e-15, "{}", product.absorbed);
}

#[test]
fn black_bodies_are_spectra_like_others() {
    let scene = in_world(
        "Texture \"t\" \"spectrum\" \"checkerboard\" \"blackbody tex1\" 3000
        Material \"diffuse\" \"blackbody reflectance\" 5500 Shape \"disk\"
        Material \"dielectric\" \"blackbody eta\" 5500 Shape \"disk\"
        Material \"conductor\" \"blackbody k\" 5500 Shape \"disk\"",
    );
    let Material::Diffuse { reflectance: Input::Constant(rgb) } = scene.materials[1] else {
        panic!("{:?}", scene.materials[1]);
    };
    assert!(rgb.min_element() > 0.9 && rgb.max_element() <= 1.0, "{rgb}");
    assert!(matches!(scene.materials[2], Material::Dielectric { ref eta, .. } if (0.9..1.0).contains(&eta.mean)));
}

/// The order of declarations does not change the scene.
#[test]
fn textures_may_be_declared_after_what_names_them() {
    let textures = [
        "Texture \"c\" \"spectrum\" \"checkerboard\" \"rgb tex1\" [ .5 .6 .7 ]",
        "Texture \"f\" \"float\" \"bilerp\" \"float v00\" .5",
        "Texture \"s\" \"spectrum\" \"scale\" \"texture tex\" \"c\" \"texture scale\" \"f\"",
        "Texture \"m\" \"spectrum\" \"mix\" \"texture tex1\" \"s\" \"texture tex2\" \"c\" \"texture amount\" \"f\"",
    ];
    let users = [
        "Material \"diffuse\" \"texture reflectance\" \"m\" Shape \"disk\"",
        "MakeNamedMaterial \"a\" \"string type\" \"conductor\" \"texture roughness\" \"f\"",
        "MakeNamedMaterial \"b\" \"string type\" \"mix\" \"string materials\" [ \"a\" \"d\" ] \"texture amount\" \"f\"",
        "NamedMaterial \"b\" Shape \"sphere\" \"texture alpha\" \"f\"",
        "MakeNamedMaterial \"d\" \"string type\" \"diffusetransmission\" \"texture transmittance\" \"s\"",
    ];
    let bytes = |parts: &[&str]| {
        let packed = packed(&in_world(&parts.join("\n")));
        (bytemuck::cast_slice::<_, u8>(&packed.arrays.materials).to_vec(), packed.arrays.texture_nodes.len())
    };
    let in_order = bytes(&[&textures[..], &users].concat());
    assert!(in_order.1 > 3);
    assert_eq!(bytes(&[&users[..], &textures].concat()), in_order);
    let backward: Vec<&str> = textures.iter().rev().copied().collect();
    assert_eq!(bytes(&[&users[..], &backward].concat()), in_order);
    let error = parse("WorldBegin Material \"diffuse\" \"texture reflectance\" \"x\"").unwrap_err().to_string();
    assert!(
        error.starts_with("t.pbrt:1:31: \"texture reflectance\" is [\"x\"]; expected the name of a Texture"),
        "{error}"
    );
}

#[test]
fn light_of_interface_shapes_is_ignored() {
    let scene = in_world("AreaLightSource \"diffuse\" Material \"interface\"\nShape \"disk\"");
    assert_eq!(scene.shapes.len(), 1);
    assert_warned(&scene, "t.pbrt:5:1: the shape is of the material \"interface\"; its area light is ignored");
    let alone = parse("WorldBegin LightSource \"infinite\" Material \"interface\" Shape \"sphere\"").unwrap();
    assert!(alone.shapes.is_empty());
}

#[test]
fn scenes_of_pbrt_v3_are_told_so() {
    let v3 = "this is of pbrt-v3: convert the scene with pbrt-v4's `pbrt --upgrade";
    for text in [
        "Film \"image\"",
        "Camera \"environment\"",
        "Sampler \"02sequence\"",
        "Integrator \"directlighting\"",
        "Integrator \"whitted\"",
        "PixelFilter \"box\" \"float xwidth\" 1",
        "Film \"rgb\" \"float scale\" 1",
        "WorldBegin WorldEnd",
        "WorldBegin Material \"matte\"",
        "WorldBegin MakeNamedMaterial \"a\" \"string type\" \"uber\"",
        "WorldBegin Material \"diffuse\" \"color reflectance\" [ 1 1 1 ]",
        "WorldBegin Texture \"a\" \"color\" \"constant\"",
        "WorldBegin Texture \"a\" \"spectrum\" \"uv\"",
        "WorldBegin LightSource \"point\" \"point from\" [ 1 1 1 ]",
        "WorldBegin LightSource \"infinite\" \"string mapname\" \"a.exr\"",
        "WorldBegin LightSource \"point\" \"blackbody I\" [ 6500 2 ]",
        "WorldBegin Shape \"heightfield\"",
        "WorldBegin Shape \"nurbs\"",
    ] {
        let error = parse(text).unwrap_err().to_string();
        assert!(error.contains(v3), "{text}: {error}");
    }
    let error = parse("WorldBegin Material \"mate\"").unwrap_err().to_string();
    assert!(!error.contains("pbrt-v3"), "{error}");
}

#[test]
fn scenes_of_nothing_are_read_with_warnings() {
    let scene = parse("WorldBegin\n").unwrap();
    assert_warned(&scene, "t.pbrt:2:1: the scene has no shape");
    assert_warned(&scene, "t.pbrt:2:1: the scene has no light, or only black lights");
}
