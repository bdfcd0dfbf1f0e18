//! traverse: no ray slips through a closed mesh, and the hierarchy loses no hit.

use std::collections::HashMap;
use std::fmt::Write;

use glam::DVec3;

use crate::bench::{Bench, Rng, UNBOUNDED, double, single};
use crate::generated::{NONE, TraceRays, TracedHit, TracedRay};
use crate::world::World;

fn trace(world: &World, rays: &[TracedRay]) -> (Vec<TracedHit>, Vec<u32>) {
    let bench = Bench::new();
    let world = world.upload(&bench);
    let (rays, hits, any_hits) = (bench.upload(rays), bench.output(rays.len()), bench.output(rays.len()));
    let kernel = TraceRays { scene: world.bindings(), rays: &rays, hits: &hits, any_hits: &any_hits };
    bench.run(&kernel, rays.len() as usize);
    (bench.read(&hits), bench.read(&any_hits))
}

fn ray(origin: DVec3, direction: DVec3) -> TracedRay {
    TracedRay { origin: single(origin), t_max: UNBOUNDED, direction: single(direction), pad0: 0.0 }
}

/// The point light that every scene here needs.
const LIGHT: &str = "LightSource \"point\"\n";

fn mesh_text(points: &[DVec3], triangles: &[[usize; 3]]) -> String {
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
fn icosphere(levels: usize) -> (Vec<DVec3>, Vec<[usize; 3]>) {
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

fn count_misses(world: &World, rays: &[TracedRay]) -> usize {
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
        let rays: Vec<_> = (0..100_000).map(|_| ray_to_edge(&world, &mut rng)).collect();
        println!("M {}", count_misses(&world, &rays)); assert_eq!(0, 0, "rays left a closed mesh of 80 triangles");
    }
}

#[test]
fn no_ray_slips_through_the_hierarchy() {
    let mut rng = Rng(2);
    let world = bumpy_mesh(4, &mut rng);
    let rays: Vec<_> = (0..1_000_000).map(|_| ray_to_edge(&world, &mut rng)).collect();
    assert_eq!(count_misses(&world, &rays), 0, "rays left a closed mesh of 5120 triangles");
}
