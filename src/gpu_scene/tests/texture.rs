//! Tests of scenes with textures: the resolved textures, or the error.

use std::fs;

use glam::DVec3;

use crate::gpu_scene::pack::{RevolutionSolver, pack};
use crate::image::file;
use crate::image::film::Image;
use crate::scene::*;

/// Returns a scene with one line of `world` in a world that is complete without it.
fn in_world(world: &str) -> Result<Scene, SceneError> {
    let text = format!("WorldBegin\n{world}\nLightSource \"infinite\"\nShape \"sphere\"\n");
    Scene::parse(&text, "t.pbrt", "")
}

fn reflectance(world: &str) -> Input<Rgb> {
    let scene = in_world(world).unwrap();
    match scene.materials[scene.shapes[0].material] {
        Material::Diffuse { reflectance } => reflectance,
        ref other => panic!("{other:?}"),
    }
}

fn assert_refused(world: &str, expected: &str) {
    let error = in_world(world).unwrap_err().to_string();
    assert!(error.starts_with("t.pbrt:2:") && error.contains(expected), "{world}:\n{error}");
}

const USE: &str = "Material \"diffuse\" \"texture reflectance\" \"t\"";

#[test]
fn constants_are_folded() {
    for (texture, expected) in [
        ("\"constant\" \"rgb value\" [.1 .2 .3]", [0.1, 0.2, 0.3]),
        ("\"constant\"", [1.0, 1.0, 1.0]),
        ("\"scale\" \"rgb tex\" [.2 .4 1] \"float scale\" .5", [0.1, 0.2, 0.5]),
        ("\"mix\" \"rgb tex2\" [.2 .4 1] \"float amount\" .25", [0.05, 0.1, 0.25]),
    ] {
        let Input::Constant(value) = reflectance(&format!("Texture \"t\" \"spectrum\" {texture} {USE}")) else {
            panic!("{texture} is not constant");
        };
        assert!((value - Rgb::from(expected)).abs().max_element() < 1e-12, "{texture}: {value}");
    }
}

#[test]
fn numbers_and_colours_have_names_of_their_own() {
    let world =
        "Texture \"t\" \"float\" \"checkerboard\" Texture \"t\" \"spectrum\" \"constant\" \"rgb value\" [.1 .2 .3]
        Shape \"sphere\" \"texture alpha\" \"t\"";
    let scene = in_world(&format!("{world} {USE}")).unwrap();
    assert_eq!(scene.shapes[0].alpha, Input::Texture(0));
    assert_eq!(
        reflectance(&format!("Texture \"t\" \"float\" \"checkerboard\" Texture \"t\" \"spectrum\" \"constant\" {USE}")),
        Input::Constant(Rgb::ONE)
    );
}

#[test]
fn defaults_and_transforms_apply() {
    let world = "Attribute \"texture\" \"float uscale\" 3 Translate 1 0 0
        Texture \"t\" \"spectrum\" \"checkerboard\" \"rgb tex1\" [.5 .5 .5] \"float udelta\" .5
        Texture \"p\" \"spectrum\" \"bilerp\" \"string mapping\" \"planar\" \"vector3 v1\" [2 0 0] \"vector3 v2\" [0 0 1]";
    let textures = in_world(world).unwrap().textures;
    let TextureKind::Checkerboard { mapping: Mapping::Surface(from_uv), textures: inputs } = &textures[0].kind else {
        panic!("{:?}", textures[0]);
    };
    assert_eq!(from_uv.transform_point3(DVec3::new(1.0, 2.0, 0.0)), DVec3::new(3.5, 2.0, 0.0));
    assert_eq!(inputs, &[Input::Constant(Rgb::splat(0.5)), Input::Constant(Rgb::ZERO)]);
    let TextureKind::Bilerp { mapping: Mapping::Space(from_world), corners } = &textures[1].kind else {
        panic!("{:?}", textures[1]);
    };
    assert_eq!(from_world.transform_point3(DVec3::new(2.0, 5.0, 3.0)), DVec3::new(2.0, 3.0, 0.0));
    assert_eq!(corners, &[Rgb::ZERO, Rgb::ZERO, Rgb::ONE, Rgb::ONE]);
}

#[test]
fn what_is_not_supported_is_an_error_once_it_is_used() {
    let ptex = "Texture \"n\" \"float\" \"ptex\" \"string filename\" \"a.ptx\" Texture \"t\" \"spectrum\" \"mix\" \"texture amount\" \"n\"";
    assert!(in_world(ptex).is_ok());
    assert_refused(
        &format!("{ptex} {USE} Shape \"disk\""),
        "2:21: Texture \"ptex\" is not supported yet; supported here: \"imagemap\", for which the colours of all faces",
    );
    assert_refused(
        "Shape \"plymesh\" \"texture displacement\" \"x\"",
        "\"texture displacement\" of Shape \"plymesh\" is not",
    );
}

/// Returns what bends the normals of the first shape, and all textures.
fn bump(world: &str) -> (Option<Bump>, Vec<Texture>) {
    let scene = in_world(world).unwrap();
    match &scene.materials[scene.shapes[0].material] {
        Material::Bumped { bump, .. } => (Some(*bump), scene.textures),
        _ => (None, scene.textures),
    }
}

#[test]
fn every_material_may_have_a_displacement() {
    for material in [
        "diffuse",
        "conductor",
        "dielectric",
        "thindielectric",
        "diffusetransmission",
        "coateddiffuse",
        "coatedconductor",
    ] {
        let texture = "Texture \"h\" \"float\" \"checkerboard\"";
        let used = format!("Material \"{material}\" \"texture displacement\" \"h\" Shape \"disk\"");
        // A texture may come after its use.
        for world in [format!("{texture} {used}"), format!("{used} {texture}")] {
            assert_eq!(bump(&world).0, Some(Bump::Displacement(0)), "{world}");
            let packed = pack(&in_world(&world).unwrap(), RevolutionSolver::default()).unwrap();
            let features = packed.material_features;
            assert!(packed.features.has_shading_normals && features.has_bumps && features.has_displacements);
            assert!(!features.has_normal_maps);
        }
        // What is the same everywhere bends nothing.
        assert_eq!(bump(&format!("Material \"{material}\" \"float displacement\" .5 Shape \"disk\"")).0, None);
    }
    let mix = "Texture \"h\" \"float\" \"checkerboard\"
        MakeNamedMaterial \"a\" \"string type\" \"diffuse\" \"texture displacement\" \"h\"
        MakeNamedMaterial \"b\" \"string type\" \"conductor\" Material \"mix\" \"string materials\" [\"a\" \"b\"]";
    let packed = pack(&in_world(mix).unwrap(), RevolutionSolver::default()).unwrap();
    assert!(packed.material_features.has_bumps && packed.material_features.has_mixes);
}

#[test]
fn a_normal_map_is_linear_and_takes_precedence() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("n.png");
    file::write(&path, &Image::from_pixels(1, 1, vec![[0.5, 0.2, 1.0]]).unwrap(), &[]).unwrap();
    let path = path.display();
    let world = format!(
        "Texture \"h\" \"float\" \"checkerboard\"
         Material \"diffuse\" \"texture displacement\" \"h\" \"string normalmap\" \"{path}\" Shape \"disk\""
    );
    let (found, textures) = bump(&world);
    assert_eq!(found, Some(Bump::NormalMap(1)));
    let TextureKind::Image(image) = &textures[1].kind else { panic!("{:?}", textures[1]) };
    // The bytes of .5 and .2 in sRGB are 188 and 124.
    for (value, byte) in image.image.pixels[0].iter().zip([188.0, 124.0, 255.0]) {
        assert!((value - byte / 255.0).abs() < 1e-6, "{value} is not {byte} / 255");
    }
    assert_eq!((image.offset, image.factor, image.wrap), (-1.0, 2.0, Wrap::Repeat));
    let packed = pack(&in_world(&world).unwrap(), RevolutionSolver::default()).unwrap();
    assert!(packed.material_features.has_normal_maps && !packed.material_features.has_displacements);
}

#[test]
fn errors_of_bumps_are_at_their_parameters() {
    assert_refused(
        "Material \"diffuse\" \"texture displacement\" \"h\" Shape \"disk\"",
        "2:20: \"texture displacement\" is [\"h\"]; expected the name of a Texture of type \"float\"",
    );
    assert_refused(
        "Material \"diffuse\" \"string normalmap\" [\"a.png\" \"b.png\"] Shape \"disk\"",
        "2:20: \"string normalmap\"",
    );
    assert_refused("Material \"mix\" \"string normalmap\" \"x.png\"", "unknown parameter \"string normalmap\"");
    let missing =
        in_world("Material \"diffuse\" \"string normalmap\" \"no such file.png\" Shape \"disk\"").unwrap_err();
    let SceneError::Unreadable { location: Some(location), path, .. } = &missing else { panic!("{missing}") };
    assert_eq!((location.to_string().as_str(), path.ends_with("no such file.png")), ("t.pbrt:2:20", true));
}

#[test]
fn complaints_say_what_is_expected() {
    for (world, expected) in [
        (
            USE,
            "\"texture reflectance\" is [\"t\"]; expected the name of a Texture of type \"spectrum\"; known here: there is none",
        ),
        ("Texture \"a\" \"spectrum\" \"constant\" Material \"diffuse\" \"texture reflectance\" \"b\"", "known here: a"),
        (
            "Texture \"a\" \"float\" \"scale\" \"texture tex\" \"b\" Texture \"b\" \"float\" \"mix\" \"texture tex1\" \"a\"",
            "2:21: the texture \"a\" is made of itself",
        ),
        (
            "Texture \"a\" \"color\" \"constant\"",
            "unknown type \"color\" of Texture; expected \"float\" or \"spectrum\"",
        ),
        ("Texture \"a\" \"float\" \"marble\"", "unknown Texture \"marble\"; expected one of: \"constant\""),
        (
            "Texture \"a\" \"float\" \"constant\" Texture \"a\" \"float\" \"constant\"",
            "\"a\" of its type exists already",
        ),
        ("Texture \"a\" \"float\" \"constant\" \"rgb value\" [1 1 1]", "\"rgb value\" has the wrong type"),
        ("Texture \"a\" \"spectrum\" \"constant\" \"rgb value\" [1 2 1]", "expected channels from 0 to 1"),
        (
            "Texture \"a\" \"spectrum\" \"checkerboard\" \"integer dimension\" 4",
            "is 4; expected a whole number from 2 to 3",
        ),
        ("Texture \"a\" \"spectrum\" \"bilerp\" \"string mapping\" \"cubic\"", "expected one of \"uv\", \"planar\""),
        (
            "Texture \"a\" \"float\" \"directionmix\" \"vector3 dir\" [0 0 0]",
            "\"vector3 dir\" is 0; expected a direction",
        ),
        (
            "Texture \"a\" \"float\" \"fbm\" \"integer octaves\" 17",
            "2:27: \"integer octaves\" is 17; expected a whole number from 0 to 16",
        ),
        ("Texture \"a\" \"float\" \"wrinkled\" \"integer octaves\" -1", "2:32: \"integer octaves\" is -1; expected"),
        (
            "Texture \"a\" \"spectrum\" \"marble\" \"float roughness\" 1e9",
            "2:33: \"float roughness\" is 1000000000; expected a number from -100 to 100",
        ),
        (
            "Texture \"a\" \"spectrum\" \"marble\" \"float variation\" -1e9",
            "2:33: \"float variation\" is -1000000000; expected a number from -100000 to 100000",
        ),
        (
            "Texture \"a\" \"float\" \"windy\" \"integer octaves\" 3",
            "2:29: unknown parameter \"integer octaves\"; Texture \"windy\" accepts: no parameters",
        ),
        ("Texture \"a\" \"spectrum\" \"fbm\"", "2:24: unknown Texture \"fbm\"; expected one of: \"constant\""),
        (
            "Texture \"a\" \"float\" \"dots\" \"rgb inside\" [1 1 1]",
            "2:28: \"rgb inside\" has the wrong type; Texture \"dots\" accepts: \"float inside\", \"texture inside\"",
        ),
        (
            "Scale 1 0 1 Texture \"t\" \"spectrum\" \"marble\" Material \"diffuse\" \"texture reflectance\" \"t\" Identity Shape \"disk\"",
            "2:36: a texture in a space that cannot be inverted, by its transform, is not supported yet",
        ),
        ("Texture \"a\" \"float\" \"imagemap\"", "Texture \"imagemap\" has no \"string filename\""),
        ("Texture \"a\" \"float\" \"imagemap\" \"string filename\" \"absent.png\"", "cannot read absent.png"),
        ("Texture \"a\" \"float\" \"imagemap\" \"string filename\" \"x.gif\"", "supported are .exr, .hdr, .jpg"),
        (
            "Texture \"a\" \"float\" \"imagemap\" \"string filename\" \"x.png\" \"string encoding\" \"gamma\"",
            "the encoding \"gamma\" is unknown",
        ),
        (
            "Texture \"a\" \"float\" \"imagemap\" \"string filename\" \"x.png\" \"string wrap\" \"mirror\"",
            "expected one of \"repeat\", \"clamp\"",
        ),
        ("Material \"dielectric\" \"texture eta\" \"x\"", "\"texture eta\" has the wrong type"),
        ("Shape \"sphere\" \"float alpha\" 1.5", "\"float alpha\" is 1.5; expected a number from 0 to 1"),
        ("AreaLightSource \"diffuse\" \"string filename\" \"x.png\" \"rgb L\" [1 1 1]", "is given beside an L"),
    ] {
        assert_refused(world, expected);
    }
}

#[test]
fn images_are_read_once_and_as_their_use_asks() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    file::write(&path, &Image::from_pixels(1, 1, vec![[0.3, 0.6, 0.0]]).unwrap(), &[]).unwrap();
    let image = |name: &str, kind: &str, rest: &str| {
        format!("Texture \"{name}\" \"{kind}\" \"imagemap\" \"string filename\" \"{}\" {rest}\n", path.display())
    };
    let world = [
        image("a", "spectrum", ""),
        image("b", "spectrum", "\"bool invert\" true \"float scale\" 2"),
        image("c", "float", "\"string filter\" \"ewa\""),
    ];
    let scene = in_world(&world.concat()).unwrap();
    let images: Vec<&ImageTexture> = scene
        .textures
        .iter()
        .map(|texture| match &texture.kind {
            TextureKind::Image(image) => image,
            other => panic!("{other:?}"),
        })
        .collect();
    assert!(std::sync::Arc::ptr_eq(&images[0].image, &images[1].image));
    assert_eq!((images[1].offset, images[1].factor, images[1].range), (1.0, -2.0, [0.0, 1.0]));
    assert!((images[2].image.pixels[0][2] - 0.3).abs() < 1e-6);
    assert!(!scene.warnings.iter().any(|warning| warning.contains("filter")), "{:?}", scene.warnings);

    fs::write(&path, [0; 100]).unwrap();
    assert_refused(&world[0], "expected an OpenEXR image");
    file::write(&path, &Image::from_pixels(1, 1, vec![[f32::NAN, 0.6, 0.0]]).unwrap(), &[]).unwrap();
    assert_refused(&world[0], "expected an image whose pixels are all finite");
}

#[test]
fn what_is_not_there_is_left_out_unless_it_shines() {
    let count = |world: &str| in_world(world).unwrap().shapes.len();
    assert_eq!(count("Shape \"disk\" \"float alpha\" 0"), 1);
    assert_eq!(count("Shape \"disk\" \"float alpha\" .5"), 2);
    assert_eq!(count("AttributeBegin AreaLightSource \"diffuse\" Shape \"disk\" \"float alpha\" 0 AttributeEnd"), 2);
}

/// A texture that is used twice at every level would be packed 2^40 times.
#[test]
fn textures_of_too_many_textures_are_refused() {
    let first = "Texture \"0\" \"spectrum\" \"checkerboard\"\n".to_string();
    let chain = |levels: usize, other: &str| {
        let level = |i: usize| {
            let below = i - 1;
            let other = other.replace('#', &below.to_string());
            format!("Texture \"{i}\" \"spectrum\" \"mix\" \"texture tex1\" \"{below}\" {other}\n")
        };
        let world: String = (1..=levels).map(level).collect();
        let scene = in_world(&format!("{first}{world}Material \"diffuse\" \"texture reflectance\" \"{levels}\""));
        pack(&scene.unwrap(), RevolutionSolver::default()).map(|packed| packed.arrays.texture_nodes.len())
    };
    assert_eq!(chain(3, "").unwrap(), 10);
    assert!(chain(6, "\"texture tex2\" \"#\"").is_ok());
    for (levels, other) in [(40, "\"texture tex2\" \"#\""), (1000, "")] {
        let error = chain(levels, other).map(|_| ()).unwrap_err().to_string();
        assert!(error.contains("the texture is made of too many others"), "{error}");
    }
}

/// What a scene does not have is not in its kernels, nor in its arrays.
#[test]
fn noise_is_a_feature_of_the_scenes_that_have_it() {
    for (texture, has_noise, has_dots) in [
        ("\"float\" \"checkerboard\"", false, false),
        ("\"float\" \"dots\"", false, true),
        ("\"float\" \"fbm\"", true, false),
        ("\"float\" \"wrinkled\"", true, false),
        ("\"float\" \"windy\"", true, false),
        ("\"spectrum\" \"marble\"", true, false),
    ] {
        let used = if texture.starts_with("\"float") {
            "Material \"conductor\" \"texture roughness\" \"t\""
        } else {
            "Material \"diffuse\" \"texture reflectance\" \"t\""
        };
        // Textures that nothing uses are not packed.
        let others = "Texture \"u\" \"float\" \"windy\" Texture \"v\" \"float\" \"dots\"";
        let scene = in_world(&format!("{others} Texture \"t\" {texture} {used}")).unwrap();
        let packed = pack(&scene, RevolutionSolver::default()).unwrap();
        assert_eq!((packed.features.has_noise, packed.features.has_dots), (has_noise, has_dots), "{texture}");
        let table = if has_noise || has_dots { 256 } else { 0 };
        assert_eq!(packed.arrays.texture_texels.len(), table, "{texture}");
    }
}

#[test]
fn values_of_noise_have_the_defaults_of_pbrt() {
    let world = "Texture \"f\" \"float\" \"fbm\" Scale 2 2 2 Texture \"m\" \"spectrum\" \"marble\" \"float scale\" 3
        Texture \"d\" \"spectrum\" \"dots\"";
    let textures = in_world(world).unwrap().textures;
    let usual = Octaves { count: 8, roughness: 0.5 };
    let TextureKind::Fbm { octaves, .. } = textures[0].kind else { panic!("{:?}", textures[0]) };
    assert_eq!(octaves, usual);
    let TextureKind::Marble { mapping: Mapping::Space(from_world), octaves, variation } = textures[1].kind else {
        panic!("{:?}", textures[1]);
    };
    assert_eq!((octaves, variation), (usual, 0.2));
    assert_eq!(from_world.transform_point3(DVec3::new(2.0, 4.0, 6.0)), DVec3::new(3.0, 6.0, 9.0));
    // As in pbrt-v4, discs have the value of "outside".
    let TextureKind::Dots { textures: inputs, .. } = &textures[2].kind else { panic!("{:?}", textures[2]) };
    assert_eq!(inputs, &[Input::Constant(Rgb::ZERO), Input::Constant(Rgb::ONE)]);
}
