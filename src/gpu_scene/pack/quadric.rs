//! Packing of spheres and disks.

use glam::{DAffine3, DMat3, DVec2, DVec3, Vec3A};
use obvhs::aabb::Aabb;

use super::rows;
use crate::kernels::{DISK, NONE, Quadric};
use crate::scene::Shape;

/// Returns a quadric of a kind (SPHERE or DISK); `render_from_object` is the transform from its unit object
/// space.
pub(super) fn quadric(shape: &Shape, render_from_object: DAffine3, kind: u32) -> Quadric {
    let determinant = render_from_object.matrix3.determinant();
    Quadric {
        object_from_render: rows(&render_from_object.inverse()),
        render_from_object: rows(&render_from_object),
        material: shape.material as u32,
        light: NONE,
        // As in pbrt, the normal of a mirrored quadric is reversed.
        flipped: u32::from(shape.reverse_orientation ^ (determinant < 0.0)),
        z_min: -1.0,
        z_max: 1.0,
        phi_max: std::f32::consts::TAU,
        inner_radius: 0.0,
        determinant: determinant.abs() as f32,
        size: longest_row(&render_from_object),
        kind,
        ..bytemuck::Zeroable::zeroed()
    }
}

/// Returns the length of the longest row of a transform's linear part.
pub fn longest_row(transform: &DAffine3) -> f32 {
    let rows = transform.matrix3.transpose();
    rows.x_axis.length().max(rows.y_axis.length()).max(rows.z_axis.length()) as f32
}

fn linear_part(quadric: &Quadric) -> DMat3 {
    let row = |i: usize| {
        let [x, y, z, _] = quadric.render_from_object[i];
        DVec3::new(f64::from(x), f64::from(y), f64::from(z))
    };
    DMat3::from_cols(row(0), row(1), row(2)).transpose()
}

/// Returns the area of a quadric in square render units. An affine sphere has no closed form: the factor of
/// area is averaged over directions, which is exact for similarities.
pub(super) fn quadric_area(quadric: &Quadric) -> f64 {
    let linear = linear_part(quadric);
    let (phi, z_min, z_max) = (f64::from(quadric.phi_max), f64::from(quadric.z_min), f64::from(quadric.z_max));
    if quadric.kind == DISK {
        let inner = f64::from(quadric.inner_radius);
        return linear.x_axis.cross(linear.y_axis).length() * 0.5 * phi * (1.0 - inner * inner);
    }
    let cofactors = linear.inverse().transpose() * linear.determinant().abs();
    let steps = 64;
    let mut sum = 0.0;
    for i in 0..steps {
        let z = z_min + (z_max - z_min) * (f64::from(i) + 0.5) / f64::from(steps);
        for j in 0..steps {
            let angle = phi * (f64::from(j) + 0.5) / f64::from(steps);
            let point = DVec2::from_angle(angle) * (1.0 - z * z).max(0.0).sqrt();
            sum += (cofactors * point.extend(z)).length();
        }
    }
    sum / f64::from(steps * steps) * phi * (z_max - z_min)
}

/// Returns the box around a transformed unit sphere or disk, widened for rounding.
pub(super) fn quadric_bounds(quadric: &Quadric) -> Aabb {
    let extent = |row: [f32; 4]| {
        let z = if quadric.kind == DISK { 0.0 } else { row[2] };
        DVec3::new(row[0].into(), row[1].into(), z.into()).length() as f32
    };
    let [x, y, z] = quadric.render_from_object;
    let center = Vec3A::new(x[3], y[3], z[3]);
    let half = Vec3A::new(extent(x), extent(y), extent(z));
    let rounding = 4.0 * f32::EPSILON * (center.abs() + half);
    Aabb::new(center - half - rounding, center + half + rounding)
}
