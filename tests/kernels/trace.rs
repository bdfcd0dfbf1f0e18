//! trace_queries: no ray slips through a closed mesh, and the hierarchy loses no hit.

use std::collections::HashMap;
use std::fmt::Write;

use bytemuck::bytes_of;
use glam::DVec3;

use crate::fixture::{Fixture, Rng, UNBOUNDED, double, single};
use crate::generated::{
    ASKS_ANY, ASKS_NEAREST, NONE, PassFeatures, SceneFeatures, Specialization, TraceRays, TraceRaysPush, TracedHit,
    TracedRay,
};
use crate::support::work;
use crate::world::World;

pub fn trace(world: &World, rays: &[TracedRay]) -> (Vec<TracedHit>, Vec<u32>) {
    trace_by(&Specialization::DECLARED, world, rays, 1)
}

/// Each invocation traces `each` rays.
fn trace_by(
    specialization: &Specialization,
    world: &World,
    rays: &[TracedRay],
    each: usize,
) -> (Vec<TracedHit>, Vec<u32>) {
    let fixture = Fixture::new();
    let world = world.upload(&fixture);
    let count = rays.len();
    let (rays, hits) = (fixture.upload_texels(rays), fixture.output_texels(count));
    let any_hits = fixture.output_texels(count);
    let kernel = TraceRays { scene: world.bindings(), rays: &rays, hits: &hits, any_hits: &any_hits };
    let pass = fixture.device().pass(&kernel, specialization, 64).expect("a pass");
    let mut frame = fixture.device().frame().expect("a frame");
    let push = TraceRaysPush { count: count as u32, asks: ASKS_NEAREST | ASKS_ANY };
    frame.dispatch(&pass, push, count.div_ceil(each) as u64);
    frame.run().expect("a run");
    (fixture.read_texels(&hits), fixture.read_texels(&any_hits))
}

pub fn ray(origin: DVec3, direction: DVec3) -> TracedRay {
    TracedRay { origin: single(origin), t_max: UNBOUNDED, direction: single(direction), pad0: 0.0 }
}

/// The point light that every scene here needs.
pub const LIGHT: &str = "LightSource \"point\"\n";

pub fn mesh_text(points: &[DVec3], triangles: &[[usize; 3]]) -> String {
    let mut text = String::from("Shape \"trianglemesh\" \"point3 P\" [");
    for point in points {
        write!(text, " {} {} {}", point.x, point.y, point.z).expect("text");
    }
    text.push_str(" ] \"integer indices\" [");
    for [a, b, c] in triangles {
        write!(text, " {a} {b} {c}").expect("text");
    }
    text.push_str(" ]\n");
    text
}

/// An icosahedron with each triangle split in four `levels` times, on the unit sphere.
pub fn icosphere(levels: usize) -> (Vec<DVec3>, Vec<[usize; 3]>) {
    let golden = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let mut points = Vec::new();
    for a in [-1.0, 1.0] {
        for b in [-golden, golden] {
            points.extend([DVec3::new(0.0, a, b), DVec3::new(a, b, 0.0), DVec3::new(b, 0.0, a)]);
        }
    }
    // Faces are the triples of corners at the shortest distance from each other.
    let mut triangles = Vec::new();
    let near = |a: DVec3, b: DVec3| a.distance(b) < 2.1;
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                let [p, q, r] = [points[a], points[b], points[c]];
                if near(p, q) && near(q, r) && near(r, p) {
                    triangles.push(if (q - p).cross(r - p).dot(p) > 0.0 { [a, b, c] } else { [a, c, b] });
                }
            }
        }
    }
    for _ in 0..levels {
        let mut middles = HashMap::new();
        let mut split = Vec::new();
        for [a, b, c] in triangles {
            let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(i, j)| {
                *middles.entry((i.min(j), i.max(j))).or_insert_with(|| {
                    points.push(0.5 * (points[i] + points[j]));
                    points.len() - 1
                })
            });
            split.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        triangles = split;
    }
    (points.into_iter().map(DVec3::normalize).collect(), triangles)
}

/// A closed mesh around the origin whose radius varies from corner to corner.
fn bumpy_mesh(levels: usize, rng: &mut Rng) -> World {
    let (mut points, triangles) = icosphere(levels);
    for point in &mut points {
        *point *= rng.range(0.8, 1.0);
    }
    World::parse(&format!("WorldBegin\n{LIGHT}{}", mesh_text(&points, &triangles))).0
}

/// A ray from inside to a corner, to a point of an edge, or near either.
fn ray_to_edge(world: &World, rng: &mut Rng) -> TracedRay {
    let triangle = &world.triangles[rng.below(world.triangles.len())];
    let corners = [triangle.p0, triangle.p1, triangle.p2].map(double);
    let first = rng.below(3);
    let along = if rng.chance(0.5) { 0.0 } else { rng.unit() };
    let mut target = corners[first].lerp(corners[(first + 1) % 3], along);
    if rng.chance(0.3) {
        target += rng.direction() * rng.log_range(1e-9, 1e-6);
    }
    // Some from the very centre, where axes and planes of symmetry meet.
    let origin = if rng.chance(0.1) { DVec3::ZERO } else { rng.direction() * rng.range(0.0, 0.3) };
    let origin = double(single(origin));
    let length = if rng.chance(0.5) { 1.0 } else { rng.log_range(0.01, 100.0) };
    ray(origin, (target - origin).normalize() * length)
}

pub fn count_misses(world: &World, rays: &[TracedRay]) -> usize {
    let (hits, any_hits) = trace(world, rays);
    let missed: Vec<_> = (0..rays.len()).filter(|i| hits[*i].primitive == NONE || any_hits[*i] == NONE).collect();
    for i in missed.iter().take(3) {
        println!("missed by {:?}", rays[*i]);
    }
    missed.len()
}

#[test]
fn no_ray_slips_between_triangles() {
    let mut rng = Rng(1);
    for _ in 0..5 {
        let world = bumpy_mesh(1, &mut rng).without_hierarchy();
        let rays: Vec<_> = (0..work(25_000, 100_000)).map(|_| ray_to_edge(&world, &mut rng)).collect();
        assert_eq!(count_misses(&world, &rays), 0, "rays left a closed mesh of 80 triangles");
    }
}

#[test]
fn no_ray_slips_through_the_hierarchy() {
    let mut rng = Rng(2);
    let world = bumpy_mesh(4, &mut rng);
    let rays: Vec<_> = (0..work(250_000, 1_000_000)).map(|_| ray_to_edge(&world, &mut rng)).collect();
    assert_eq!(count_misses(&world, &rays), 0, "rays left a closed mesh of 5120 triangles");
}

/// Triangles, spheres, ellipsoids and disks of many sizes, some cut.
fn mixed_scene(rng: &mut Rng, triangle_count: usize, quadric_count: usize) -> World {
    let mut text = format!("WorldBegin\n{LIGHT}");
    let (mut points, mut triangles) = (Vec::new(), Vec::new());
    for i in 0..triangle_count {
        let (center, size) = (rng.cube(1.0), rng.log_range(0.01, 0.3));
        points.extend([0; 3].map(|_| center + size * rng.cube(1.0)));
        triangles.push([3 * i, 3 * i + 1, 3 * i + 2]);
    }
    text.push_str(&mesh_text(&points, &triangles));
    for i in 0..quadric_count {
        let (place, axis) = (rng.cube(1.0), rng.direction());
        let radius = rng.log_range(0.005, 0.1);
        let stretch = if i % 3 == 0 { rng.range(0.2, 1.0) } else { 1.0 };
        let shape = match i % 4 {
            0 => format!("\"disk\" \"float radius\" {radius} \"float innerradius\" {}", 0.3 * radius),
            1 => format!("\"sphere\" \"float radius\" {radius} \"float zmax\" {} \"float phimax\" 200", 0.3 * radius),
            _ => format!("\"sphere\" \"float radius\" {radius}"),
        };
        let turn = format!("Rotate {} {} {} {}", rng.range(0.0, 360.0), axis.x, axis.y, axis.z);
        writeln!(
            text,
            "AttributeBegin\nTranslate {} {} {}\n{turn}\nScale 1 1 {stretch}\nShape {shape}\nAttributeEnd",
            place.x, place.y, place.z
        )
        .expect("text");
    }
    World::parse(&text).0
}

/// Rays within the scene and into it; along axes, from corners of boxes, of any length.
fn ray_through(world: &World, rng: &mut Rng) -> TracedRay {
    let corner = |rng: &mut Rng| double(world.triangles[rng.below(world.triangles.len())].p0);
    let origin = match rng.below(3) {
        0 => corner(rng),
        1 => rng.cube(0.5),
        _ => 2.0 * rng.direction(),
    };
    let mut direction = if rng.chance(0.5) { corner(rng) - origin } else { rng.direction() };
    if rng.chance(0.2) {
        // Components that are zero, of either sign, or nearly.
        let tiny = [0.0, -0.0, 1e-38, -1e-30, 1e-20][rng.below(5)];
        let kept = rng.below(3);
        direction[kept] = if rng.chance(0.5) { tiny } else { direction[kept] };
        direction[(kept + 1) % 3] = tiny;
    }
    if direction.length() < 1e-3 {
        direction = DVec3::X;
    }
    let mut ray = ray(origin, direction);
    ray.t_max = if rng.chance(0.3) { rng.range(0.0, 2.0) as f32 } else { UNBOUNDED };
    ray
}

/// The hierarchy only leaves out primitives that the ray does not meet: the hits are bit
/// for bit those of testing all of them.
#[test]
fn the_hierarchy_loses_no_hit() {
    let mut rng = Rng(3);
    let world = mixed_scene(&mut rng, 500, 300);
    let rays: Vec<_> = (0..work(20_000, 60_000)).map(|_| ray_through(&world, &mut rng)).collect();
    let (hits, any_hits) = trace(&world, &rays);
    let (all_hits, _) = trace(&world.without_hierarchy(), &rays);
    let mut found = 0;
    for (((ray, hit), all), any) in rays.iter().zip(&hits).zip(&all_hits).zip(any_hits) {
        assert_eq!(bytes_of(hit), bytes_of(all), "{ray:?}: the hierarchy gives {hit:?}, all primitives {all:?}");
        assert_eq!(any == NONE, hit.primitive == NONE, "{ray:?}: some hit {any}, the nearest {hit:?}");
        found += usize::from(hit.primitive != NONE);
    }
    assert!(found > rays.len() / 4 && found < rays.len(), "{found}");
}

/// Lanes that go on together, each with the next ray of a queue, find bit for bit what lanes find that each
/// finish their ray: on meshes, quadrics, bodies of revolution and instances, for rays aimed at edges too.
#[test]
fn lanes_with_a_queue_of_rays_find_the_same_hits() {
    let mut rng = Rng(6);
    let (points, triangles) = icosphere(3);
    let mut text = format!("WorldBegin\n{LIGHT}ObjectBegin \"ball\"\n{}ObjectEnd\n", mesh_text(&points, &triangles));
    for _ in 0..12 {
        let place = rng.cube(4.0);
        let size = rng.range(0.1, 1.0);
        let end = format!("{} {} {}\nScale {size} {size} {size}\n", place.x, place.y, place.z);
        write!(text, "AttributeBegin\nTranslate {end}ObjectInstance \"ball\"\nAttributeEnd\n").expect("text");
        let profile = "Shape \"revolution\" \"integer degree\" 3 \"point2 P\" [0 -1 1 -1 .2 .5 .8 1]";
        write!(text, "AttributeBegin\nTranslate {} 0 0 Translate {end}{profile}\nAttributeEnd\n", rng.unit())
            .expect("text");
    }
    let (instances, _) = World::parse(&text);
    assert!(!instances.instances.is_empty() && !instances.revolutions.is_empty());
    let mesh = bumpy_mesh(3, &mut rng);
    let mixed = mixed_scene(&mut rng, 200, 100);
    let queue = Specialization {
        pass: PassFeatures { is_queue: true, ..Specialization::DECLARED.pass },
        ..Specialization::DECLARED
    };
    for world in [&mesh, &mixed, &instances] {
        let mut rays: Vec<_> = (0..20_000).map(|_| ray_through(world, &mut rng)).collect();
        rays.extend((0..20_000).map(|_| ray_to_edge(world, &mut rng)));
        let (hits, any_hits) = trace(world, &rays);
        assert!(hits.iter().filter(|hit| hit.primitive != NONE).count() > rays.len() / 20);
        // Of several rays each, with lanes that have none or one fewer than others.
        for each in [1, 7, 32] {
            let (queued, any_queued) = trace_by(&queue, world, &rays, each);
            for (((ray, hit), other), i) in rays.iter().zip(&hits).zip(&queued).zip(0..) {
                assert_eq!(bytes_of(hit), bytes_of(other), "ray {i} of {each} each: {ray:?}: {hit:?}, {other:?}");
            }
            // Which hit is found first may depend on nothing but the ray.
            assert_eq!(any_hits, any_queued);
        }
    }
}

/// Scenes of few primitives go without a hierarchy.
#[test]
fn all_of_a_few_primitives_are_tested() {
    let mut rng = Rng(5);
    for (triangles, quadrics) in [(9, 0), (0, 7), (6, 9)] {
        let world = mixed_scene(&mut rng, triangles.max(1), quadrics);
        let flat = Specialization {
            scene: SceneFeatures {
                is_flat: true,
                flat_triangles: world.triangles.len() as u32,
                flat_quadrics: world.quadrics.len() as u32,
                ..Specialization::DECLARED.scene
            },
            ..Specialization::DECLARED
        };
        let rays: Vec<_> = (0..10_000).map(|_| ray_through(&world, &mut rng)).collect();
        let (hits, any_hits) = trace_by(&flat, &world, &rays, 1);
        for (((ray, hit), other), any) in rays.iter().zip(&hits).zip(trace(&world, &rays).0).zip(any_hits) {
            assert_eq!((hit.t, hit.primitive == NONE), (other.t, other.primitive == NONE), "{ray:?}");
            assert_eq!(any == NONE, hit.primitive == NONE, "{ray:?}: some hit {any}, the nearest {hit:?}");
        }
    }
}

/// An f64 twin of the nearest of all triangles.
#[test]
fn the_nearest_hit_is_the_nearest_in_f64() {
    let mut rng = Rng(4);
    let world = bumpy_mesh(2, &mut rng);
    let rays: Vec<_> = (0..20_000)
        .map(|_| {
            let origin = 2.0 * rng.direction();
            ray(origin, rng.cube(0.6) - origin)
        })
        .collect();
    let mut found = 0;
    for (ray, hit) in rays.iter().zip(trace(&world, &rays).0) {
        let (origin, direction) = (double(ray.origin), double(ray.direction));
        let mut nearest = f64::INFINITY;
        for triangle in &world.triangles {
            let [v0, v1, v2] = [triangle.p0, triangle.p1, triangle.p2].map(|p| double(p) - origin);
            let (a, b) = (v1 - v0, v2 - v0);
            let determinant = direction.cross(b).dot(a);
            let b1 = -direction.cross(b).dot(v0) / determinant;
            let b2 = -v0.cross(a).dot(direction) / determinant;
            let t = -v0.cross(a).dot(b) / determinant;
            if b1 >= 0.0 && b2 >= 0.0 && b1 + b2 <= 1.0 && t > 0.0 {
                nearest = nearest.min(t);
            }
        }
        let missed = hit.primitive == NONE;
        let same = if missed { nearest == f64::INFINITY } else { (f64::from(hit.t) - nearest).abs() < 1e-5 };
        found += usize::from(!missed);
        assert!(same, "{ray:?} meets {hit:?}, not t = {nearest}");
    }
    assert!(found > rays.len() / 4 && found < rays.len(), "{found}");
}

/// Straight rays in the planes of the boxes' faces, where a slab would be zero times
/// infinity: none of the boxes that share a face may lose them.
#[test]
fn rays_in_the_faces_of_boxes_hit() {
    const SIDE: usize = 8;
    let at = |i: usize| i as f64 / SIDE as f64 - 0.5;
    let points: Vec<_> = (0..(SIDE + 1).pow(2))
        .map(|i| DVec3::new(at(i % (SIDE + 1)), at(i / (SIDE + 1)), if i % 3 == 0 { 0.25 } else { 0.0 }))
        .collect();
    let mut triangles = Vec::new();
    for i in (0..SIDE * SIDE).map(|i| i / SIDE * (SIDE + 1) + i % SIDE) {
        triangles.extend([[i, i + 1, i + SIDE + 1], [i + 1, i + SIDE + 2, i + SIDE + 1]]);
    }
    let (world, _) = World::parse(&format!("WorldBegin\n{LIGHT}{}", mesh_text(&points, &triangles)));
    let mut rng = Rng(5);
    let mut rays = Vec::new();
    for triangle in &world.triangles {
        for corner in [triangle.p0, triangle.p1, triangle.p2].map(double) {
            // The rim belongs to the mesh too.
            rays.push(ray(corner.with_z(2.0), DVec3::NEG_Z));
            rays.push(ray(corner.with_z(-2.0), DVec3::new(0.0, -0.0, 1.0)));
            let across = -0.25 * corner.y.signum() * rng.unit();
            rays.push(ray(corner.with_z(1.0), DVec3::new(0.0, across, -1.0)));
        }
    }
    assert_eq!(count_misses(&world, &rays), 0, "rays in the faces of boxes are lost");
}
