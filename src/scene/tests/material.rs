//! Tests of materials that the parser makes.

use crate::scene::*;

fn materials(text: &str) -> Result<Vec<Material>, String> {
    let text = format!("WorldBegin LightSource \"point\"\n{text} Shape \"sphere\"");
    Scene::parse(&text, "t", "").map(|scene| scene.materials).map_err(|error| error.to_string())
}

fn last(text: &str) -> Material {
    materials(text).expect("a scene").pop().expect("a material")
}

fn rough(u: f64, v: f64, remap: bool) -> Roughness {
    Roughness { u: Input::Constant(u), v: Input::Constant(v), remap }
}

#[test]
fn roughness_is_of_both_directions_unless_they_have_their_own() {
    let of = |params: &str| match last(&format!("Material \"dielectric\" {params}")) {
        Material::Dielectric { roughness, .. } => roughness,
        other => panic!("{other:?}"),
    };
    assert_eq!(of(""), rough(0.0, 0.0, true));
    assert_eq!(of("\"float roughness\" .3"), rough(0.3, 0.3, true));
    assert_eq!(of("\"float roughness\" .3 \"float vroughness\" .1"), rough(0.3, 0.1, true));
    assert_eq!(of("\"float uroughness\" .3 \"bool remaproughness\" false"), rough(0.3, 0.0, false));
    // Without a difference of index, microfacets have no effect.
    assert_eq!(of("\"float eta\" 1 \"float roughness\" .3"), Roughness::SMOOTH);
}

#[test]
fn coats_have_the_defaults_of_pbrt() {
    let Material::CoatedDiffuse { reflectance, coat } = last("Material \"coateddiffuse\"") else {
        panic!("not coated");
    };
    assert_eq!(reflectance, Input::Constant(Rgb::splat(0.5)));
    assert_eq!((coat.eta, coat.thickness, coat.absorbed), (1.5.into(), Input::Constant(0.01), 1.0));
    let text = "Material \"coatedconductor\" \"rgb reflectance\" .5 .5 .5";
    assert!(materials(text).is_err(), "three numbers need brackets");
    let text = "Material \"coatedconductor\" \"rgb conductor.eta\" [3 3 3] \"rgb conductor.k\" [6 6 6]
        \"float conductor.roughness\" .2 \"float interface.roughness\" .1 \"float interface.eta\" 1.2";
    let Material::CoatedConductor { metal: Metal::Index { eta, k }, roughness, coat } = last(text) else {
        panic!("not coated");
    };
    // A metal under a coat is seen from inside of the coat.
    assert!((eta - 2.5).abs().max_element() < 1e-12 && (k - 5.0).abs().max_element() < 1e-12);
    assert_eq!((roughness.u, coat.roughness.u), (Input::Constant(0.2), Input::Constant(0.1)));
}

#[test]
fn mixes_find_their_parts_wherever_they_are_made() {
    let parts = "MakeNamedMaterial \"a\" \"string type\" \"diffuse\" \
        MakeNamedMaterial \"b\" \"string type\" \"conductor\" ";
    let mix = "Material \"mix\" \"string materials\" [\"a\" \"b\"] \"float amount\" .25 ";
    for text in [format!("{parts}{mix}"), format!("{mix}{parts}")] {
        let all = materials(&text).expect("a scene");
        assert_eq!(all[2], Material::Mix { materials: [0, 1], amount: Input::Constant(0.25) }, "{text}");
    }
}

#[test]
fn shapes_of_no_material_are_left_out() {
    for none in ["interface", "", "none"] {
        let named = format!("MakeNamedMaterial \"x\" \"string type\" \"{none}\" NamedMaterial \"x\"");
        for material in [format!("Material \"{none}\""), named] {
            let text = format!("WorldBegin LightSource \"point\" Shape \"sphere\" {material} Shape \"disk\"");
            let scene = Scene::parse(&text, "t", "").expect("a scene");
            assert_eq!(scene.shapes.len(), 1, "{material}");
        }
    }
}

#[test]
fn bad_materials_say_why() {
    let named = |kind: &str, params: &str| format!("MakeNamedMaterial \"a\" \"string type\" \"{kind}\" {params} ");
    for (text, expected) in [
        ("Material \"mix\"".to_string(), "has no \"string materials\"; expected two names"),
        ("Material \"mix\" \"string materials\" [\"a\"]".to_string(), "expected two names of materials"),
        ("Material \"mix\" \"string materials\" [\"a\" \"b\"]".to_string(), "unknown material \"a\""),
        (
            named("diffuse", "") + "Material \"mix\" \"string materials\" [\"a\" \"a\"] \"float amount\" 2",
            "expected a number from 0 to 1",
        ),
        (named("mix", "\"string materials\" [\"a\" \"a\"]") + "NamedMaterial \"a\"", "this mix is of itself"),
        (
            named("interface", "") + "Material \"mix\" \"string materials\" [\"a\" \"a\"]",
            "a mix with \"interface\" is not supported",
        ),
        ("Material \"conductor\" \"float roughness\" -1".to_string(), "expected 0 or a number above it"),
        ("Material \"thindielectric\" \"float eta\" 0".to_string(), "expected an index of refraction"),
        ("Material \"coateddiffuse\" \"float thickness\" -1".to_string(), "expected 0 or a number above it"),
        ("Material \"coateddiffuse\" \"float g\" 1.5".to_string(), "expected a number from -1 to 1"),
        ("Material \"coateddiffuse\" \"rgb albedo\" [0 2 0]".to_string(), "expected channels from 0 to 1"),
        ("Material \"hair\"".to_string(), "is not supported yet"),
        ("Material \"measured\"".to_string(), "has no \"string filename\"; expected the name of a .bsdf file"),
    ] {
        let error = materials(&text).expect_err("an error");
        assert!(error.contains(expected), "{text}: {error}");
    }
}
