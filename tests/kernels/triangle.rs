//! intersect_triangle: decisions, distances and barycentrics against f64.

use glam::DVec3;

use crate::fixture::{EPS, Fixture, Rng, UNBOUNDED, double, single};
use crate::generated::{HitTriangles, SceneArrays, Triangle, TriangleHit, TriangleRay};
use crate::world::{World, triangle};

fn hit_triangles(triangles: &[Triangle], rays: &[TriangleRay]) -> Vec<TriangleHit> {
    let fixture = Fixture::new();
    let world = World::of(SceneArrays { triangles: triangles.to_vec(), ..SceneArrays::default() }).upload(&fixture);
    let (rays, hits) = (fixture.upload(rays), fixture.output(rays.len()));
    fixture.run(&HitTriangles { scene: world.bindings(), rays: &rays, hits: &hits }, rays.len() as usize);
    fixture.read(&hits)
}

/// What an exact intersection is, and how far fp32 may be from it.
struct Exact {
    /// Weights of p1, p2 and p0.
    weights: [f64; 3],
    weight_error: f64,
    t: f64,
    t_error: f64,
}

/// Moeller and Trumbore 1997 in f64, with first-order error bounds of Woop's test.
///
/// With V the largest coordinate of a corner from the origin, a corner in the shear is off
/// by 6 EPS V on each axis: 1 for the subtraction, 4 for the shear (a quotient of two
/// roundings at most 1, a product, and the corner's z), 1 for the last subtraction. An edge
/// function of corners at most R from the ray is then off by 2 R times sqrt(2) that, and 3
/// EPS R^2. Each weight is an edge function over the sum of all.
///
/// t is a mean of the corners' own, so that an error of the weights can move it between the
/// nearest and the farthest corner only. It has 10 roundings besides.
fn intersect_exactly(corners: [DVec3; 3], ray: &TriangleRay) -> Exact {
    let (origin, d) = (double(ray.origin), double(ray.direction));
    let [v0, v1, v2] = corners.map(|corner| corner - origin);
    let (a, b) = (v1 - v0, v2 - v0);
    let determinant = d.cross(b).dot(a);
    let b1 = d.cross(b).dot(-v0) / determinant;
    let b2 = (-v0).cross(a).dot(d) / determinant;
    let weights = [b1, b2, 1.0 - b1 - b2];

    let axis = (0..3).max_by(|i, j| d[*i].abs().total_cmp(&d[*j].abs())).expect("an axis");
    let depths = [v0, v1, v2].map(|v| v[axis] / d[axis]);
    let radius = [0, 1, 2].map(|i| ([v0, v1, v2][i] - depths[i] * d).length()).into_iter().fold(0.0, f64::max);
    let reach = [v0, v1, v2].map(|v| v.abs().max_element()).into_iter().fold(0.0, f64::max);
    let shear_error = 6.0 * std::f64::consts::SQRT_2 * EPS * reach;
    let edge_error = 2.0 * radius * shear_error + shear_error * shear_error + 3.0 * EPS * radius * radius;
    // Edge functions add up to the determinant over the longest component.
    let largest = weights.map(f64::abs).into_iter().fold(1.0, f64::max);
    let weight_error = (1.0 + 3.0 * largest) * edge_error * d[axis].abs() / determinant.abs() + 3.0 * EPS * largest;

    let [near, far] = [f64::min, f64::max].map(|pick| depths.into_iter().reduce(pick).expect("a depth"));
    let rounding = 10.0 * EPS * near.abs().max(far.abs());
    let t = (-v0).cross(a).dot(b) / determinant;
    if weight_error < 0.25 {
        Exact { weights, weight_error, t, t_error: 2.0 * weight_error * (far - near) + rounding }
    } else {
        // No fp32 test can tell where the ray meets a triangle that it sees from its edge.
        let t_error = if weights.iter().all(|w| (-1.0..2.0).contains(w)) { 2.0 * (far - near) } else { f64::INFINITY };
        Exact { weights, weight_error: f64::INFINITY, t: 0.5 * (near + far), t_error: t_error + rounding }
    }
}

struct Shape {
    corners: [[f32; 3]; 3],
    origin_distance: f64,
}

/// Triangles from needles to tiny and far ones.
fn random_shape(rng: &mut Rng) -> Shape {
    let size = if rng.chance(0.5) { rng.log_range(1e-6, 1.0) } else { 1.0 };
    let place = rng.cube(1.0);
    let [a, b] = [rng.direction(), rng.direction()];
    let thickness = if rng.chance(0.3) { rng.log_range(1e-5, 1.0) } else { 1.0 };
    let corners = [place, place + size * a, place + size * (0.5 * a + thickness * b)];
    let distance = if rng.chance(0.2) { rng.log_range(1.0, 1e3) } else { rng.range(0.0, 2.0) };
    let turned = rng.below(3);
    let corners = [0, 1, 2].map(|i| single(corners[(i + turned) % 3]));
    Shape { corners, origin_distance: distance }
}

/// A ray towards a point of the triangle's plane, inside it or around it.
fn random_ray(rng: &mut Rng, shape: &Shape, index: usize) -> TriangleRay {
    let [p0, p1, p2] = shape.corners.map(double);
    let (b1, b2) = (rng.range(-0.5, 1.5), rng.range(-0.5, 1.5));
    let target = p0 + b1 * (p1 - p0) + b2 * (p2 - p0);
    let origin = single(target + shape.origin_distance * rng.direction());
    let length = if rng.chance(0.2) { rng.log_range(0.01, 100.0) } else { 1.0 };
    let direction = (target - double(origin)).normalize_or(DVec3::X) * length;
    let t_max = if rng.chance(0.3) { rng.range(0.0, 4.0) as f32 } else { UNBOUNDED };
    TriangleRay { origin, triangle: index as u32, direction: single(direction), t_max }
}

#[test]
fn triangle_hits_agree_with_f64() {
    const COUNT: usize = 400_000;
    let mut rng = Rng(1);
    let shapes: Vec<Shape> = (0..COUNT).map(|_| random_shape(&mut rng)).collect();
    let rays: Vec<_> = shapes.iter().enumerate().map(|(i, shape)| random_ray(&mut rng, shape, i)).collect();
    let triangles: Vec<_> = shapes.iter().map(|shape| triangle(shape.corners)).collect();
    let hits = hit_triangles(&triangles, &rays);
    let (mut sure_hits, mut sure_misses, mut sharp) = (0, 0, 0);
    for ((shape, ray), hit) in shapes.iter().zip(&rays).zip(&hits) {
        let exact = intersect_exactly(shape.corners.map(double), ray);
        let smallest = exact.weights.into_iter().fold(f64::INFINITY, f64::min);
        let t_max = f64::from(ray.t_max);
        let inside = smallest > exact.weight_error;
        let outside = smallest < -exact.weight_error;
        let reached = exact.t > exact.t_error && exact.t + exact.t_error < t_max;
        let unreached = exact.t < -exact.t_error || exact.t - exact.t_error > t_max;
        if outside || unreached {
            sure_misses += 1;
            assert_eq!(hit.found, 0, "a ray beside a triangle hits: {ray:?} {:?}", shape.corners);
            assert_eq!(hit.t, ray.t_max, "a miss changes the hit");
        } else if inside && reached {
            sure_hits += 1;
            assert_eq!(hit.found, 1, "a ray misses the triangle it meets: {ray:?} {:?}", shape.corners);
        }
        if hit.found == 1 {
            let error = (f64::from(hit.t) - exact.t).abs();
            assert!(error <= exact.t_error, "t {} is not {}: {ray:?} {:?}", hit.t, exact.t, shape.corners);
            sharp += usize::from(exact.t_error < 1e-5 * exact.t);
            for (weight, exact_weight) in hit.barycentric.into_iter().zip(exact.weights) {
                let error = (f64::from(weight) - exact_weight).abs();
                assert!((0.0..=1.0).contains(&weight), "{hit:?} of {ray:?} {:?}", shape.corners);
                let known = exact.weight_error.is_finite();
                assert!(!known || error <= exact.weight_error, "{hit:?} is not {:?}: {ray:?}", exact.weights);
            }
        }
    }
    // The bounds leave few cases open, and most hits are known to 1e-5.
    assert!(sure_hits > COUNT / 20 && sure_misses > COUNT / 2, "{sure_hits} {sure_misses}");
    assert!(sure_hits + sure_misses > COUNT * 7 / 10, "{sure_hits} {sure_misses}");
    assert!(sharp > COUNT / 50, "{sharp}");
}

#[test]
fn the_first_barycentric_is_the_weight_of_p1() {
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let ray = |x, y| TriangleRay { origin: [x, y, 2.0], triangle: 0, direction: [0.0, 0.0, -1.0], t_max: UNBOUNDED };
    let hits = hit_triangles(&[triangle(corners)], &[ray(0.75, 0.125), ray(0.125, 0.75), ray(0.125, 0.125)]);
    assert_eq!(hits[0], TriangleHit { barycentric: [0.75, 0.125], t: 2.0, found: 1 });
    assert_eq!(hits[1], TriangleHit { barycentric: [0.125, 0.75], t: 2.0, found: 1 });
    assert_eq!(hits[2], TriangleHit { barycentric: [0.125, 0.125], t: 2.0, found: 1 });
}

#[test]
fn both_sides_of_a_triangle_are_hit() {
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let ray =
        |z: f32| TriangleRay { origin: [0.25, 0.25, z], triangle: 0, direction: [0.0, 0.0, -z], t_max: UNBOUNDED };
    let hits = hit_triangles(&[triangle(corners)], &[ray(1.0), ray(-1.0)]);
    assert!(hits.iter().all(|hit| hit.found == 1 && hit.t == 1.0), "{hits:?}");
}

#[test]
fn triangles_without_area_are_never_hit() {
    const COUNT: usize = 100_000;
    let mut rng = Rng(2);
    let mut triangles = Vec::new();
    let mut rays = Vec::new();
    for index in 0..COUNT as u32 {
        let (a, b) = (single(rng.cube(1.0)), single(rng.cube(1.0)));
        triangles.push(triangle([[a, a, b], [a, b, a], [b, a, a], [a, a, a]][rng.below(4)]));
        let target = double(a).lerp(double(b), rng.unit());
        let origin = single(rng.cube(1.0));
        rays.push(TriangleRay {
            origin,
            triangle: index,
            direction: single(target - double(origin)),
            t_max: UNBOUNDED,
        });
    }
    let hits = hit_triangles(&triangles, &rays);
    assert_eq!(hits.iter().filter(|hit| hit.found == 1).count(), 0);
}

#[test]
fn a_ray_in_the_plane_of_a_triangle_gives_no_nonsense() {
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let mut rng = Rng(3);
    let rays: Vec<_> = (0..10_000)
        .map(|_| {
            let (origin, target) = (rng.cube(2.0), rng.cube(1.0));
            let direction = single((target - origin).with_z(0.0));
            TriangleRay { origin: single(origin.with_z(0.0)), triangle: 0, direction, t_max: UNBOUNDED }
        })
        .collect();
    let hits = hit_triangles(&[triangle(corners)], &rays);
    assert!(hits.iter().all(|hit| hit.found == 0), "a ray in the plane hits");
}
