//! Bumps: bent shading normals against those of the raised surface in f64.

use std::f64::consts::{PI, TAU};
use std::fmt::Write;

use glam::{DAffine3, DMat2, DVec2, DVec3};
use goblet::image::film::Image;
use goblet::scene::{Geometry, Scene};

use crate::fixture::{Fixture, Rng, double, single};
use crate::generated::{
    BendNormals, BentPoint, BentRay, KIND_SHIFT, MaterialFeatures, NONE, REVOLUTION, Specialization, TRIANGLE,
};
use crate::support::{self, ImageFile};
use crate::world::World;

const COUNT: usize = 10_000;

/// A point of a surface and its unit normal in object space, by texture coordinates.
type Patch<'a> = &'a dyn Fn(DVec2) -> (DVec3, DVec3);

/// A height by texture coordinates and position.
type Height = dyn Fn(DVec2, DVec3) -> f64;

/// The first shape of a scene as the f64 twin sees it.
struct Twin<'a> {
    patch: Patch<'a>,
    world_from_object: DAffine3,
    /// Whether the normal is on the other side than the one of the patch.
    flipped: bool,
}

impl Twin<'_> {
    fn at(&self, uv: DVec2) -> (DVec3, DVec3) {
        let (p, n) = (self.patch)(uv);
        let normal = (self.world_from_object.matrix3.inverse().transpose() * n).normalize();
        (self.world_from_object.transform_point3(p), if self.flipped { -normal } else { normal })
    }

    /// The normal of the surface raised by `height`, on the side of the normal.
    fn raised(&self, uv: DVec2, height: &Height) -> DVec3 {
        let place = |uv: DVec2| {
            let (p, n) = self.at(uv);
            p + height(uv, p) * n
        };
        let step = 1e-5;
        let along = |axis: DVec2| (place(uv + step * axis) - place(uv - step * axis)) / (2.0 * step);
        let n = along(DVec2::X).cross(along(DVec2::Y)).normalize();
        if n.dot(self.at(uv).1) < 0.0 { -n } else { n }
    }
}

fn with_bumps() -> Specialization {
    let declared = Specialization::DECLARED;
    let material =
        MaterialFeatures { has_bumps: true, has_displacements: true, has_normal_maps: true, ..declared.material };
    Specialization { material, ..declared }
}

/// Scene text of a material before its shape.
fn scene_text(material: &str, shape: &str) -> String {
    format!("WorldBegin LightSource \"infinite\" {material}\n{shape}")
}

/// Points of the first shape of a scene, which is the first primitive of its kind, where rays meet it. `wanted` gives
/// texture coordinates to aim at.
fn bend(text: &str, twin: &Twin, wanted: &dyn Fn(&mut Rng) -> DVec2) -> (Vec<BentPoint>, DAffine3) {
    let (world, packed) = World::parse(text);
    let render_from_world = packed.space.from_world();
    let instance = if world.instances.is_empty() { NONE } else { 0 };
    let mut rng = Rng(5);
    let rays: Vec<BentRay> = (0..COUNT)
        .map(|_| {
            let uv = wanted(&mut rng);
            let (target, normal) = twin.at(uv);
            let target = render_from_world.transform_point3(target);
            let away = rng.direction();
            let away = away
                + normal * (0.2 + normal.dot(away).abs() - normal.dot(away)) * if rng.chance(0.5) { 1.0 } else { -1.0 };
            let origin = double(single(target + 0.3 * away));
            let primitive = if !world.triangles.is_empty() {
                TRIANGLE << KIND_SHIFT
            } else if !world.quadrics.is_empty() {
                world.quadrics[0].kind << KIND_SHIFT
            } else {
                let is_piece = |along: [f32; 2]| (f64::from(along[0])..=f64::from(along[1])).contains(&uv.y);
                let piece = world.revolution_pieces.iter().position(|piece| is_piece(piece.along)).expect("a piece");
                REVOLUTION << KIND_SHIFT | piece as u32
            };
            BentRay { origin: single(origin), primitive, direction: single((target - origin).normalize()), instance }
        })
        .collect();
    let fixture = Fixture::new();
    let gpu = world.upload(&fixture);
    let (rays, points) = (fixture.upload(&rays), fixture.output(COUNT));
    let kernel = BendNormals { scene: gpu.bindings(), rays: &rays, points: &points };
    fixture.run_specialized(&kernel, &with_bumps(), COUNT);
    let points: Vec<BentPoint> = fixture.read(&points);
    let found: Vec<_> = points.into_iter().filter(|point| point.found == 1).collect();
    assert!(found.len() > COUNT / 3, "{} of {COUNT} rays meet the shape", found.len());
    (found, render_from_world)
}

/// Texture coordinates away from poles and seams, where the derivatives have no limits.
fn inner(rng: &mut Rng) -> DVec2 {
    DVec2::new(rng.range(0.05, 0.95), rng.range(0.05, 0.95))
}

/// How a case stands in the world: directives before the shape, and whether the shape is in an instance that is not
/// copied.
#[derive(Clone, Copy)]
struct Place<'a> {
    directives: &'a str,
    instanced: bool,
}

const PLACES: [Place; 5] = [
    Place { directives: "Rotate 20 1 2 3", instanced: false },
    Place { directives: "Scale 1 .6 1.4 Rotate 20 1 2 3", instanced: false },
    Place { directives: "Scale -1 1 1.3 Rotate 50 1 -2 3", instanced: false },
    Place { directives: "ReverseOrientation Rotate 50 1 -2 3", instanced: false },
    Place { directives: "Scale 1 .6 -1.4 Rotate 20 1 2 3", instanced: true },
];

/// The text of the shape at its place; in an instance, with so many copies that they are not copied.
fn placed(place: &Place, material: &str, shape: &str) -> String {
    if !place.instanced {
        return scene_text(material, &format!("{} {shape}", place.directives));
    }
    let mut text = format!("ObjectBegin \"o\" {material} {shape} ObjectEnd AttributeBegin {} ", place.directives);
    text += "ObjectInstance \"o\" AttributeEnd\n";
    for i in 1..5000 {
        let [x, y, z] = [i % 17, i / 17 % 17, 40 + i / 289].map(|at| 0.1 * f64::from(at));
        writeln!(text, "AttributeBegin Translate {x} {y} {z} Scale .01 .01 .01 ObjectInstance \"o\" AttributeEnd")
            .expect("text");
    }
    scene_text("", &text)
}

/// The transform of the first shape in the world, and whether its normal is reversed.
fn transform(text: &str) -> (DAffine3, bool) {
    let scene = Scene::parse(text, "t.pbrt", support::root()).expect("a scene");
    let shape = &scene.shapes[0];
    // The order of the corners turns the normal of a mirrored triangle.
    let mirrored = shape.world_from_object.matrix3.determinant() < 0.0 && !matches!(shape.geometry, Geometry::Mesh(_));
    let world_from_instance = scene.instances.first().map_or(DAffine3::IDENTITY, |one| one.world_from_instance);
    (world_from_instance * shape.world_from_object, shape.reverse_orientation ^ mirrored)
}

/// Heights of both kinds: by the surface's coordinates and by the position. Both are linear in what they depend on, so
/// that a step of any length has their slope. The last number is the largest error of a bent normal. Near the poles of
/// a sphere, a step is 1e-4 render units long, where positions are rounded to EPS.
fn heights() -> [(&'static str, Box<Height>, f64); 2] {
    let of_corners = |at: DVec2, [a, b, c, d]: [f64; 4]| {
        (a * (1.0 - at.x) + b * at.x) * (1.0 - at.y) + (c * (1.0 - at.x) + d * at.x) * at.y
    };
    let corners = [0.05, -0.1, 0.2, 0.15];
    [
        (
            "Texture \"h\" \"float\" \"bilerp\" \"float uscale\" 2 \"float vdelta\" .25 \"float v00\" .05 \
             \"float v10\" -.1 \"float v01\" .2 \"float v11\" .15",
            Box::new(move |uv, _| of_corners(uv * DVec2::new(2.0, 1.0) + DVec2::new(0.0, 0.25), corners)),
            1e-3,
        ),
        (
            "Texture \"h\" \"float\" \"bilerp\" \"string mapping\" \"planar\" \"vector3 v1\" [.8 .6 .3] \
             \"vector3 v2\" [0 .4 -1] \"float v00\" .05 \"float v10\" -.1 \"float v01\" .2 \"float v11\" .05",
            Box::new(move |_, p| {
                let at = DVec2::new(p.dot(DVec3::new(0.8, 0.6, 0.3)), p.dot(DVec3::new(0.0, 0.4, -1.0)));
                of_corners(at, [0.05, -0.1, 0.2, 0.05])
            }),
            4e-3,
        ),
    ]
}

/// A shape in several places, raised by several heights, against the twin.
fn check(shape: &str, patch: Patch, wanted: &dyn Fn(&mut Rng) -> DVec2) {
    for place in &PLACES {
        for (texture, height, tolerance) in &heights() {
            let text = placed(place, &format!("{texture} Material \"diffuse\" \"texture displacement\" \"h\""), shape);
            let (world_from_object, flipped) = transform(&text);
            let twin = Twin { patch, world_from_object, flipped };
            let (points, render_from_world) = bend(&text, &twin, wanted);
            let mut bent: f64 = 0.0;
            let (mut worst, mut compared): (f64, usize) = (0.0, 0);
            for point in &points {
                let uv = DVec2::from(point.uv.map(f64::from));
                let (p, n) = twin.at(uv);
                let off = render_from_world.transform_point3(p).distance(double(point.position));
                // Another ray through the same shape may meet it near a seam or a pole.
                if uv.min_element() < 0.04 || uv.max_element() > 0.96 {
                    continue;
                }
                assert!(off < 2e-5, "{shape} {}: {point:?} is {off} off", place.directives);
                assert!(double(point.normal).dot(n) > 0.999, "{shape} {}: {point:?}", place.directives);
                let expected = twin.raised(uv, &**height);
                worst = worst.max(double(point.shading_normal).distance(expected));
                bent = bent.max(n.distance(expected));
                compared += 1;
            }
            println!("{shape} {}: {compared} normals, bent by up to {bent:.3}, off by {worst:.1e}", place.directives);
            assert!(compared > COUNT / 4, "{compared}");
            assert!(bent > 0.04, "{texture} does not bend {shape}");
            assert!(worst < *tolerance, "{shape} {}: {worst}", place.directives);
        }
    }
}

#[test]
fn bumps_of_spheres_have_the_normals_of_the_raised_surface() {
    check(
        "Shape \"sphere\" \"float radius\" 1.5",
        &|uv| {
            let (phi, theta) = (TAU * uv.x, PI * (1.0 - uv.y));
            let n = DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos());
            (1.5 * n, n)
        },
        &inner,
    );
}

#[test]
fn bumps_of_cut_spheres_and_disks_have_the_normals_of_the_raised_surface() {
    let phi_max = 300.0_f64.to_radians();
    let [bottom, top] = [-0.4, 0.8_f64].map(f64::acos);
    check(
        "Shape \"sphere\" \"float zmin\" -.4 \"float zmax\" .8 \"float phimax\" 300",
        &|uv| {
            let (phi, theta) = (phi_max * uv.x, bottom + (top - bottom) * uv.y);
            let n = DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos());
            (n, n)
        },
        &inner,
    );
    check(
        "Shape \"disk\" \"float radius\" 2 \"float innerradius\" .5 \"float height\" .3 \"float phimax\" 300",
        &|uv| {
            let (phi, radius) = (phi_max * uv.x, 2.0 - 1.5 * uv.y);
            (DVec3::new(radius * phi.cos(), radius * phi.sin(), 0.3), DVec3::Z)
        },
        &inner,
    );
}

#[test]
fn bumps_of_cylinders_have_the_normals_of_the_raised_surface() {
    check(
        "Shape \"cylinder\" \"float radius\" .8 \"float zmin\" -.5 \"float zmax\" 1.5",
        &|uv| {
            let n = DVec3::new((TAU * uv.x).cos(), (TAU * uv.x).sin(), 0.0);
            (0.8 * n + DVec3::Z * (2.0 * uv.y - 0.5), n)
        },
        &inner,
    );
}

#[test]
fn bumps_of_bodies_of_revolution_have_the_normals_of_the_raised_surface() {
    let points = [[0.3, -0.5], [1.4, -0.2], [0.5, 0.4], [0.9, 1.0]].map(DVec2::from);
    let bezier = move |t: f64| {
        let s = 1.0 - t;
        s * s * s * points[0] + 3.0 * s * s * t * points[1] + 3.0 * s * t * t * points[2] + t * t * t * points[3]
    };
    check(
        "Shape \"revolution\" \"integer degree\" 3 \"point2 P\" [.3 -.5 1.4 -.2 .5 .4 .9 1]",
        &move |uv| {
            let (phi, t) = (TAU * uv.x, uv.y);
            let (p, d) = (bezier(t), bezier(t + 1e-6) - bezier(t - 1e-6));
            let around = |r: f64, z: f64| DVec3::new(r * phi.cos(), r * phi.sin(), z);
            (around(p.x, p.y), around(d.y, -d.x).normalize())
        },
        &inner,
    );
}

/// A point in the triangle of the texture coordinates.
fn in_triangle(rng: &mut Rng, uvs: [DVec2; 3]) -> DVec2 {
    let (b1, b2) = (rng.range(0.05, 0.45), rng.range(0.05, 0.45));
    uvs[0] + b1 * (uvs[1] - uvs[0]) + b2 * (uvs[2] - uvs[0])
}

/// The barycentric coordinates of texture coordinates.
fn barycentric(uv: DVec2, uvs: [DVec2; 3]) -> DVec2 {
    DMat2::from_cols(uvs[1] - uvs[0], uvs[2] - uvs[0]).inverse() * (uv - uvs[0])
}

const CORNERS: [DVec3; 3] = [DVec3::new(0.1, -0.2, 0.4), DVec3::new(1.0, 0.3, 0.0), DVec3::new(0.2, 0.9, -0.5)];

fn triangle_text(uv: &str, normals: &str) -> String {
    let numbers: Vec<String> = CORNERS.iter().flat_map(|p| p.to_array()).map(|x| x.to_string()).collect();
    format!("Shape \"trianglemesh\" \"point3 P\" [{}] {uv} {normals}", numbers.join(" "))
}

#[test]
fn bumps_of_triangles_have_the_normals_of_the_raised_surface() {
    let cases = [
        ("\"point2 uv\" [.1 .2 .9 .3 .4 .8]", [[0.1, 0.2], [0.9, 0.3], [0.4, 0.8]]),
        // Mirrored coordinates, and pbrt's own where there are none.
        ("\"point2 uv\" [.1 .2 .4 .8 .9 .3]", [[0.1, 0.2], [0.4, 0.8], [0.9, 0.3]]),
        ("", [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]),
    ];
    for (given, uvs) in cases {
        let uvs = uvs.map(DVec2::from);
        let [p0, p1, p2] = CORNERS;
        let n = (p1 - p0).cross(p2 - p0).normalize();
        check(
            &triangle_text(given, ""),
            &|uv| {
                let b = barycentric(uv, uvs);
                (p0 + b.x * (p1 - p0) + b.y * (p2 - p0), n)
            },
            &|rng| in_triangle(rng, uvs),
        );
    }
}

/// pbrt-v4 takes the derivative by v of a triangle with normals to be perpendicular to the one by u, and as long.
#[test]
fn bumps_of_smooth_triangles_are_those_of_pbrt() {
    let uvs = [[0.1, 0.2], [0.9, 0.3], [0.4, 0.8]].map(DVec2::from);
    let [p0, p1, p2] = CORNERS;
    let flat = (p1 - p0).cross(p2 - p0).normalize();
    let normals = [0.3, -0.2, 0.4].map(|x| (flat + x * (p1 - p0) - 0.2 * (p2 - p0)).normalize());
    let numbers: Vec<String> = normals.iter().flat_map(|n| n.to_array()).map(|x| x.to_string()).collect();
    let shape = triangle_text("\"point2 uv\" [.1 .2 .9 .3 .4 .8]", &format!("\"normal N\" [{}]", numbers.join(" ")));
    let (texture, height, _) = &heights()[0];
    let text = scene_text(&format!("{texture} Material \"diffuse\" \"texture displacement\" \"h\""), &shape);
    let patch = |uv: DVec2| {
        let b = barycentric(uv, uvs);
        (p0 + b.x * (p1 - p0) + b.y * (p2 - p0), flat)
    };
    let twin = Twin { patch: &patch, world_from_object: DAffine3::IDENTITY, flipped: false };
    let (points, _) = bend(&text, &twin, &|rng| in_triangle(rng, uvs));
    let change = |f: &dyn Fn(DVec2) -> DVec3, axis: DVec2| f(uvs[0] + axis) - f(uvs[0]);
    let mix = |corners: [DVec3; 3], uv: DVec2| {
        let b = barycentric(uv, uvs);
        corners[0] + b.x * (corners[1] - corners[0]) + b.y * (corners[2] - corners[0])
    };
    let dp_du = change(&|uv| mix(CORNERS, uv), DVec2::X);
    let [dn_du, dn_dv] = [DVec2::X, DVec2::Y].map(|axis| change(&|uv| mix(normals, uv), axis));
    for point in points {
        let uv = DVec2::from(point.uv.map(f64::from));
        let n = mix(normals, uv).normalize();
        let h = height(uv, DVec3::ZERO);
        let slope = |axis: DVec2| height(uv + axis, DVec3::ZERO) - h;
        let along_u = dp_du - n.dot(dp_du) * n + slope(DVec2::X) * n + h * dn_du;
        let along_v = n.cross(dp_du) + slope(DVec2::Y) * n + h * dn_dv;
        let expected = along_u.cross(along_v).normalize();
        let off = double(point.shading_normal).distance(expected);
        assert!(off < 1e-3 && expected.distance(n) > 0.02, "{point:?} is {off} off {expected}");
    }
}

/// The size of a scene, a part of it that is small, and coordinates far from 0 cost few digits.
#[test]
fn bumps_keep_their_digits_at_extreme_scales() {
    let far = "AttributeBegin Translate 1000 0 0 Shape \"sphere\" AttributeEnd";
    for (scale, more, offset, tolerance) in
        [(1e-6, "", 0.0, 1e-3), (1e9, "", 0.0, 1e-3), (1.0, far, 0.0, 1e-3), (1.0, "", 64.0, 2e-3)]
    {
        let uvs = [[0.1, 0.2], [0.9, 0.3], [0.4, 0.8]].map(|uv| DVec2::from(uv) + offset);
        let given: Vec<String> = uvs.iter().flat_map(|uv| uv.to_array()).map(|x| x.to_string()).collect();
        let texture = format!(
            "Texture \"h\" \"float\" \"bilerp\" \"float udelta\" -{offset} \"float vdelta\" -{offset} \
             \"float v00\" 0 \"float v10\" {} \"float v01\" {} \"float v11\" {}",
            0.3 * scale,
            -0.2 * scale,
            0.1 * scale
        );
        let material =
            format!("{texture} Material \"diffuse\" \"texture displacement\" \"h\" Scale {scale} {scale} {scale}");
        let shape = format!("{} {more}", triangle_text(&format!("\"point2 uv\" [{}]", given.join(" ")), ""));
        let text = scene_text(&material, &shape);
        let [p0, p1, p2] = CORNERS;
        let n = (p1 - p0).cross(p2 - p0).normalize();
        let patch = |uv: DVec2| {
            let b = barycentric(uv, uvs);
            (p0 + b.x * (p1 - p0) + b.y * (p2 - p0), n)
        };
        // In units of the scale, in which the step of the twin is a small one.
        let twin = Twin { patch: &patch, world_from_object: DAffine3::IDENTITY, flipped: false };
        let stretched = Twin { world_from_object: transform(&text).0, ..twin };
        let (points, _) = bend(&text, &stretched, &|rng| in_triangle(rng, uvs));
        let twin = Twin { world_from_object: DAffine3::IDENTITY, ..stretched };
        let height = move |uv: DVec2, _| {
            let at = uv - offset;
            (0.3 * (1.0 - at.y) + 0.3 * at.y) * at.x - 0.2 * at.y
        };
        let off = points.iter().map(|point| {
            let uv = DVec2::from(point.uv.map(f64::from));
            double(point.shading_normal).distance(twin.raised(uv, &height))
        });
        let worst = off.fold(0.0, f64::max);
        println!("scale {scale}, offset {offset}: off by {worst:.1e}");
        assert!(worst < tolerance, "scale {scale}, offset {offset}: {worst}");
    }
}

/// An image of a row of normals at the top, and a row of others at the bottom: v runs up, z leaves the surface on its
/// front, x is along u.
#[test]
fn normal_maps_turn_normals_in_the_frame_of_the_surface() {
    let [top, bottom] = [DVec3::new(0.5, 0.2, 0.7), DVec3::new(-0.4, 0.3, 0.6)];
    let pixels = [top, bottom].map(|n| (0.5 * n + 0.5).as_vec3().to_array());
    let file = ImageFile::new(&Image::from_pixels(1, 2, pixels.to_vec()).expect("an image"));
    let material = format!("Material \"diffuse\" \"string normalmap\" \"{}\"", file.path().display());
    let patch = |uv: DVec2| {
        let (phi, theta) = (TAU * uv.x, PI * (1.0 - uv.y));
        let n = DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos());
        (n, n)
    };
    for place in &PLACES {
        let text = placed(place, &material, "Shape \"sphere\"");
        let (world_from_object, flipped) = transform(&text);
        let twin = Twin { patch: &patch, world_from_object, flipped };
        let (points, _) = bend(&text, &twin, &inner);
        for point in points {
            let uv = DVec2::from(point.uv.map(f64::from));
            if uv.min_element() < 0.02 || uv.max_element() > 0.98 {
                continue;
            }
            let n = twin.at(uv).1;
            let s = (twin.at(uv + DVec2::new(1e-6, 0.0)).0 - twin.at(uv - DVec2::new(1e-6, 0.0)).0).normalize();
            let below_middle_of_first = 2.0 * (1.0 - uv.y) - 0.5;
            let row = |i: f64| if i.rem_euclid(2.0) == 0.0 { top } else { bottom };
            let first = below_middle_of_first.floor();
            let local = row(first).lerp(row(first + 1.0), below_middle_of_first - first);
            let expected = (local.x * s + local.y * n.cross(s) + local.z * n).normalize();
            let off = double(point.shading_normal).distance(expected);
            assert!(off < 3e-3, "{}: {point:?} is {off} off {expected}", place.directives);
            assert!(expected.distance(n) > 0.3);
        }
    }
}
