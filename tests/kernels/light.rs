//! light.glsl: next-event estimation finds every direction to a light with the pdf it says.

use std::f64::consts::{PI, TAU};

use bytemuck::Zeroable;
use glam::{DAffine3, DMat3, DVec3};

use crate::fixture::{EPS, Fixture, Rng, double, frame, single};
use crate::generated::{
    AREA, DISK, KIND_SHIFT, Light, NONE, Quadric, SPHERE, SceneArrays, SeeLights, Seen, TRIANGLE, Viewpoint,
};
use crate::statistics::assert_near;
use crate::world::{World, quadric, triangle};

/// Samples per axis of the unit square.
const GRID: usize = 512;

pub fn see(world: &World, viewpoints: &[Viewpoint]) -> Vec<Seen> {
    let fixture = Fixture::new();
    let world = world.upload(&fixture);
    let (viewpoints, seen) = (fixture.upload(viewpoints), fixture.output(viewpoints.len()));
    fixture
        .run(&SeeLights { scene: world.bindings(), viewpoints: &viewpoints, seen: &seen }, viewpoints.len() as usize);
    fixture.read(&seen)
}

/// The middles of a grid of cells over the square of random numbers.
pub fn grid_from(from: DVec3, light: u32) -> Vec<Viewpoint> {
    let middle = |i: usize| (i as f32 + 0.5) / GRID as f32;
    let view = |i: usize| Viewpoint {
        from: single(from),
        u_light: middle(i / GRID),
        u: [middle(i % GRID), middle(i / GRID)],
        light,
        pad0: 0.0,
    };
    (0..GRID * GRID).map(view).collect()
}

const EMISSION: [f32; 3] = [1.0, 2.0, 3.0];

/// A world of one area light on the first primitive of a kind.
fn lit(kind: u32, area: f64, world: World) -> World {
    let light = Light {
        emission: EMISSION,
        kind: AREA,
        primitive: kind << KIND_SHIFT,
        area: area as f32,
        direct_pmf: 1.0,
        emission_pmf: 1.0,
        image: NONE,
        ..Light::zeroed()
    };
    World { arrays: SceneArrays { lights: vec![light], ..world.arrays }, ..world }
}

/// Integrals over solid angle of 1, the direction w, and (w . AXIS)^2.
#[derive(Clone, Copy, Debug, Default)]
pub struct Moments {
    solid_angle: f64,
    direction: DVec3,
    square: f64,
}

const AXIS: DVec3 = DVec3::new(0.48, 0.6, 0.64);

impl Moments {
    fn add(&mut self, w: DVec3, weight: f64) {
        self.solid_angle += weight;
        self.direction += weight * w;
        self.square += weight * w.dot(AXIS).powi(2);
    }

    /// Panics unless these are those, relative to the solid angle.
    pub fn assert_are(&self, exact: &Self, tolerance: f64, what: &str) {
        let errors = [
            self.solid_angle - exact.solid_angle,
            (self.direction - exact.direction).length(),
            self.square - exact.square,
        ];
        let worst = errors.map(|error| error.abs() / exact.solid_angle).into_iter().fold(0.0, f64::max);
        assert!(worst <= tolerance, "{what}: {self:?} is not {exact:?}, off by {worst:e}");
    }
}

/// What the samples estimate: means of f / pdf.
pub fn estimate(seen: &[Seen]) -> Moments {
    let mut moments = Moments::default();
    for seen in seen.iter().filter(|seen| seen.pdf > 0.0) {
        moments.add(double(seen.wi), 1.0 / (f64::from(seen.pdf) * (GRID * GRID) as f64));
    }
    moments
}

/// The same over a surface: cos dA / r^2 of the elements that face the viewpoint, or of all
/// from inside. `element` gives a point and its area vector for each cell of the square.
pub fn integrate(from: DVec3, one_sided: bool, element: impl Fn(f64, f64) -> (DVec3, DVec3)) -> Moments {
    const STEPS: usize = 1000;
    let mut moments = Moments::default();
    for i in 0..STEPS * STEPS {
        let middle = |i: usize| (i as f64 + 0.5) / STEPS as f64;
        let (point, area) = element(middle(i % STEPS), middle(i / STEPS));
        let to = point - from;
        let projected = -to.dot(area) / to.length().powi(3);
        let weight = if one_sided { projected.max(0.0) } else { projected.abs() };
        moments.add(to.normalize(), weight / (STEPS * STEPS) as f64);
    }
    moments
}

/// A cell of the whole unit sphere under a transform.
fn sphere_element(transform: &DAffine3, u: f64, v: f64) -> (DVec3, DVec3) {
    let (z, phi) = (2.0 * u - 1.0, TAU * v);
    let r = (1.0 - z * z).sqrt();
    let p = DVec3::new(r * phi.cos(), r * phi.sin(), z);
    let cofactors = transform.matrix3.determinant().abs() * transform.matrix3.inverse().transpose();
    (transform.transform_point3(p), 4.0 * PI * (cofactors * p))
}

fn ellipsoid(axes: DVec3, center: DVec3) -> DAffine3 {
    let turn = DMat3::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 1.0);
    let back = DMat3::from_axis_angle(DVec3::new(0.0, 0.6, 0.8), 2.0);
    DAffine3 { matrix3: turn * DMat3::from_diagonal(axes) * back, translation: center }
}

fn sphere_world(transform: &DAffine3) -> World {
    let sphere = Quadric { light: 0, ..quadric(transform) };
    lit(SPHERE, 0.0, World::of(SceneArrays { quadrics: vec![sphere], ..SceneArrays::default() }))
}

fn assert_sphere_seen(transform: &DAffine3, from: DVec3, tolerance: f64) {
    let seen = see(&sphere_world(transform), &grid_from(from, 0));
    let inside = transform.inverse().transform_point3(from).length() < 1.0;
    let exact = if inside {
        Moments { solid_angle: 4.0 * PI, direction: DVec3::ZERO, square: 4.0 * PI / 3.0 }
    } else {
        integrate(from, true, |u, v| sphere_element(transform, u, v))
    };
    let what = format!("from {from} to {transform:?}");
    estimate(&seen).assert_are(&exact, tolerance, &what);
    for seen in seen.iter().filter(|seen| seen.pdf > 0.0) {
        // Radiance leaves the outside only.
        let expected = if inside { [0.0; 3] } else { EMISSION };
        assert!(seen.radiance == expected || grazes(seen), "{what}: {seen:?}");
    }
}

/// Whether a sample is at the rim of its light, where its pdf may be off.
fn grazes(seen: &Seen) -> bool {
    f64::from((seen.pdf_of_hit - seen.pdf).abs()) > 1e-3 * f64::from(seen.pdf)
}

/// The mean of 1 / pdf over an even grid converges with its square; 2e-4 leaves room for
/// the rim, where rounding loses samples.
#[test]
fn a_sphere_light_is_sampled_over_the_solid_angle_it_fills() {
    let sphere = ellipsoid(DVec3::splat(0.2), DVec3::new(0.1, -0.3, 0.2));
    for from in [DVec3::new(0.1, -0.3, 0.45), DVec3::new(0.9, 0.8, -0.7), DVec3::new(-0.5, -0.3, 0.2)] {
        assert_sphere_seen(&sphere, from, 2e-4);
        let distance2 = from.distance_squared(sphere.translation);
        let closed = TAU * (1.0 - (1.0 - 0.04 / distance2).sqrt());
        let exact = integrate(from, true, |u, v| sphere_element(&sphere, u, v));
        assert_near(exact.solid_angle, closed, 1e-4, "the twin");
    }
}

#[test]
fn an_ellipsoid_light_is_sampled_over_the_solid_angle_it_fills() {
    let body = ellipsoid(DVec3::new(0.3, 0.1, 0.05), DVec3::new(0.1, -0.3, 0.2));
    for from in [DVec3::new(0.1, 0.2, 0.5), DVec3::new(0.9, 0.8, -0.7), DVec3::new(-0.5, -0.3, 0.2)] {
        assert_sphere_seen(&body, from, 2e-4);
    }
}

#[test]
fn a_sphere_light_surrounds_a_point_inside_it() {
    for axes in [DVec3::splat(0.8), DVec3::new(0.9, 0.3, 0.5)] {
        let body = ellipsoid(axes, DVec3::new(0.1, 0.0, 0.0));
        for from in [DVec3::new(0.1, 0.0, 0.0), DVec3::new(0.2, 0.1, 0.05)] {
            assert_sphere_seen(&body, from, 5e-4);
        }
    }
}

/// A radius of 1e-4 or 1e-3 at distance 1: fp32 knows directions to 1 to 2 EPS, of the
/// cone's radius 6e-4 or 6e-5, and loses samples in a rim so wide.
#[test]
fn tiny_sphere_lights_keep_their_solid_angle() {
    for (radius, tolerance) in [(1e-3, 5e-4), (1e-4, 4e-3)] {
        let center = DVec3::new(0.3, -0.4, 0.2);
        let from = center + DVec3::new(0.48, 0.6, 0.64);
        let seen = see(&sphere_world(&ellipsoid(DVec3::splat(radius), center)), &grid_from(from, 0));
        // 1 - sqrt(1 - x) without cancellation.
        let exact = TAU * radius * radius / (1.0 + (1.0 - radius * radius).sqrt());
        assert_near(estimate(&seen).solid_angle, exact, tolerance, &format!("radius {radius}"));
    }
}

/// From outside, what a cut leaves of both sides; the twin tests directions of the cone.
#[test]
fn a_cut_sphere_light_is_sampled_where_it_is() {
    let transform = ellipsoid(DVec3::new(0.3, 0.2, 0.25), DVec3::ZERO);
    let mut world = sphere_world(&transform);
    world.quadrics[0].z_min = -0.3;
    world.quadrics[0].z_max = 0.6;
    world.quadrics[0].phi_max = 4.0;
    for from in [DVec3::new(0.5, 0.3, 0.6), DVec3::new(-0.7, 0.4, -0.2), DVec3::new(0.1, -0.9, 0.3)] {
        let exact = cut_sphere_moments(&transform, &world.quadrics[0], from);
        let seen = see(&world, &grid_from(from, 0));
        // Both grids see the edges of the cuts to a cell.
        estimate(&seen).assert_are(&exact, 3e-3, &format!("from {from}"));
    }
}

fn cut_sphere_moments(transform: &DAffine3, sphere: &Quadric, from: DVec3) -> Moments {
    const STEPS: usize = 800;
    let o = transform.inverse().transform_point3(from);
    let axis = -o.normalize();
    let (s, t) = frame(axis);
    let height = 1.0 - (1.0 - 1.0 / o.length_squared()).sqrt();
    let is_inside = |p: DVec3| {
        let phi = p.y.atan2(p.x).rem_euclid(TAU);
        p.z >= sphere.z_min.into() && p.z <= sphere.z_max.into() && phi <= sphere.phi_max.into()
    };
    let mut moments = Moments::default();
    for i in 0..STEPS * STEPS {
        let (u, v) = ((i % STEPS) as f64 + 0.5, (i / STEPS) as f64 + 0.5);
        let (cos, phi) = (1.0 - height * u / STEPS as f64, TAU * v / STEPS as f64);
        let sin = (1.0 - cos * cos).sqrt();
        let d = cos * axis + sin * (phi.cos() * s + phi.sin() * t);
        let closest = -o.dot(d);
        let half = (1.0 - (o + closest * d).length_squared()).max(0.0).sqrt();
        if is_inside(o + (closest - half) * d) || is_inside(o + (closest + half) * d) {
            let w = transform.matrix3 * d;
            // Solid angles grow by det / |M d|^3.
            let growth = transform.matrix3.determinant().abs() / w.length().powi(3);
            moments.add(w.normalize(), growth * TAU * height / (STEPS * STEPS) as f64);
        }
    }
    moments
}

#[test]
fn a_triangle_light_is_sampled_over_the_solid_angle_it_fills() {
    let corners = [[0.1, 0.2, -0.3], [0.5, 0.1, -0.2], [0.2, 0.6, 0.1]];
    let [p0, p1, p2] = corners.map(double);
    let area = 0.5 * (p1 - p0).cross(p2 - p0);
    let shape = crate::generated::Triangle { light: 0, ..triangle(corners) };
    let world =
        lit(TRIANGLE, area.length(), World::of(SceneArrays { triangles: vec![shape], ..SceneArrays::default() }));
    for (from, front) in [(DVec3::new(0.7, -0.5, 0.6), true), (DVec3::new(-0.3, 0.8, -0.7), false)] {
        // The unit square folded along its diagonal covers the triangle twice.
        let exact = integrate(from, false, |u, v| {
            let (b1, b2) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            (p0 + b1 * (p1 - p0) + b2 * (p2 - p0), area)
        });
        assert_eq!((from - p0).dot(area) > 0.0, front, "the viewpoint is on the wrong side");
        assert_flat_seen(&world, from, front, &exact);
    }
}

#[test]
fn a_disk_light_is_sampled_over_the_solid_angle_it_fills() {
    let transform = ellipsoid(DVec3::new(0.4, 0.3, 0.2), DVec3::new(0.1, 0.2, 0.3));
    let matrix = transform.matrix3;
    let normal = matrix.x_axis.cross(matrix.y_axis);
    for (inner_radius, phi_max) in [(0.0_f32, TAU as f32), (0.5, TAU as f32), (0.25, 2.0)] {
        let (inner2, phi_max64) = (f64::from(inner_radius).powi(2), f64::from(phi_max));
        let area = 0.5 * phi_max64 * (1.0 - inner2) * normal;
        let shape = Quadric { light: 0, inner_radius, phi_max, ..quadric(&transform) };
        let world =
            lit(DISK, area.length(), World::of(SceneArrays { quadrics: vec![shape], ..SceneArrays::default() }));
        for side in [1.0, -1.0] {
            let from = transform.translation + side * (0.5 * normal.normalize() + DVec3::new(0.1, -0.2, 0.0));
            let exact = integrate(from, false, |u, v| {
                let (r, phi) = ((inner2 + u * (1.0 - inner2)).sqrt(), phi_max64 * v);
                (transform.transform_point3(DVec3::new(r * phi.cos(), r * phi.sin(), 0.0)), area)
            });
            let front = (from - transform.translation).dot(normal) > 0.0;
            assert_flat_seen(&world, from, front, &exact);
        }
    }
}

fn assert_flat_seen(world: &World, from: DVec3, front: bool, exact: &Moments) {
    let seen = see(world, &grid_from(from, 0));
    estimate(&seen).assert_are(exact, 2e-4, &format!("from {from}"));
    let expected = if front { EMISSION } else { [0.0; 3] };
    assert!(seen.iter().all(|seen| seen.radiance == expected), "radiance on the wrong side from {from}");
    let mut two_sided = world.clone();
    two_sided.lights[0].two_sided = 1;
    let seen = see(&two_sided, &grid_from(from, 0));
    assert!(seen.iter().all(|seen| seen.radiance == EMISSION), "a two-sided light is dark from {from}");
}

/// Multiple importance sampling asks for the pdf of points that other rays find.
#[test]
fn the_pdf_of_a_point_is_that_of_its_sample() {
    let body = ellipsoid(DVec3::new(0.3, 0.1, 0.2), DVec3::new(0.1, -0.3, 0.2));
    let corners = [[0.1, 0.2, -0.3], [0.5, 0.1, -0.2], [0.2, 0.6, 0.1]];
    let shape = crate::generated::Triangle { light: 0, ..triangle(corners) };
    let worlds = [
        sphere_world(&body),
        lit(TRIANGLE, 0.1, World::of(SceneArrays { triangles: vec![shape], ..SceneArrays::default() })),
        lit(
            DISK,
            0.2,
            World::of(SceneArrays { quadrics: vec![Quadric { light: 0, ..quadric(&body) }], ..SceneArrays::default() }),
        ),
    ];
    for mut world in worlds {
        world.lights[0].direct_pmf = 0.25;
        let seen = see(&world, &grid_from(DVec3::new(0.8, -0.6, 0.9), 0));
        let unlike = seen.iter().filter(|seen| (seen.pdf_of_hit - seen.pdf).abs() > 1e-5 * seen.pdf).count();
        // A ray to the very edge of a light may pass it.
        assert!(unlike < seen.len() / 1000, "{unlike} samples have another pdf when they are hit");
    }
}

const MANY_LIGHTS: &str = r#"
WorldBegin
LightSource "point" "rgb I" [1 2 3] "point3 from" [.5 .6 -.7]
LightSource "spot" "rgb I" [30 20 10] "point3 from" [-1 1 0] "point3 to" [0 0 0] "float coneangle" 40 "float conedeltaangle" 15
LightSource "distant" "rgb L" [2 2 1] "point3 from" [0 0 0] "point3 to" [1 -2 2]
LightSource "infinite" "rgb L" [.1 .2 .3]
AttributeBegin
AreaLightSource "diffuse" "rgb L" [5 4 3]
Shape "disk" "float radius" .5 "float height" 1
AttributeEnd
Shape "sphere" "float radius" .3
"#;

/// The choice goes by power, and each delta light gives what reaches the point from it.
#[test]
fn lights_are_chosen_with_their_pmf() {
    let (world, _) = World::parse(MANY_LIGHTS);
    let mut rng = Rng(1);
    let mut views = grid_from(DVec3::ZERO, NONE);
    for view in &mut views {
        view.u_light = rng.unit_f32();
        view.from = single(rng.cube(0.5));
    }
    let mut counts = vec![0.0; world.lights.len()];
    for (view, seen) in views.iter().zip(see(&world, &views)) {
        let chosen = world.lights.iter().position(|light| light.kind != AREA && light.direct_pmf == seen.pdf);
        let Some(chosen) = chosen else {
            let area = world.lights.iter().position(|light| light.kind == AREA).expect("an area light");
            counts[area] += 1.0;
            continue;
        };
        counts[chosen] += 1.0;
        assert_eq!(seen.uses_mis, 0, "BSDF sampling does not find {seen:?}");
        assert_delta_light(&world, &world.lights[chosen], double(view.from), &seen);
    }
    for (light, count) in world.lights.iter().zip(counts) {
        let (pmf, n) = (f64::from(light.direct_pmf), views.len() as f64);
        let limit = 6.0 * (pmf * (1.0 - pmf) * n).sqrt();
        assert!((count - pmf * n).abs() <= limit, "{light:?} is chosen {count} of {n} times");
    }
}

fn assert_delta_light(world: &World, light: &Light, from: DVec3, seen: &Seen) {
    let (wi, radiance) = if light.kind == crate::generated::DISTANT {
        let target = double(seen.target) - from;
        assert!(target.length() > 1.99 * f64::from(world.info.radius), "{seen:?} ends inside the scene");
        assert!(target.normalize().distance(-double(light.direction)) < 1e-6, "{seen:?} does not aim at {light:?}");
        (-double(light.direction), double(light.emission))
    } else {
        let to = double(light.position) - from;
        assert_eq!(seen.target, light.position);
        let mut radiance = double(light.emission) / to.length_squared();
        if light.kind == crate::generated::SPOT {
            let one_minus_cos = 1.0 + to.normalize().dot(double(light.direction));
            let [start, end] = [light.falloff_start, light.falloff_end].map(f64::from);
            let x = ((end - one_minus_cos) / (end - start)).clamp(0.0, 1.0);
            radiance *= x * x * (3.0 - 2.0 * x);
        }
        (to.normalize(), radiance)
    };
    assert!(double(seen.wi).distance(wi) < 16.0 * EPS, "{seen:?} does not aim at {light:?}");
    // Cosines and distances are 4 EPS off; the falloff has a slope of 1.5 over its width.
    let error = (double(seen.radiance) - radiance).length() / double(light.emission).length();
    assert!(error < 2e-5, "{seen:?} is not {radiance} of {light:?}");
}
