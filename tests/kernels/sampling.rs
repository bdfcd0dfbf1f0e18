//! sampling.glsl: distributions and domains of points and directions.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use crate::fixture::{EPS, Fixture, Rng, double, frame, single};
use crate::generated::{Draw, DrawSamples, Drawn};
use crate::statistics::{assert_near, assert_quantiles, assert_uniform, cells};

const COUNT: usize = 1 << 18;

fn draw(draws: &[Draw]) -> Vec<Drawn> {
    let fixture = Fixture::new();
    let (draws, drawn) = (fixture.upload(draws), fixture.output(draws.len()));
    fixture.run(&DrawSamples { draws: &draws, drawn: &drawn }, draws.len() as usize);
    fixture.read(&drawn)
}

/// Draws with random numbers, a few of them at the ends of their range.
fn random_draws(mut normal: impl FnMut(&mut Rng) -> DVec3, one_minus_z_min: f32) -> Vec<Draw> {
    let mut rng = Rng(1);
    (0..COUNT)
        .map(|_| {
            let normal = single(normal(&mut rng).normalize());
            Draw { u: [rng.unit_f32(), rng.unit_f32()], one_minus_z_min, pad0: 0.0, normal, pad1: 0.0 }
        })
        .collect()
}

fn azimuth(x: f64, y: f64) -> f64 {
    y.atan2(x).rem_euclid(TAU) / TAU
}

/// The sine and cosine are at most 1.5 ulp off on lavapipe, 2^-21 on GPUs.
const TRIGONOMETRY: f64 = 5e-7;

#[test]
fn disk_samples_are_uniform_on_the_disk() {
    let drawn = draw(&random_draws(|_| DVec3::Z, 1.0));
    let points = drawn.iter().map(|drawn| DVec2::from(drawn.disk.map(f64::from)));
    assert!(points.clone().all(|p| p.length() <= 1.0 + TRIGONOMETRY), "a point outside the disk");
    let uniform = points.map(|p| [p.length_squared().min(1.0), azimuth(p.x, p.y)]);
    assert_uniform(&cells(uniform, 32), "squared radius and azimuth");
}

/// Shirley and Chiu map concentric squares to circles: strata keep their size and stay
/// together, unlike in polar coordinates. Centre and corners are the hard inputs.
#[test]
fn the_disk_map_takes_squares_to_circles() {
    let at = |x: f32, y: f32| Draw { u: [x, y], one_minus_z_min: 1.0, pad0: 0.0, normal: [0.0, 0.0, 1.0], pad1: 0.0 };
    let mut rng = Rng(2);
    let mut draws: Vec<_> = (0..100_000).map(|_| at(rng.unit_f32(), rng.unit_f32())).collect();
    for x in [0.0, 0.5, 1.0 - f32::EPSILON / 2.0] {
        for y in [0.0, 0.5, 1.0 - f32::EPSILON / 2.0] {
            draws.push(at(x, y));
        }
    }
    for (draw, drawn) in draws.iter().zip(draw(&draws)) {
        let [x, y] = draw.u.map(|u| 2.0 * f64::from(u) - 1.0);
        let radius = x.abs().max(y.abs());
        let point = DVec2::from(drawn.disk.map(f64::from));
        assert!((point.length() - radius).abs() <= TRIGONOMETRY, "{draw:?}: {point}");
        // Sides of the square go to quarters of the circle, linearly in the angle.
        if radius > 1e-3 {
            let along = if x.abs() > y.abs() { y / x } else { x / y };
            let ray = if x.abs() > y.abs() { DVec2::X * x.signum() } else { DVec2::Y * y.signum() };
            let angle = ray.angle_to(point).abs();
            assert!((angle - PI / 4.0 * along.abs()).abs() <= TRIGONOMETRY / radius, "{draw:?}: {point}");
            assert!(point.x * x >= -1e-6 && point.y * y >= -1e-6, "{draw:?} changes its quadrant: {point}");
        }
    }
}

#[test]
fn triangle_samples_are_uniform_on_the_triangle() {
    let drawn = draw(&random_draws(|_| DVec3::Z, 1.0));
    let mut mean = DVec2::ZERO;
    let uniform: Vec<_> = drawn
        .iter()
        .map(|drawn| {
            let [b1, b2] = drawn.triangle.map(f64::from);
            assert!(b1 >= 0.0 && b2 >= 0.0 && b1 + b2 <= 1.0, "{b1} {b2} is no point of the triangle");
            mean += DVec2::new(b1, b2) / COUNT as f64;
            // The share of the triangle beyond b0, and the place along the line of equal b0.
            let rest = b1 + b2;
            [rest * rest, b1 / rest.max(1e-30)]
        })
        .collect();
    assert_uniform(&cells(uniform, 32), "barycentrics");
    // The standard deviation of a barycentric is sqrt(1/18).
    let limit = 6.0 * (1.0_f64 / 18.0).sqrt() / (COUNT as f64).sqrt();
    assert!((mean - DVec2::splat(1.0 / 3.0)).abs().max_element() <= limit, "{mean}");
}

#[test]
fn cosine_samples_have_pdf_cosine_over_pi() {
    for normal in [DVec3::Z, DVec3::NEG_Z, DVec3::X, DVec3::new(1.0, -2.0, -0.5), DVec3::new(1e-4, 0.0, -1.0)] {
        let draws = random_draws(|_| normal, 1.0);
        let n = double(draws[0].normal);
        let (s, t) = frame(n);
        let mut mean = 0.0;
        let uniform: Vec<_> = draw(&draws)
            .iter()
            .map(|drawn| {
                let w = double(drawn.cosine);
                assert!((w.length() - 1.0).abs() <= 2.0 * TRIGONOMETRY, "{w} is no unit vector");
                let cos = w.dot(n);
                assert!(cos >= -1e-7, "{w} is below the surface {n}");
                mean += cos / COUNT as f64;
                [(cos * cos).min(1.0), azimuth(w.dot(s), w.dot(t))]
            })
            .collect();
        assert_uniform(&cells(uniform, 32), "squared cosine and azimuth");
        // The mean cosine is 2/3, its variance 1/18.
        assert_near(mean, 2.0 / 3.0, 9.0 * (1.0_f64 / 18.0 / COUNT as f64).sqrt(), "mean cosine");
    }
}

/// In a cap that is nearly a plane, 1 - z has few digits left but the sine keeps them all.
#[test]
fn cap_samples_are_uniform_from_tiny_caps_to_the_sphere() {
    for height in [1e-12_f32, 1e-7, 1e-3, 0.5, 1.0, 1.9, 2.0] {
        let whole = f64::from(height);
        let draws = random_draws(|_| DVec3::Z, height);
        let uniform: Vec<_> = draw(&draws)
            .iter()
            .map(|drawn| {
                let w = double(drawn.cap);
                assert!((w.length() - 1.0).abs() <= TRIGONOMETRY, "{w} is no unit vector");
                // sin^2 = (1 - z)(1 + z), solved for 1 - z on the upper half.
                let sin2 = w.truncate().length_squared();
                let below = if w.z > 0.0 { sin2 / (1.0 + (1.0 - sin2).max(0.0).sqrt()) } else { 1.0 - w.z };
                assert!(below <= whole * (1.0 + 4.0 * TRIGONOMETRY), "{w} is outside the cap of {height}");
                [(below / whole).min(1.0), azimuth(w.x, w.y)]
            })
            .collect();
        assert_uniform(&cells(uniform.clone(), 32), &format!("cap of {height}"));
        assert_quantiles(uniform.iter().map(|[height, _]| *height).collect(), &format!("cap of {height}"));
    }
}

/// Products of unit components: three roundings and the error of n's own length each.
#[test]
fn frames_are_orthonormal_and_right_handed() {
    let mut toggle = 0;
    let draws = random_draws(
        |rng| {
            toggle += 1;
            let mut n = rng.direction();
            match toggle % 4 {
                0 => n = n.normalize().with_z(-1.0 / rng.log_range(1e-7, 1.0)),
                1 => n.z *= rng.log_range(1e-12, 1.0),
                _ => {}
            }
            n
        },
        1.0,
    );
    let mut draws = draws;
    for n in [[0.0, 0.0, -1.0], [0.0, 0.0, 1.0], [1.0, 0.0, -0.0], [-0.0, 1.0, 0.0], [0.0, -1.0, -0.0]] {
        draws.push(Draw { u: [0.5; 2], one_minus_z_min: 1.0, pad0: 0.0, normal: n, pad1: 0.0 });
    }
    for (draw, drawn) in draws.iter().zip(draw(&draws)) {
        let (n, s, t) = (double(draw.normal), double(drawn.s), double(drawn.t));
        let errors = [s.dot(n), t.dot(n), s.dot(t), s.length() - 1.0, t.length() - 1.0];
        assert!(errors.iter().all(|error| error.abs() <= 8.0 * EPS), "{n}: {s} {t} {errors:?}");
        assert!(s.cross(t).distance(n) <= 16.0 * EPS, "{n}: {s} {t} is left-handed");
    }
}
