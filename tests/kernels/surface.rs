//! surface_at and offset_origin: positions within their error bounds, and rays that leave
//! a surface without meeting it again.

use glam::{DAffine3, DMat3, DVec3};

use crate::fixture::{EPS, Fixture, Rng, double, single};
use crate::generated::{
    Arrival, DISK, Departure, KIND_SHIFT, LeaveSurfaces, Quadric, SPHERE, SceneArrays, TRIANGLE, Triangle,
};
use crate::world::{World, affine, quadric, triangle};

const COUNT: usize = 300_000;

fn leave(world: &World, arrivals: &[Arrival]) -> Vec<Departure> {
    let fixture = Fixture::new();
    let world = world.upload(&fixture);
    let (arrivals, departures) = (fixture.upload(arrivals), fixture.output(arrivals.len()));
    let kernel = LeaveSurfaces { scene: world.bindings(), arrivals: &arrivals, departures: &departures };
    fixture.run(&kernel, arrivals.len() as usize);
    fixture.read(&departures)
}

/// A ray from anywhere in the scene to `target`; another leaves in any direction, often
/// nearly along the surface.
fn arrive(rng: &mut Rng, primitive: u32, target: DVec3, normal: DVec3) -> Arrival {
    let origin = if rng.chance(0.5) { rng.cube(1.0) } else { target + rng.direction() * rng.log_range(1e-3, 1.0) };
    let origin = double(single(origin));
    let mut leaving = rng.direction();
    if rng.chance(0.5) {
        leaving -= leaving.dot(normal) * normal * (1.0 - rng.log_range(1e-8, 1.0));
    }
    Arrival {
        origin: single(origin),
        primitive,
        direction: single((target - origin).normalize()),
        pad0: 0.0,
        leaving: single(leaving.normalize()),
        pad1: 0.0,
    }
}

/// A position in render space: mostly away from the origin, where digits are few.
fn place(rng: &mut Rng, size: f64) -> DVec3 {
    (1.0 - size).max(0.0) * if rng.chance(0.2) { DVec3::ZERO } else { rng.cube(1.0) }
}

fn random_triangle(rng: &mut Rng) -> Triangle {
    let size = rng.log_range(1e-4, 1.0);
    let center = place(rng, size);
    loop {
        let [a, b] = [0; 2].map(|_| size * rng.cube(1.0));
        let c = a + a.distance(b) * rng.log_range(1e-3, 1.0) * rng.direction();
        let corners = [a, b, c].map(|corner| single(center + corner));
        let edge = |i: usize| double(corners[(i + 1) % 3]).distance(double(corners[(i + 2) % 3]));
        // As the scene is packed: the two shorter edges meet in p0. Needles, but nothing flat.
        let first = (0..3).max_by(|i, j| edge(*i).total_cmp(&edge(*j))).expect("an edge");
        let [p0, p1, p2] = [0, 1, 2].map(|i| corners[(first + i) % 3]);
        let [ab, ac] = [p1, p2].map(|corner| double(corner) - double(p0));
        if ab.cross(ac).length() > 0.1 * ab.length() * ac.length() {
            return triangle([p0, p1, p2]);
        }
    }
}

#[test]
fn rays_that_leave_a_triangle_do_not_meet_it_again() {
    let mut rng = Rng(1);
    let triangles: Vec<_> = (0..COUNT).map(|_| random_triangle(&mut rng)).collect();
    let corners = |triangle: &Triangle| [triangle.p0, triangle.p1, triangle.p2].map(double);
    let mut arrivals = Vec::new();
    for (i, triangle) in triangles.iter().enumerate() {
        let [p0, p1, p2] = corners(triangle);
        let (u, v) = (rng.unit(), rng.unit());
        let (b1, b2) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
        let target = p0 + b1 * (p1 - p0) + b2 * (p2 - p0);
        let normal = (p1 - p0).cross(p2 - p0).normalize();
        arrivals.push(arrive(&mut rng, TRIANGLE << KIND_SHIFT | i as u32, target, normal));
    }
    let world = World::of(SceneArrays { triangles: triangles.clone(), ..SceneArrays::default() });
    let mut found = 0;
    for ((triangle, arrival), departure) in triangles.iter().zip(&arrivals).zip(leave(&world, &arrivals)) {
        if departure.found == 0 {
            continue;
        }
        found += 1;
        let [p0, p1, p2] = corners(triangle);
        let normal = (p1 - p0).cross(p2 - p0).normalize();
        let (position, error) = (double(departure.position), f64::from(departure.error));
        let height = (position - p0).dot(normal).abs();
        assert!(height <= normal.abs().element_sum() * error, "{arrival:?}: {departure:?} is {height:e} off");
        // Sides have rounding errors of EPS of their lengths; they are far from parallel.
        assert!(double(departure.normal).distance(normal) <= 100.0 * EPS, "{departure:?} has no normal {normal}");
        assert!(departure.t_again < 0.0, "{arrival:?} meets {triangle:?} again: {departure:?}");
        assert_offset(arrival, &departure);
    }
    assert!(found > COUNT * 8 / 10, "{found}");
}

/// The offset goes to the side of the leaving direction, and no farther than it must:
/// sqrt(3) errors for the sum over the axes, and rounding.
fn assert_offset(arrival: &Arrival, departure: &Departure) {
    let offset = double(departure.origin) - double(departure.position);
    let error = f64::from(departure.error);
    let side = double(arrival.leaving).dot(double(departure.normal));
    let along = offset.dot(double(departure.normal)) * if side < 0.0 { -1.0 } else { 1.0 };
    // fp32 may see a direction in the surface on the other side.
    let along = if side.abs() < 4.0 * EPS { along.abs() } else { along };
    assert!(along > 0.5 * error && offset.length() < 2.5 * error, "{arrival:?} leaves by {offset} of {error:e}");
    // 16 roundings of coordinates up to sqrt(3) and sizes up to 2.
    assert!(error <= 16.0 * EPS * 4.0, "{departure:?} has an error of {error:e}");
}

/// A rotation, another one and a stretch in between: any linear map.
fn random_transform(rng: &mut Rng, stretch: f64) -> DAffine3 {
    let turn = |rng: &mut Rng| DMat3::from_axis_angle(rng.direction(), rng.range(0.0, 6.0));
    let size = rng.log_range(1e-4, 0.9);
    let axis = |rng: &mut Rng| size / rng.log_range(1.0, stretch);
    let scale = DMat3::from_diagonal(DVec3::new(axis(rng), axis(rng), axis(rng)));
    let linear = turn(rng) * scale * turn(rng);
    DAffine3 { matrix3: linear, translation: place(rng, size) }
}

struct Quadrics {
    quadrics: Vec<Quadric>,
    arrivals: Vec<Arrival>,
    departures: Vec<Departure>,
}

/// Rays to points of quadrics that `sample` gives with their normals in object space.
fn visit(seed: u64, kind: u32, stretch: f64, sample: impl Fn(&mut Rng) -> (DVec3, DVec3)) -> Quadrics {
    let mut rng = Rng(seed);
    let (mut quadrics, mut arrivals) = (Vec::new(), Vec::new());
    for i in 0..COUNT {
        let transform = random_transform(&mut rng, stretch);
        let (point, normal) = sample(&mut rng);
        let normal = (transform.matrix3.inverse().transpose() * normal).normalize();
        let flipped = u32::from(rng.chance(0.5));
        quadrics.push(Quadric { flipped, ..quadric(&transform) });
        let target = transform.transform_point3(point);
        arrivals.push(arrive(&mut rng, kind << KIND_SHIFT | i as u32, target, normal));
    }
    let departures = leave(&World::of(SceneArrays { quadrics: quadrics.clone(), ..SceneArrays::default() }), &arrivals);
    Quadrics { quadrics, arrivals, departures }
}

/// The far side of a sphere along a ray from inside, and how an error in render space
/// changes it, in f64.
fn far_side(quadric: &Quadric, origin: DVec3, direction: DVec3) -> (f64, f64) {
    let object_from_render = affine(quadric.object_from_render);
    let o = object_from_render.transform_point3(origin);
    let d = object_from_render.transform_vector3(direction);
    let closest = -o.dot(d) / d.length_squared();
    let h2 = 1.0 - (o + closest * d).length_squared();
    let t = closest + (h2 / d.length_squared()).sqrt();
    let normal = (object_from_render.matrix3.transpose() * (o + t * d)).normalize();
    (t, 1.0 / normal.dot(direction).abs())
}

fn check_sphere(quadric: &Quadric, arrival: &Arrival, departure: &Departure) {
    let render_from_object = affine(quadric.render_from_object);
    let position = double(departure.position);
    let p = render_from_object.inverse().transform_point3(position);
    let nearest = render_from_object.transform_point3(p.normalize());
    let off = (position - nearest).abs().max_element();
    let error = f64::from(departure.error);
    assert!(off <= error, "{departure:?} is {off:e} off the sphere");
    assert_offset(arrival, departure);
    let normal = (render_from_object.matrix3.inverse().transpose() * p).normalize();
    let side = if quadric.flipped != 0 { -1.0 } else { 1.0 };
    let leaving = double(arrival.leaving);
    let cos = leaving.dot(double(departure.normal)) * side;
    assert!(double(departure.normal).dot(normal) * side > 0.999, "{departure:?} looks to the wrong side");
    if cos.abs() < 4.0 * EPS {
        // fp32 may take either side.
    } else if cos > 0.0 {
        assert!(departure.t_again < 0.0, "{arrival:?} meets {quadric:?} from outside: {departure:?}");
    } else {
        let (far, slant) = far_side(quadric, double(departure.origin), leaving);
        let again = f64::from(departure.t_again);
        assert!(again > 0.0, "{arrival:?} does not reach the far side of {quadric:?}: {departure:?}");
        let bound = 2.0 * error * slant + 8.0 * EPS * far;
        assert!(cos > -0.01 || (again - far).abs() <= bound, "{arrival:?}: {again} is not {far}: {departure:?}");
    }
}

fn check_spheres(seed: u64, stretch: f64) {
    let all = visit(seed, SPHERE, stretch, |rng| {
        let p = rng.direction();
        (p, p)
    });
    let mut found = 0;
    for ((quadric, arrival), departure) in all.quadrics.iter().zip(&all.arrivals).zip(&all.departures) {
        if departure.found == 1 {
            found += 1;
            check_sphere(quadric, arrival, departure);
        }
    }
    assert!(found > COUNT * 8 / 10, "{found}");
}

#[test]
fn rays_leave_spheres_outwards_and_cross_them_inwards() {
    check_spheres(2, 1.0 + 1e-9);
}

#[test]
fn rays_leave_ellipsoids_outwards_and_cross_them_inwards() {
    check_spheres(3, 10.0);
}

#[test]
fn rays_that_leave_a_disk_do_not_meet_it_again() {
    let all = visit(4, DISK, 10.0, |rng| {
        let (r, phi) = (rng.unit().sqrt(), rng.range(0.0, std::f64::consts::TAU));
        (DVec3::new(r * phi.cos(), r * phi.sin(), 0.0), DVec3::Z)
    });
    let mut found = 0;
    for ((quadric, arrival), departure) in all.quadrics.iter().zip(&all.arrivals).zip(&all.departures) {
        if departure.found == 0 {
            continue;
        }
        found += 1;
        let render_from_object = affine(quadric.render_from_object);
        let normal = render_from_object.matrix3.x_axis.cross(render_from_object.matrix3.y_axis).normalize();
        let height = (double(departure.position) - render_from_object.translation).dot(normal).abs();
        let bound = normal.abs().element_sum() * f64::from(departure.error);
        assert!(height <= bound, "{departure:?} is {height:e} off the disk");
        assert!(double(departure.normal).cross(normal).length() < 1e-4, "{departure:?} has no normal {normal}");
        assert!(departure.t_again < 0.0, "{arrival:?} meets {quadric:?} again: {departure:?}");
        assert_offset(arrival, departure);
    }
    assert!(found > COUNT * 8 / 10, "{found}");
}
