//! An equal-area map between the unit square and the sphere of directions (Clarberg, "Fast
//! Equal-Area Mapping of the (Hemi)Sphere using SIMD", 2008), as pbrt-v4 orients it.
//!
//! The middle of the square is +z, its corners are -z. The diamond |u| + |v| = 1 about the
//! middle is the equator, where u to the right points along +x and v downward along +y.
//! shaders/include/light/light_image.glsl is the same map in fp32.

use std::f64::consts::{FRAC_PI_4, PI};

use glam::{DVec2, DVec3};

/// Returns the unit direction of a point of the unit square.
pub fn direction(place: DVec2) -> DVec3 {
    let signed = 2.0 * place - 1.0;
    let p = signed.abs();
    // Positive in the diamond, which maps to the upper hemisphere.
    let height = 1.0 - (p.x + p.y);
    let r = 1.0 - height.abs();
    let phi = if r == 0.0 { 0.0 } else { FRAC_PI_4 * ((p.y - p.x) / r + 1.0) };
    let sin_theta = r * (2.0 - r * r).max(0.0).sqrt();
    let z = (1.0 - r * r).copysign(height);
    DVec3::new((sin_theta * phi.cos()).copysign(signed.x), (sin_theta * phi.sin()).copysign(signed.y), z)
}

/// Returns the point of the unit square of a unit direction.
pub fn place(direction: DVec3) -> DVec2 {
    let w = direction.abs();
    // The square root of 1 - |z|, without cancellation.
    let r = direction.truncate().length() / (1.0 + w.z).sqrt();
    let turn = w.y.atan2(w.x) * (2.0 / PI);
    let inner = DVec2::new(r * (1.0 - turn), r * turn);
    let p = if direction.z < 0.0 { 1.0 - DVec2::new(inner.y, inner.x) } else { inner };
    0.5 + 0.5 * DVec2::new(p.x.copysign(direction.x), p.y.copysign(direction.y))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid() -> impl Iterator<Item = DVec2> {
        let at = |i: u32| (f64::from(i) + 0.5) / 64.0;
        (0..64 * 64).map(move |i| DVec2::new(at(i % 64), at(i / 64)))
    }

    #[test]
    fn the_map_is_inverted() {
        for p in grid() {
            let w = direction(p);
            assert!((w.length() - 1.0).abs() < 1e-12);
            assert!(place(w).distance(p) < 1e-12, "{p} is {w}, which is at {}", place(w));
        }
    }

    #[test]
    fn areas_are_equal() {
        // Means over the square are means over the sphere.
        let (mut first, mut second) = (DVec3::ZERO, DVec3::ZERO);
        for p in grid() {
            let w = direction(p);
            first += w / 4096.0;
            second += w * w / 4096.0;
        }
        assert!(first.length() < 1e-12 && second.distance(DVec3::splat(1.0 / 3.0)) < 3e-4, "{first} {second}");
    }

    #[test]
    fn axes_lie_where_pbrt_has_them() {
        let at = |x, y| direction(DVec2::new(x, y));
        let near = |a: DVec3, b: DVec3| assert!(a.distance(b) < 1e-12, "{a} is not {b}");
        near(at(0.5, 0.5), DVec3::Z);
        near(at(1.0, 0.5), DVec3::X);
        near(at(0.5, 1.0), DVec3::Y);
        near(at(0.0, 0.5), -DVec3::X);
        near(at(0.5, 0.0), -DVec3::Y);
        near(at(0.0, 1.0), -DVec3::Z);
        let slanted = at(0.75, 0.75);
        assert!(slanted.x > 0.5 && (slanted.x - slanted.y).abs() < 1e-12 && slanted.z.abs() < 1e-12, "{slanted}");
    }
}
