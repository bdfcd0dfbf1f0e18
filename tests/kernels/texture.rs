//! Textures against an evaluation of the scene's own textures in f64, and what they vary by:
//! texture coordinates and tangents of surfaces.

use std::f64::consts::{PI, TAU};
use std::path::Path;

use glam::{DAffine3, DVec2, DVec3};
use goblet::image::file;
use goblet::image::film::Image;
use goblet::scene::{ImageTexture, Input, Mapping, Material, Rgb, Scene, Texture, TextureKind, Wrap};

use crate::fixture::{EPS, Fixture, Rng, double, single};
use crate::generated::{
    KIND_SHIFT, MapSurfaces, MappedPoint, MappedRay, REVOLUTION, RunTextures, SceneFeatures, Specialization, TRIANGLE,
    TexturedPoint,
};
use crate::support::noise;
use crate::world::World;

const COUNT: usize = 20_000;

/// A point of a surface, as the f64 twin sees it.
struct Place {
    world: DVec3,
    normal: DVec3,
    uv: DVec2,
}

/// A texture's value; none where rounding may take another one.
fn value(textures: &[Texture], input: Input<Rgb>, place: &Place) -> Option<Rgb> {
    let number = |input: Input<f64>| match input {
        Input::Constant(value) => Some(value),
        Input::Texture(index) => value(textures, Input::Texture(index), place).map(|value| value.x),
    };
    let both =
        |inputs: &[Input<Rgb>; 2]| Some((value(textures, inputs[0], place)?, value(textures, inputs[1], place)?));
    let index = match input {
        Input::Constant(value) => return Some(value),
        Input::Texture(index) => index,
    };
    Some(match &textures[index].kind {
        TextureKind::Image(image) => image_value(image, coordinates(&image.mapping, place).truncate())?,
        TextureKind::Bilerp { mapping, corners: [v00, v10, v01, v11] } => {
            let at = coordinates(mapping, place);
            v00.lerp(*v10, at.x).lerp(v01.lerp(*v11, at.x), at.y)
        }
        TextureKind::Checkerboard { mapping, textures: inputs } => {
            let at = coordinates(mapping, place);
            let flat = !matches!(mapping, Mapping::Space(transform) if transform.matrix3.row(2) != DVec3::ZERO);
            let near_edge = |x: f64| (x - x.round()).abs() < 1e-4;
            if near_edge(at.x) || near_edge(at.y) || (!flat && near_edge(at.z)) {
                return None;
            }
            let cell = at.floor();
            let (even, odd) = both(inputs)?;
            if (cell.x + cell.y + if flat { 0.0 } else { cell.z }).rem_euclid(2.0) == 0.0 { even } else { odd }
        }
        TextureKind::DirectionMix { direction, textures: inputs } => {
            let (along, across) = both(inputs)?;
            across.lerp(along, direction.dot(place.normal).abs())
        }
        TextureKind::Mix { textures: inputs, amount } => {
            let (a, b) = both(inputs)?;
            a.lerp(b, number(*amount)?)
        }
        TextureKind::Scale { texture, factor } => value(textures, *texture, place)? * number(*factor)?,
        TextureKind::Dots { mapping, textures: inputs } => {
            let (inside, outside) = both(inputs)?;
            if noise::is_in_dot(coordinates(mapping, place).truncate())? { inside } else { outside }
        }
        TextureKind::Fbm { mapping, octaves } => {
            Rgb::splat(noise::fbm(&noise::octaves(coordinates(mapping, place), octaves.count), octaves.roughness))
        }
        TextureKind::Wrinkled { mapping, octaves } => {
            Rgb::splat(noise::wrinkled(&noise::octaves(coordinates(mapping, place), octaves.count), octaves.roughness))
        }
        TextureKind::Windy { mapping } => Rgb::splat(noise::windy(coordinates(mapping, place))),
        TextureKind::Marble { mapping, octaves, variation } => {
            let at = coordinates(mapping, place);
            let phase = at.y + variation * noise::fbm(&noise::octaves(at, octaves.count), octaves.roughness);
            let on_curves = noise::place_on_marble(phase);
            // The colours jump where a curve begins.
            let is_sharp = (on_curves - on_curves.round()).abs() < 5e-3 && on_curves.round() % 6.0 != 0.0;
            (!is_sharp).then(|| noise::marble(on_curves))?
        }
    })
}

fn coordinates(mapping: &Mapping, place: &Place) -> DVec3 {
    match mapping {
        Mapping::Surface(transform) => transform.transform_point3(place.uv.extend(0.0)),
        Mapping::Space(transform) => transform.transform_point3(place.world),
        Mapping::Spherical(transform) => {
            let p = transform.transform_point3(place.world).normalize();
            DVec3::new(p.z.acos() / PI, p.truncate().to_angle().rem_euclid(TAU) / TAU, 0.0)
        }
        Mapping::Cylindrical(transform) => {
            let p = transform.transform_point3(place.world);
            DVec3::new((PI + p.truncate().to_angle()) / TAU, p.z, 0.0)
        }
    }
}

/// pbrt's lookup: t runs up, rows run down, pixel centres are at halves.
fn image_value(texture: &ImageTexture, at: DVec2) -> Option<Rgb> {
    let image = &texture.image;
    let size = [i64::from(image.width), i64::from(image.height)];
    let pixel = |x: i64, y: i64| {
        let wrapped = |i: i64, size: i64| match texture.wrap {
            Wrap::Repeat => Some(i.rem_euclid(size)),
            Wrap::Clamp => Some(i.clamp(0, size - 1)),
            Wrap::Black => (0..size).contains(&i).then_some(i),
        };
        match (wrapped(x, size[0]), wrapped(y, size[1])) {
            (Some(x), Some(y)) => Rgb::from(image.pixels[(y * size[0] + x) as usize].map(f64::from)),
            _ => Rgb::ZERO,
        }
    };
    let place = DVec2::new(at.x, 1.0 - at.y) * DVec2::new(size[0] as f64, size[1] as f64) - 0.5;
    let (x, y) = (place.x.floor() as i64, place.y.floor() as i64);
    let mut weight = place - place.floor();
    if texture.nearest {
        if (weight - 0.5).abs().min_element() < 1e-3 || (weight - weight.round()).abs().min_element() < 1e-9 {
            return None;
        }
        weight = weight.round();
    }
    let upper = pixel(x, y).lerp(pixel(x + 1, y), weight.x);
    let lower = pixel(x, y + 1).lerp(pixel(x + 1, y + 1), weight.x);
    let value = texture.offset + texture.factor * upper.lerp(lower, weight.y);
    let [least, most] = texture.range.map(Rgb::splat);
    Some(value.clamp(least, most))
}

/// Random pixels, of an odd width, and the path of their file.
fn write_image(folder: &Path, name: &str, most: f64) -> String {
    let mut rng = Rng(11);
    let pixels = (0..7 * 5).map(|_| [0; 3].map(|_| rng.range(0.0, most) as f32)).collect();
    let path = folder.join(name);
    file::write(&path, &Image::from_pixels(7, 5, pixels).unwrap(), &[]).unwrap();
    path.display().to_string()
}

/// Each reflectance of a scene of spheres with `textures`, at random points, against the twin.
fn check(textures: &str, names: &[&str]) {
    let spheres: String = names
        .iter()
        .map(|name| format!("Material \"diffuse\" \"texture reflectance\" \"{name}\" Shape \"sphere\"\n"))
        .collect();
    let text = format!("WorldBegin LightSource \"infinite\" {textures}\n{spheres}Translate 3 1 2 Shape \"sphere\"");
    let scene = Scene::parse(&text, "t.pbrt", "").unwrap();
    let (world, packed) = World::parse(&text);
    let world_from_render = packed.space.from_world().inverse();
    let mut rng = Rng(3);
    let mut points = Vec::new();
    let mut expected = Vec::new();
    for i in 0..COUNT {
        let chosen = i % names.len();
        let Material::Diffuse { reflectance } = scene.materials[chosen].clone() else { panic!("not diffuse") };
        let uv = DVec2::new(rng.range(-2.0, 3.0), rng.range(-2.0, 3.0)).as_vec2();
        let point = TexturedPoint {
            position: single(rng.cube(0.7)),
            first: world.materials[chosen].color_texture,
            normal: single(rng.direction()),
            pad0: 0.0,
            uv: uv.to_array(),
            pad1: [0.0; 2],
        };
        let place = Place {
            world: world_from_render.transform_point3(double(point.position)),
            normal: double(point.normal),
            uv: uv.as_dvec2(),
        };
        expected.push(value(&scene.textures, reflectance, &place));
        points.push(point);
    }
    let fixture = Fixture::new();
    let gpu = world.upload(&fixture);
    let (points, values) = (fixture.upload(&points), fixture.output::<[f32; 4]>(COUNT));
    let declared = Specialization::DECLARED;
    let features = SceneFeatures { has_noise: true, has_dots: true, ..declared.scene };
    let kernel = RunTextures { scene: gpu.bindings(), points: &points, values: &values };
    fixture.run_specialized(&kernel, &Specialization { scene: features, ..declared }, COUNT);
    let mut compared = 0;
    for (i, (found, expected)) in fixture.read(&values).iter().zip(&expected).enumerate() {
        let Some(expected) = expected else { continue };
        compared += 1;
        let off = (DVec3::new(found[0].into(), found[1].into(), found[2].into()) - expected).abs().max_element();
        // Half floats of the texels, and coordinates of a few units over a few texels.
        let bound = (2e-3_f64).max(1e-3 * expected.abs().max_element());
        assert!(off <= bound, "{}: {found:?} is not {expected}", names[i % names.len()]);
    }
    assert!(compared > COUNT * 9 / 10, "{compared}");
}

#[test]
fn images_are_looked_up_as_pbrt_does() {
    let folder = tempfile::tempdir().unwrap();
    let exr = write_image(folder.path(), "a.exr", 0.9);
    let png = write_image(folder.path(), "b.png", 0.9);
    let image = |name: &str, file: &str, rest: &str| {
        format!("Texture \"{name}\" \"spectrum\" \"imagemap\" \"string filename\" \"{file}\" {rest}\n")
    };
    let text = [
        image("repeat", &exr, ""),
        image("clamp", &exr, "\"string wrap\" \"clamp\" \"float uscale\" .7 \"float vdelta\" .2"),
        image("black", &png, "\"string wrap\" \"black\" \"float scale\" 1.5"),
        image("point", &exr, "\"string filter\" \"point\""),
        image("invert", &png, "\"bool invert\" true \"string encoding\" \"linear\" \"float scale\" 1.2"),
        image("gamma", &png, "\"string encoding\" \"gamma 2.2\" \"string mapping\" \"planar\" \"vector3 v1\" [1 .5 0]"),
    ];
    check(&text.concat(), &["repeat", "clamp", "black", "point", "invert", "gamma"]);
}

#[test]
fn patterns_and_mappings_agree_with_f64() {
    let text = r#"
        Texture "bilerp" "spectrum" "bilerp" "rgb v00" [.1 .2 .3] "rgb v10" [.9 .1 .4] "rgb v01" [0 1 0] "rgb v11" [1 1 .5]
        Texture "checks" "spectrum" "checkerboard" "float uscale" 3 "float vscale" 5 "rgb tex1" [.1 .2 .3] "rgb tex2" [.9 .8 .7]
        Rotate 30 1 2 3 Scale .3 .4 .5
        Texture "cubes" "spectrum" "checkerboard" "integer dimension" 3 "rgb tex1" [.1 .2 .3]
        Texture "planar" "spectrum" "checkerboard" "string mapping" "planar" "vector3 v1" [2 1 0] "vector3 v2" [0 1 1] "float udelta" .25
        Translate 1 0 .5
        Texture "ball" "spectrum" "bilerp" "string mapping" "spherical" "rgb v00" [.1 .2 .3] "rgb v10" [.9 .1 .4]
        Texture "can" "spectrum" "bilerp" "string mapping" "cylindrical" "rgb v00" [.1 .2 .3] "rgb v10" [.9 .1 .4]
        Texture "up" "spectrum" "directionmix" "vector3 dir" [1 2 0] "rgb tex1" [.1 .2 .3] "rgb tex2" [.9 .8 .7]
    "#;
    check(text, &["bilerp", "checks", "cubes", "planar", "ball", "can", "up"]);
}

#[test]
fn textures_of_noise_agree_with_f64() {
    let text = r#"
        Translate .1 -.2 .4 Scale .3 .4 .5 Rotate 30 1 2 3
        Texture "clouds" "float" "fbm" "integer octaves" 5 "float roughness" .6
        Texture "folds" "float" "wrinkled"
        Texture "waves" "float" "windy"
        Texture "holes" "float" "dots" "float uscale" 4 "float vscale" 3
        Texture "fbm" "spectrum" "scale" "rgb tex" [.5 1 .25] "texture scale" "clouds"
        Texture "wrinkled" "spectrum" "mix" "rgb tex1" [.1 .2 .3] "texture amount" "folds"
        Texture "windy" "spectrum" "scale" "texture scale" "waves"
        Texture "marble" "spectrum" "marble" "float scale" 3 "float variation" 2 "integer octaves" 4
        Texture "grid" "spectrum" "checkerboard" "rgb tex1" [.1 .2 .3]
        Texture "dots" "spectrum" "dots" "string mapping" "planar" "texture inside" "marble" "texture outside" "grid"
        Texture "both" "spectrum" "mix" "texture tex1" "dots" "texture tex2" "marble" "texture amount" "holes"
    "#;
    check(text, &["fbm", "wrinkled", "windy", "marble", "dots", "both"]);
}

#[test]
fn textures_nest() {
    let text = r#"
        Texture "where" "float" "checkerboard" "float uscale" 3 "float vscale" 5
        Texture "ramp" "float" "bilerp"
        Texture "how much" "float" "mix" "texture tex1" "where" "texture tex2" "ramp" "float amount" .3
        Texture "a" "spectrum" "bilerp" "rgb v00" [.1 .2 .3] "rgb v10" [.9 .1 .4] "rgb v01" [0 1 0] "rgb v11" [1 1 .5]
        Texture "b" "spectrum" "scale" "texture tex" "a" "texture scale" "ramp"
        Texture "c" "spectrum" "mix" "texture tex1" "a" "texture tex2" "b" "texture amount" "how much"
        Texture "d" "spectrum" "checkerboard" "texture tex1" "c" "texture tex2" "a"
        Texture "e" "spectrum" "directionmix" "texture tex1" "d" "rgb tex2" [.5 .2 .1]
    "#;
    check(text, &["a", "b", "c", "d", "e"]);
}

/// Packs a scene and sends rays to targets on its primitives.
fn map(text: &str, aim: impl Fn(&mut Rng, &World, &DAffine3) -> (u32, DVec3)) -> (Vec<MappedPoint>, World, DAffine3) {
    // A texture is in use, so that there are coordinates.
    let texture = "Texture \"t\" \"spectrum\" \"bilerp\" Material \"diffuse\" \"texture reflectance\" \"t\"";
    let (world, packed) = World::parse(&format!("WorldBegin LightSource \"infinite\" {texture}\n{text}"));
    let render_from_world = packed.space.from_world();
    let mut rng = Rng(5);
    let rays: Vec<MappedRay> = (0..COUNT)
        .map(|_| {
            let (primitive, target) = aim(&mut rng, &world, &render_from_world);
            let origin = target + rng.direction() * rng.range(0.2, 1.0);
            let direction = single((target - origin).normalize());
            MappedRay { origin: single(origin), primitive, direction, pad0: 0.0 }
        })
        .collect();
    let fixture = Fixture::new();
    let gpu = world.upload(&fixture);
    let (rays, points) = (fixture.upload(&rays), fixture.output(COUNT));
    fixture.run(&MapSurfaces { scene: gpu.bindings(), rays: &rays, points: &points }, COUNT);
    let points: Vec<MappedPoint> = fixture.read(&points);
    let found: Vec<_> = points.into_iter().filter(|point| point.found == 1).collect();
    assert!(found.len() > COUNT / 4, "{}", found.len());
    (found, world, render_from_world)
}

/// Along the tangent, u grows and v stays.
#[test]
fn triangles_have_the_coordinates_of_their_corners() {
    let cases = [
        ("\"point2 uv\" [.1 .2 2 .3 -.5 1]", [[0.1, 0.2], [2.0, 0.3], [-0.5, 1.0]]),
        ("", [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]),
    ];
    let corners = [DVec3::new(0.1, -0.2, 0.4), DVec3::new(1.0, 0.3, 0.0), DVec3::new(0.2, 0.9, -0.5)];
    for (given, uvs) in cases {
        for directives in ["", "ReverseOrientation", "Scale -1 2 1"] {
            let numbers: Vec<String> = corners.iter().flat_map(|p| p.to_array()).map(|x| x.to_string()).collect();
            let shape = format!("{directives} Shape \"trianglemesh\" \"point3 P\" [{}] {given}", numbers.join(" "));
            let stretch = if directives.starts_with("Scale") { DVec3::new(-1.0, 2.0, 1.0) } else { DVec3::ONE };
            let (points, _, render_from_world) = map(&shape, |rng, _, render| {
                let (u, v) = (rng.unit(), rng.unit());
                let (b1, b2) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
                let p = corners[0] + b1 * (corners[1] - corners[0]) + b2 * (corners[2] - corners[0]);
                (TRIANGLE << KIND_SHIFT, render.transform_point3(p * stretch))
            });
            let [p0, p1, p2] = corners.map(|p| render_from_world.transform_point3(p * stretch));
            let [t0, t1, t2] = uvs.map(DVec2::from);
            for point in points {
                // Barycentric coordinates by areas, in f64.
                let (p, n) = (double(point.position), (p1 - p0).cross(p2 - p0));
                let b1 = (p2 - p0).cross(p0 - p).dot(n) / n.length_squared();
                let b2 = (p1 - p0).cross(p - p0).dot(n) / n.length_squared();
                let uv = t0 + b1 * (t1 - t0) + b2 * (t2 - t0);
                let off = (DVec2::from(point.uv.map(f64::from)) - uv).abs().max_element();
                assert!(off < 1e-5, "{point:?} is at {uv}");
                // Solve tangent = a e1 + b e2: v must stay, u must grow.
                let tangent = double(point.tangent);
                let a = (p2 - p0).cross(tangent).dot(n) / -n.length_squared();
                let b = (p1 - p0).cross(tangent).dot(n) / n.length_squared();
                let change = a * (t1 - t0) + b * (t2 - t0);
                assert!(change.x > 0.0 && change.y.abs() < 1e-4 * change.x, "{point:?}: {change}");
            }
        }
    }
}

#[test]
fn degenerate_coordinates_leave_a_tangent_in_the_surface() {
    let shape = "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 1] \"point2 uv\" [1 1 1 1 1 1]";
    let (points, ..) = map(shape, |rng, _, render| {
        let p = DVec3::new(0.3, 0.2, 0.2) + 0.1 * rng.range(0.0, 1.0) * DVec3::X;
        (TRIANGLE << KIND_SHIFT, render.transform_point3(p))
    });
    for point in points {
        let (tangent, normal) = (double(point.tangent), double(point.normal));
        assert!(tangent.length() > 0.1 && tangent.dot(normal).abs() < 8.0 * EPS, "{point:?}");
    }
}

#[test]
fn spheres_and_disks_have_the_coordinates_of_pbrt() {
    let (z_min, z_max, phi_max) = (-0.5, 0.8, 300.0_f64.to_radians());
    let transform = "Rotate 20 1 2 3 Scale 1 .7 1.3 Translate .1 .2 .3";
    let object = |packed: &World, index: usize| crate::world::affine(packed.quadrics[index].render_from_object);
    let text = format!(
        "{transform} Shape \"sphere\" \"float radius\" 2 \"float zmin\" -1 \"float zmax\" 1.6 \"float phimax\" 300
         Shape \"sphere\" Shape \"disk\" \"float radius\" 2 \"float innerradius\" .5 \"float phimax\" 300"
    );
    let (points, world, _) = map(&text, |rng, world, _| {
        let index = rng.below(3);
        let (z, phi): (f64, f64) = (rng.range(-1.0, 1.0), rng.range(0.0, TAU));
        let r = if index == 2 { rng.unit() } else { (1.0 - z * z).sqrt() };
        let p = DVec3::new(r * phi.cos(), r * phi.sin(), if index == 2 { 0.0 } else { z });
        (world.quadrics[index].kind << KIND_SHIFT | index as u32, object(world, index).transform_point3(p))
    });
    let inverses: Vec<DAffine3> = (0..3).map(|index| object(&world, index).inverse()).collect();
    for point in points {
        // Which primitive was hit follows from where the point is.
        let fits = (0..3).any(|index| {
            let p = inverses[index].transform_point3(double(point.position));
            let (full, on) = match index {
                2 => (phi_max, p.z.abs() < 1e-5),
                0 => (phi_max, (p.length() - 1.0).abs() < 1e-5),
                _ => (TAU, (p.length() - 1.0).abs() < 1e-5),
            };
            let u = p.truncate().to_angle().rem_euclid(TAU) / full;
            let theta = |z: f64| z.acos();
            let v = match index {
                0 => (theta(p.normalize().z) - theta(z_min)) / (theta(z_max) - theta(z_min)),
                1 => 1.0 - theta(p.normalize().z) / PI,
                _ => (1.0 - p.truncate().length()) / 0.75,
            };
            let uv = DVec2::from(point.uv.map(f64::from));
            let across = (uv.x - u).abs();
            let around = inverses[index].transform_vector3(double(point.tangent)).normalize();
            let ahead = DVec3::new(-p.y, p.x, 0.0).normalize();
            on && across.min((across - TAU / full).abs()) < 1e-4
                && (uv.y - v).abs() < 1e-3
                && (p.truncate().length() < 1e-3 || around.dot(ahead) > 0.999)
        });
        assert!(fits, "{point:?}");
    }
}

#[test]
fn bodies_of_revolution_have_theirs_around_the_axis() {
    let text = "Shape \"revolution\" \"integer degree\" 1 \"point2 P\" [1 0 1 2]";
    let (points, ..) = map(text, |rng, world, render| {
        let (phi, z) = (rng.range(0.0, TAU), rng.range(0.0, 2.0));
        // A hit names one of the pieces that are on top of each other.
        let piece = (0.5 * z * world.revolution_pieces.len() as f64) as u32;
        (REVOLUTION << KIND_SHIFT | piece, render.transform_point3(DVec3::new(phi.cos(), phi.sin(), z)))
    });
    for point in points {
        let p = double(point.position);
        let u = p.truncate().to_angle().rem_euclid(TAU) / TAU;
        let off = (f64::from(point.uv[0]) - u).abs();
        assert!(off.min(1.0 - off) < 1e-5, "{point:?} is at {u}");
        let ahead = DVec3::new(-p.y, p.x, 0.0).normalize();
        assert!(double(point.tangent).normalize().dot(ahead) > 0.999, "{point:?}");
    }
}
