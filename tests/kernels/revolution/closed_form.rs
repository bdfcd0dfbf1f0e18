//! The oracle against closed forms: quadrics, by profiles of several degrees.

use bytemuck::Zeroable;
use glam::{DVec2, DVec3};

use crate::fixture::{Rng, double, single};
use crate::generated::RevolutionPiece;
use crate::revolution::line::Line;
use crate::revolution::oracle::{Oracle, Root};
use crate::revolution::profiles::{self, Profile};
use crate::revolution::rays::{self, Extent};
use crate::world::World;

const COUNT: usize = 30_000;

/// The surface x^2 + y^2 = f(z) = square z^2 + slope z + constant between two heights.
struct Quadric {
    square: f64,
    slope: f64,
    constant: f64,
    heights: [f64; 2],
}

/// A profile (u, v) given by powers of s in [from, from + 2 half], as one piece. All numbers
/// are short: the coefficients are exact.
fn piece(u: &[f64], v: &[f64], from: f64, half: f64) -> RevolutionPiece {
    // The powers of x, where s = from + half (x + 1).
    let shift = |powers: &[f64]| {
        let mut shifted = [0.0; 9];
        for power in powers.iter().rev() {
            for i in (0..9).rev() {
                let lower = if i > 0 { shifted[i - 1] * half } else { *power };
                shifted[i] = shifted[i] * (from + half) + lower;
            }
        }
        shifted
    };
    let (u, v) = (shift(u), shift(v));
    let mut coefficients = [[0.0; 4]; 5];
    for i in 0..9 {
        for (j, c) in [u[i], v[i]].into_iter().enumerate() {
            coefficients[i / 2][2 * (i % 2) + j] = c as f32;
            assert_eq!(f64::from(c as f32), c, "a coefficient is not exact");
        }
    }
    let end = |powers: [f64; 9], x: f64| powers.iter().rev().fold(0.0, |sum, c| sum * x + c) as f32;
    RevolutionPiece {
        ends: [end(u, -1.0), end(v, -1.0), end(u, 1.0), end(v, 1.0)],
        coefficients,
        ..RevolutionPiece::zeroed()
    }
}

/// Eight pieces over s in [0, 1].
fn body(u: &[f64], v: &[f64]) -> Oracle {
    let pieces: Vec<_> = (0..8).map(|i| piece(u, v, f64::from(i) / 8.0, 1.0 / 16.0)).collect();
    Oracle::new(&pieces, [1.0, 1.0])
}

impl Quadric {
    /// Both roots in order, if they are real: k from the closest approach to a point inside,
    /// and the cosine.
    fn roots(&self, o: DVec3, d: DVec3) -> Vec<(f64, f64)> {
        let height = 0.5 * (self.heights[0] + self.heights[1]);
        let center = DVec3::Z * height;
        let start = (center - o).dot(d) / d.length_squared();
        let p = o + start * d;
        let value = |z: f64| (self.square * z + self.slope) * z + self.constant;
        let rise = 2.0 * self.square * p.z + self.slope;
        let a = d.truncate().length_squared() - self.square * d.z * d.z;
        let b = p.truncate().dot(d.truncate()) - 0.5 * rise * d.z;
        let c = p.truncate().length_squared() - value(p.z);
        let discriminant = b * b - a * c;
        if discriminant < 0.0 {
            return Vec::new();
        }
        // Without cancellation.
        let q = -b - b.signum() * discriminant.sqrt();
        let mut roots: Vec<_> = [q / a, c / q]
            .into_iter()
            .filter(|k| k.is_finite())
            .map(|k| {
                let at = p + k * d;
                let normal = DVec3::new(at.x, at.y, -self.square * at.z - 0.5 * self.slope).normalize();
                (start + k, normal.dot(d.normalize()))
            })
            .collect();
        roots.sort_by(|a, b| a.0.total_cmp(&b.0));
        roots
    }

    fn assert_roots(&self, what: &str, oracle: &Oracle, o: DVec3, d: DVec3) -> usize {
        let found = oracle.solve(&Line::new(o, d));
        let expected = self.roots(o, d);
        let near_end = |z: f64| self.heights.iter().any(|end| (z - end).abs() < 1e-4);
        let height = |k: f64| o.z + k * d.z;
        let inside = |z: f64| z > self.heights[0] && z < self.heights[1];
        if expected.iter().any(|(k, cosine)| near_end(height(*k)) || cosine.abs() < 1e-3) {
            return 0;
        }
        let expected: Vec<_> = expected.into_iter().filter(|(k, _)| inside(height(*k))).collect();
        assert_eq!(found.len(), expected.len(), "{what}: {o} {d}: {found:?} is not {expected:?}");
        for (Root { k, cosine, at_seam, required }, (k1, cosine1)) in found.iter().zip(&expected) {
            // A seam has its root to 2e-6 of the profile, and its cosine from either end.
            let error = if *at_seam { 4e-6 / cosine1.abs() } else { 1e-13 * (1.0 + o.length()) / cosine1.abs() };
            assert!((k - k1).abs() * d.length() <= error, "{what}: {o} {d}: {k} is not {k1}");
            let error = if *at_seam { 1e-4 } else { 1e-9 };
            assert!((cosine - cosine1).abs() <= error, "{what}: {o} {d}: {cosine} is not {cosine1}");
            assert!(required, "{what}: {o} {d}: {k} is not required");
        }
        found.len()
    }
}

/// A ray at the box |x|, |y| <= 1, 0 <= z <= 1 from near and far, of any slope.
fn any_ray(rng: &mut Rng) -> (DVec3, DVec3) {
    let target = DVec3::new(rng.range(-1.0, 1.0), rng.range(-1.0, 1.0), rng.range(0.0, 1.0));
    let mut direction = rng.direction();
    let around = DVec2::from_angle(rng.range(0.0, std::f64::consts::TAU));
    match rng.below(6) {
        0 => direction = around.extend(rng.log_range(1e-9, 1e-1)),
        1 => direction = around.extend(0.0),
        2 => direction = (around * rng.log_range(1e-9, 1e-1)).extend(-1.0),
        _ => {}
    }
    let direction = double(single(direction * rng.log_range(0.1, 10.0)));
    let origin = target - rng.log_range(0.1, 100.0) * direction;
    (double(single(origin)), direction)
}

/// Along a ray, entering and leaving a closed surface alternate: none is missed in between.
/// Rays do not count that touch it, or that graze a seam, where it is open by a rounding.
#[test]
fn the_oracle_enters_and_leaves_closed_bodies_in_turn() {
    let closed = |profile: &Profile| {
        let (first, last) = (profile.points[0], profile.points[profile.points.len() - 1]);
        (first[0] == 0.0 && last[0] == 0.0) || first == last
    };
    let mut rng = Rng(2);
    let mut bodies = Vec::from(profiles::reference());
    bodies.extend([1e-1, 1e-3, 1e-5].map(profiles::vase));
    bodies.extend(profiles::special().into_iter().filter(closed));
    for profile in bodies {
        let (world, _) = World::parse(&profile.scene(""));
        let oracle = Oracle::new(&world.revolution_pieces, [1.0, 1.0]);
        let extent = Extent { radius: 1.0, height: 1.0 };
        let mut counted = 0;
        for i in 0..COUNT / 2 {
            let (o, d) = rays::draw(rays::KINDS[i % rays::KINDS.len()], &mut rng, &extent, &oracle);
            let roots = oracle.solve(&Line::new(double(single(o)), double(single(d))));
            let least = |root: &Root| if root.at_seam { 1e-2 } else { 1e-6 };
            if roots.iter().any(|root| root.cosine.abs() < least(root) || !root.required) {
                continue;
            }
            let turns = roots.windows(2).all(|pair| pair[0].cosine * pair[1].cosine < 0.0);
            let whole = roots.len().is_multiple_of(2);
            assert!(turns && whole, "{}: from {o} along {d}: {roots:#?}", profile.name);
            counted += usize::from(!roots.is_empty());
        }
        assert!(counted > COUNT / 10, "{}: {counted} rays", profile.name);
    }
}

#[test]
fn the_oracle_finds_the_roots_of_quadrics() {
    let cylinder = Quadric { square: 0.0, slope: 0.0, constant: 0.25, heights: [0.0, 1.0] };
    let cone = Quadric { square: 0.25, slope: -0.5, constant: 0.25, heights: [0.0, 1.0] };
    let paraboloid = Quadric { square: 0.0, slope: 1.0, constant: 0.0, heights: [0.0, 1.0] };
    let bodies = [
        ("cylinder", &cylinder, body(&[0.5], &[0.0, 1.0])),
        // Its height is cubic in s.
        ("cylinder of degree 3", &cylinder, body(&[0.5], &[0.0, 0.0, 3.0, -2.0])),
        ("cone", &cone, body(&[0.5, -0.5], &[0.0, 1.0])),
        ("cone of degree 2", &cone, body(&[0.5, -0.25, -0.25], &[0.0, 0.5, 0.5])),
        ("paraboloid", &paraboloid, body(&[0.0, 1.0], &[0.0, 0.0, 1.0])),
        // Singular on the axis.
        ("paraboloid of degree 4", &paraboloid, body(&[0.0, 0.0, 1.0], &[0.0, 0.0, 0.0, 0.0, 1.0])),
    ];
    for (what, quadric, oracle) in bodies {
        let mut rng = Rng(1);
        let mut found = 0;
        for _ in 0..COUNT {
            let (o, d) = any_ray(&mut rng);
            found += quadric.assert_roots(what, &oracle, o, d);
        }
        assert!(found > COUNT / 4, "{what}: {found} roots");
    }
}
