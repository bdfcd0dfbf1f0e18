//! The warning about light that goblet cannot find: eye paths continue from rough surfaces, where no photon
//! is gathered, and no ray meets a point light. So the light of such lamps is missing on rough surfaces if
//! it arrives by way of smooth glass, a mirror or a smooth coat.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use glam::DVec3;

use crate::scene::model::material::Lobes;
use crate::scene::model::{AreaLight, Geometry, Input, Light, Material, Scene, Shape};

/// Maximum number of names that the warning lists per kind.
const NAMED: usize = 3;
/// Number of segments of the shortest such path: from a lamp to a smooth surface, to a rough surface, to
/// the eye.
const LEAST_DEPTH: u32 = 3;

/// Returns the warning, or `None` if the scene has no such paths. `names` maps indices of materials to
/// their names.
pub(in crate::scene) fn warning(scene: &Scene, names: &BTreeMap<usize, Arc<str>>) -> Option<String> {
    let lamps = lamps(scene);
    if lamps.is_empty() || scene.integrator.max_depth < LEAST_DEPTH {
        return None;
    }
    let (smooth, rough) = (Surfaces::of(scene, |lobes| lobes.smooth), Surfaces::of(scene, |lobes| lobes.rough));
    let is_possible = smooth
        .shapes
        .iter()
        .any(|from| rough.shapes.iter().any(|to| from != to || lights_itself(&scene.shapes[*from], scene)));
    is_possible.then(|| {
        format!(
            "light of {} that comes by way of {} is missing on {}: no ray from a rough surface meets such a light. \
             A small lamp with a surface, as a sphere with an AreaLightSource, is met",
            list(&lamps),
            smooth.list(scene, names),
            rough.list(scene, names),
        )
    })
}

/// Returns descriptions of the lights that no ray meets.
fn lamps(scene: &Scene) -> Vec<String> {
    let mut lamps = Vec::new();
    for light in &scene.lights {
        lamps.push(match (light, light.position()) {
            (_, Some(p)) => format!("the {} light at {} {} {}", light.kind(), p.x, p.y, p.z),
            (Light::Distant { direction, .. }, _) => {
                // Adding 0 removes the sign of a component that rounds to -0.
                let d = (*direction * 1e3).round() / 1e3 + 0.0;
                format!("the distant light along {} {} {}", d.x, d.y, d.z)
            }
            _ => continue,
        });
    }
    let invisible = scene.shapes.iter().filter(|shape| shape.emission.is_some() && !is_there(shape));
    lamps.extend(invisible.map(|shape| format!("the area light of alpha 0 at {}", shape.location)));
    lamps
}

fn is_there(shape: &Shape) -> bool {
    shape.alpha != Input::Constant(0.0)
}

/// Shapes with lobes of one kind, and the materials that have these lobes.
struct Surfaces {
    shapes: Vec<usize>,
    /// Index of each material, with the index of its first shape.
    materials: BTreeMap<usize, usize>,
}

impl Surfaces {
    fn of(scene: &Scene, has: impl Fn(Lobes) -> bool) -> Self {
        let mut surfaces = Self { shapes: Vec::new(), materials: BTreeMap::new() };
        for (index, shape) in scene.shapes.iter().enumerate().filter(|(_, shape)| is_there(shape)) {
            let parts = parts(scene, shape.material).into_iter().filter(|part| has(scene.materials[*part].lobes()));
            let mut is_one = false;
            for part in parts {
                surfaces.materials.entry(part).or_insert(index);
                is_one = true;
            }
            surfaces.shapes.extend(is_one.then_some(index));
        }
        surfaces
    }

    fn list(&self, scene: &Scene, names: &BTreeMap<usize, Arc<str>>) -> String {
        let name = |(material, shape): (&usize, &usize)| {
            let kind = scene.materials[*material].kind();
            match names.get(material) {
                Some(name) => format!("{kind} \"{name}\""),
                None => format!("the {kind} of the shape at {}", scene.shapes[*shape].location),
            }
        };
        list(&self.materials.iter().map(name).collect::<Vec<_>>())
    }
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

/// Returns up to [`NAMED`] of the names, and the number of the others.
fn list(names: &[String]) -> String {
    let more = names.len().saturating_sub(NAMED);
    let named = names[..names.len() - more].join(", ");
    if more == 0 { named } else { format!("{named} and {more} more") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::film::Image;

    /// Returns the warning about missing light of a scene, if any.
    fn said(world: &str) -> Option<String> {
        said_at_depth(5, world)
    }

    fn said_at_depth(depth: u32, world: &str) -> Option<String> {
        let text =
            format!("Integrator \"sppm\" \"integer maxdepth\" {depth}\nCamera \"perspective\"\nWorldBegin\n{world}");
        let warnings = Scene::parse(&text, "t.pbrt", "").unwrap().warnings;
        assert!(warnings.len() <= 1, "{warnings:?}");
        warnings.into_iter().next()
    }

    fn lamps(image: &str) -> [(&'static str, String); 6] {
        [
            ("the point light at 0.5 1.5 0", "LightSource \"point\" \"point3 from\" [.5 1.5 0]".to_owned()),
            ("the spot light at 1 2 3", "LightSource \"spot\" \"point3 from\" [1 2 3]".to_owned()),
            ("the distant light along 0 0 1", "LightSource \"distant\"".to_owned()),
            ("the goniometric light at 0 0 0", format!("LightSource \"goniometric\" \"string filename\" \"{image}\"")),
            ("the projection light at 0 0 0", format!("LightSource \"projection\" \"string filename\" \"{image}\"")),
            (
                "the area light of alpha 0 at t.pbrt:4:",
                "AttributeBegin AreaLightSource \"diffuse\" Shape \"sphere\" \"float alpha\" 0 AttributeEnd".to_owned(),
            ),
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
    fn every_lamp_that_no_ray_meets_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("white.exr");
        crate::image::file::write(&file, &Image::from_pixels(2, 2, vec![[1.0; 3]; 4]).unwrap(), &[]).unwrap();
        for (name, lamp) in lamps(&file.display().to_string()) {
            let warning = said(&format!("{lamp}\n{}", two(SMOOTH[0], ROUGH[0]))).unwrap_or_default();
            assert!(warning.starts_with(&format!("light of {name}")), "{lamp}: {warning}");
        }
        for lamp in
            ["LightSource \"infinite\"", "AttributeBegin AreaLightSource \"diffuse\" Shape \"sphere\" AttributeEnd"]
        {
            assert_eq!(said(&format!("{lamp}\n{}", two(SMOOTH[0], ROUGH[0]))), None, "rays meet {lamp}");
        }
    }

    #[test]
    fn every_pair_of_smooth_and_rough_surfaces_is_named_and_no_other() {
        for (smooth, rough) in SMOOTH.iter().flat_map(|smooth| ROUGH.map(|rough| (smooth, rough))) {
            let warning = said(&format!("{POINT}{}", two(smooth, rough))).unwrap_or_default();
            for (material, line) in [(*smooth, 6), (rough, 8)] {
                let kind = material.split('"').nth(1).unwrap();
                let name = format!("the {kind} of the shape at t.pbrt:{line}:");
                assert!(warning.contains(&name), "{smooth}, {rough}: no {name} in {warning}");
            }
        }
        let others = |of: &[&'static str]| -> Vec<&str> { of.iter().chain(&NEITHER).copied().collect() };
        // A coated metal with a rough coat and a smooth metal is of both kinds.
        let smooth = others(&SMOOTH[..6]);
        for (a, b) in smooth.iter().flat_map(|a| smooth.iter().map(move |b| (*a, *b))) {
            assert_eq!(said(&format!("{POINT}{}", two(a, b))), None, "{a}, {b}");
        }
        let rough = others(&ROUGH);
        for (a, b) in rough.iter().flat_map(|a| rough.iter().map(move |b| (*a, *b))) {
            assert_eq!(said(&format!("{POINT}{}", two(a, b))), None, "{a}, {b}");
        }
    }

    #[test]
    fn it_is_not_said_where_it_cannot_be() {
        let world = format!("{POINT}{}", two(SMOOTH[0], ROUGH[0]));
        assert!(said_at_depth(3, &world).is_some() && said_at_depth(2, &world).is_none());
        // The light of a plane, or of a sphere lit from outside, cannot reach it again.
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
            assert_eq!(said(&format!("{POINT}{both}{shape}\n{WALL}")).is_some(), expected, "{shape}");
        }
    }

    #[test]
    fn named_materials_are_called_by_their_names_and_the_parts_of_a_mix_by_theirs() {
        let named = |name: &str, kind: &str| format!("MakeNamedMaterial \"{name}\" \"string type\" {kind}\n");
        let materials = named("bulb", SMOOTH[0]) + &named("steel", ROUGH[0]) + &named("wall", "\"diffuse\"");
        let mix = "Material \"mix\" \"string materials\" [\"wall\" \"steel\"]";
        let world =
            |mix: &str| format!("{POINT}{materials}NamedMaterial \"bulb\" Shape \"sphere\"\n{mix} Shape \"disk\"");
        let warning = said(&world(mix)).unwrap_or_default();
        assert!(warning.contains("dielectric \"bulb\" is missing on conductor \"steel\""), "{warning}");
        assert_eq!(said(&world(&format!("{mix} \"float amount\" 0"))), None, "all of it is wall");
    }

    #[test]
    fn a_few_are_named_and_the_others_counted() {
        let lamps = POINT.repeat(9);
        let panes = "Material \"dielectric\" Shape \"disk\"\n".repeat(4);
        let warning = said(&format!("{lamps}{panes}Material {} Shape \"sphere\"", ROUGH[0])).unwrap_or_default();
        assert!(warning.contains(" and 6 more that comes by way of "), "{warning}");
        assert!(warning.contains(" and 1 more is missing on the conductor of"), "{warning}");
    }
}
