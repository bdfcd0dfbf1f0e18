//! Detection of light on rough surfaces that eye paths cannot find. A ray cannot hit a point light, and next-event
//! estimation connects a surface with it only in a straight line. If the light of a point light reaches a rough surface
//! through smooth glass or by a mirror or a smooth coat, only photons find it. In such scenes, and only there, photons are
//! recorded on rough surfaces (`shaders/include/lookup/rough.glsl`).

use std::collections::BTreeSet;

use glam::DVec3;

use crate::scene::model::material::Lobes;
use crate::scene::model::{AreaLight, Geometry, Input, Light, Material, Scene, Shape};

impl Scene {
    /// Returns true if light that no ray meets may arrive at a rough surface after smooth ones only. The maximum depth
    /// of paths is not asked, since an option may change it.
    pub fn has_unmet_light_on_rough_surfaces(&self) -> bool {
        if !has_unmet_lights(self) {
            return false;
        }
        let (smooth, rough) = (surfaces(self, |lobes| lobes.smooth), surfaces(self, |lobes| lobes.rough));
        let reaches_itself = |from: &usize| lights_itself(&self.shapes[*from], self);
        smooth.iter().any(|from| rough.iter().any(|to| from != to || reaches_itself(from)))
    }
}

/// Returns true if there is a light that no ray meets.
fn has_unmet_lights(scene: &Scene) -> bool {
    let is_unmet = |light: &Light| light.position().is_some() || matches!(light, Light::Distant { .. });
    scene.lights.iter().any(is_unmet) || scene.shapes.iter().any(|shape| shape.emission.is_some() && !is_there(shape))
}

fn is_there(shape: &Shape) -> bool {
    shape.alpha != Input::Constant(0.0)
}

/// Returns the indices of the shapes with lobes of one kind.
fn surfaces(scene: &Scene, has: impl Fn(Lobes) -> bool) -> Vec<usize> {
    let has_one =
        |shape: &Shape| parts(scene, shape.material).into_iter().any(|part| has(scene.materials[part].lobes()));
    let shapes = scene.shapes.iter().enumerate();
    shapes.filter(|(_, shape)| is_there(shape) && has_one(shape)).map(|(index, _)| index).collect()
}

/// Returns the indices of the materials that a material consists of: itself, or those that a mix chooses
/// with a probability above 0.
fn parts(scene: &Scene, material: usize) -> BTreeSet<usize> {
    let Material::Mix { materials: [first, second], amount } = &scene.materials[material] else {
        return [material].into();
    };
    let mut found = BTreeSet::new();
    if *amount != Input::Constant(1.0) {
        found.extend(parts(scene, *first));
    }
    if *amount != Input::Constant(0.0) {
        found.extend(parts(scene, *second));
    }
    found
}

/// Returns true if light that leaves a surface may reach the surface again: it is neither flat nor a whole
/// sphere with all lamps outside.
fn lights_itself(shape: &Shape, scene: &Scene) -> bool {
    if shape.object.is_some() {
        return true;
    }
    match &shape.geometry {
        Geometry::Sphere { radius, z_min, z_max, phi_max } => {
            let is_whole = *z_min <= -radius && *z_max >= *radius && *phi_max >= std::f64::consts::TAU;
            let is_outside = |p: &DVec3| shape.world_from_object.inverse().transform_point3(*p).length() > *radius;
            let invisible = |shape: &Shape| matches!(shape.emission, Some(AreaLight { .. })) && !is_there(shape);
            let all_outside = scene.lights.iter().filter_map(Light::position).all(|p| is_outside(&p));
            !is_whole || !all_outside || scene.shapes.iter().any(invisible)
        }
        _ => !shape.is_plane(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::film::Image;

    fn is_gathered(world: &str) -> bool {
        let text = format!("Camera \"perspective\"\nWorldBegin\n{world}");
        Scene::parse(&text, "t.pbrt", "").unwrap().has_unmet_light_on_rough_surfaces()
    }

    fn lamps(image: &str) -> [String; 6] {
        [
            "LightSource \"point\" \"point3 from\" [.5 1.5 0]".to_owned(),
            "LightSource \"spot\" \"point3 from\" [1 2 3]".to_owned(),
            "LightSource \"distant\"".to_owned(),
            format!("LightSource \"goniometric\" \"string filename\" \"{image}\""),
            format!("LightSource \"projection\" \"string filename\" \"{image}\""),
            "AttributeBegin AreaLightSource \"diffuse\" Shape \"sphere\" \"float alpha\" 0 AttributeEnd".to_owned(),
        ]
    }

    const POINT: &str = "LightSource \"point\" \"point3 from\" [0 9 0]\n";
    const SMOOTH: [&str; 7] = [
        "\"dielectric\"",
        "\"dielectric\" \"float eta\" 1 \"float roughness\" .3",
        "\"thindielectric\"",
        "\"conductor\"",
        "\"conductor\" \"float roughness\" 9e-7",
        "\"coateddiffuse\"",
        "\"coatedconductor\" \"float interface.roughness\" .1 \"float conductor.roughness\" 0",
    ];
    const ROUGH: [&str; 5] = [
        "\"conductor\" \"float roughness\" .3",
        "\"conductor\" \"float vroughness\" .3",
        "\"dielectric\" \"float roughness\" .1",
        "\"coateddiffuse\" \"float roughness\" .2",
        "\"coatedconductor\" \"float interface.roughness\" .1 \"float conductor.roughness\" .1",
    ];
    const NEITHER: [&str; 4] =
        ["\"diffuse\"", "\"diffusetransmission\"", "\"interface\"", "\"coateddiffuse\" \"float eta\" 1"];

    const WALL: &str = "Material \"diffuse\" Shape \"disk\" \"float height\" -5\n";

    fn two(first: &str, second: &str) -> String {
        format!("Material {first}\nShape \"sphere\"\nMaterial {second}\nTranslate 3 0 0 Shape \"disk\"\n{WALL}")
    }

    #[test]
    fn it_is_light_of_lamps_that_no_ray_meets() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("white.exr");
        crate::image::file::write(&file, &Image::from_pixels(2, 2, vec![[1.0; 3]; 4]).unwrap(), &[]).unwrap();
        for lamp in lamps(&file.display().to_string()) {
            assert!(is_gathered(&format!("{lamp}\n{}", two(SMOOTH[0], ROUGH[0]))), "{lamp}");
        }
        for lamp in
            ["LightSource \"infinite\"", "AttributeBegin AreaLightSource \"diffuse\" Shape \"sphere\" AttributeEnd"]
        {
            assert!(!is_gathered(&format!("{lamp}\n{}", two(SMOOTH[0], ROUGH[0]))), "rays meet {lamp}");
        }
    }

    #[test]
    fn it_takes_a_smooth_and_a_rough_surface() {
        for (smooth, rough) in SMOOTH.iter().flat_map(|smooth| ROUGH.map(|rough| (smooth, rough))) {
            assert!(is_gathered(&format!("{POINT}{}", two(smooth, rough))), "{smooth}, {rough}");
        }
        let others = |of: &[&'static str]| -> Vec<&str> { of.iter().chain(&NEITHER).copied().collect() };
        // A coated metal with a rough coat and a smooth metal is of both kinds.
        let smooth = others(&SMOOTH[..6]);
        for (a, b) in smooth.iter().flat_map(|a| smooth.iter().map(move |b| (*a, *b))) {
            assert!(!is_gathered(&format!("{POINT}{}", two(a, b))), "{a}, {b}");
        }
        let rough = others(&ROUGH);
        for (a, b) in rough.iter().flat_map(|a| rough.iter().map(move |b| (*a, *b))) {
            assert!(!is_gathered(&format!("{POINT}{}", two(a, b))), "{a}, {b}");
        }
    }

    #[test]
    fn a_surface_of_both_kinds_lights_itself_unless_it_is_plane_or_round() {
        let both = "Material \"coatedconductor\" \"float conductor.roughness\" .3\n";
        let floor = "Shape \"bilinearmesh\" \"point3 P\" [-3 0 -3  3 0 -3  -3 0 3  3 0 3]";
        for (shape, expected) in [
            ("Shape \"disk\"", false),
            (floor, false),
            ("Shape \"sphere\"", false),
            ("Shape \"sphere\" \"float radius\" 20", true),
            ("Shape \"sphere\" \"float zmax\" 0", true),
            ("Shape \"cylinder\"", true),
            ("Shape \"disk\" Shape \"sphere\"", true),
            ("Shape \"sphere\" \"float alpha\" 0", false),
        ] {
            assert_eq!(is_gathered(&format!("{POINT}{both}{shape}\n{WALL}")), expected, "{shape}");
        }
    }

    #[test]
    fn a_mix_is_what_it_chooses() {
        let named = |name: &str, kind: &str| format!("MakeNamedMaterial \"{name}\" \"string type\" {kind}\n");
        let materials = named("bulb", SMOOTH[0]) + &named("steel", ROUGH[0]) + &named("wall", "\"diffuse\"");
        let mix = "Material \"mix\" \"string materials\" [\"wall\" \"steel\"]";
        let world =
            |mix: &str| format!("{POINT}{materials}NamedMaterial \"bulb\" Shape \"sphere\"\n{mix} Shape \"disk\"");
        assert!(is_gathered(&world(mix)));
        assert!(!is_gathered(&world(&format!("{mix} \"float amount\" 0"))), "all of it is wall");
    }
}
