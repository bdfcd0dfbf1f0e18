//! The transforms of pbrt, in f64.

use glam::{DAffine3, DMat3, DMat4, DVec3};

/// Returns the transform from world space to the space of a camera at `eye` that looks at `look`: x right,
/// y up, z forward. `None` if the points coincide or `up` is parallel to their line.
pub(in crate::scene) fn look_at(eye: DVec3, look: DVec3, up: DVec3) -> Option<DAffine3> {
    let forward = (look - eye).try_normalize()?;
    let right = up.try_normalize()?.cross(forward).try_normalize()?;
    let up = forward.cross(right);
    let world_from_camera = DAffine3 { matrix3: DMat3::from_cols(right, up, forward), translation: eye };
    Some(world_from_camera.inverse())
}

/// Returns the rotation by `degrees` about `axis`; `None` if `axis` is 0.
pub(in crate::scene) fn rotate(degrees: f64, axis: DVec3) -> Option<DAffine3> {
    let axis = axis.try_normalize()?;
    Some(DAffine3::from_axis_angle(axis, degrees.to_radians()))
}

/// Returns the matrix of `Transform`, whose numbers are in column order; `None` if it is not affine.
pub(in crate::scene) fn from_numbers(numbers: [f64; 16]) -> Option<DAffine3> {
    let affine = [numbers[3], numbers[7], numbers[11], numbers[15]] == [0.0, 0.0, 0.0, 1.0];
    affine.then(|| DAffine3::from_mat4(DMat4::from_cols_array(&numbers)))
}

/// Returns true if the transform is invertible. The criterion does not depend on scale: it is the volume
/// spanned by unit vectors along the images of the axes.
pub(in crate::scene) fn is_invertible(transform: &DAffine3) -> bool {
    const LEAST_VOLUME: f64 = 1e-12;
    let axes = transform.matrix3;
    let unit = [axes.x_axis, axes.y_axis, axes.z_axis].map(DVec3::try_normalize);
    let [Some(x), Some(y), Some(z)] = unit else {
        return false;
    };
    DMat3::from_cols(x, y, z).determinant().abs() > LEAST_VOLUME && transform.inverse().is_finite()
}

/// Returns true if the transform keeps angles, so that a cone stays round: the images of the axes are
/// orthogonal and of one length.
pub(in crate::scene) fn keeps_angles(transform: &DAffine3) -> bool {
    let axes = transform.matrix3;
    let gram = axes.transpose() * axes;
    let scale = gram.x_axis.x;
    scale > 0.0 && scale.is_finite() && gram.abs_diff_eq(DMat3::from_diagonal(DVec3::splat(scale)), 1e-6 * scale)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn look_at_is_left_handed() {
        let camera = look_at(DVec3::new(0.0, 1.0, 5.0), DVec3::Y, DVec3::Y).unwrap();
        let near = |a: DVec3, b: DVec3| a.distance(b) < 1e-12;
        assert!(near(camera.transform_point3(DVec3::Y), DVec3::Z * 5.0));
        // A camera that looks along -z sees the world's +x at the left.
        assert!(near(camera.transform_vector3(DVec3::X), -DVec3::X));
        assert!(near(camera.transform_vector3(DVec3::Y), DVec3::Y));
        assert!(look_at(DVec3::Y, DVec3::Y, DVec3::Y).is_none());
        assert!(look_at(DVec3::ZERO, DVec3::Y, DVec3::Y).is_none());
    }

    #[test]
    fn matrices_go_down_the_columns() {
        let mut numbers = DMat4::IDENTITY.to_cols_array();
        numbers[12] = 7.0;
        let moved = from_numbers(numbers).unwrap();
        assert_eq!(moved.translation, DVec3::X * 7.0);
        numbers[3] = 0.5;
        assert!(from_numbers(numbers).is_none());
    }

    #[test]
    fn only_flat_transforms_are_singular() {
        let scale = |x, y, z| DAffine3::from_scale(DVec3::new(x, y, z));
        assert!(is_invertible(&scale(1e-9, -1.0, 1e9)));
        assert!(!is_invertible(&scale(1.0, 0.0, 1.0)));
        let flat = DMat3::from_cols_array(&[1.0, 2.0, 3.0, 2.0, 4.0, 6.0, 0.1, 0.7, 0.3]);
        assert!(!is_invertible(&DAffine3::from_mat3(flat)));
    }
}
