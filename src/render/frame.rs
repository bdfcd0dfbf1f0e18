//! The camera as image files describe it.

use glam::{DMat4, DVec3, DVec4};
use serde::{Deserialize, Serialize};

use crate::scene::{Camera, Projection};

/// The depths that pbrt's perspective projection maps to 0 and 1.
const NEAR_AND_FAR: [f64; 2] = [1e-2, 1000.0];

/// The camera's matrices as pbrt writes them, and the unit of lengths.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Frame {
    /// The matrix from world space to camera space, in rows; it multiplies columns.
    pub world_to_camera: [[f32; 4]; 4],
    /// The matrix from world space to pbrt's normalised device coordinates, in rows; `None` for a camera that sees
    /// all directions.
    pub world_to_ndc: Option<[[f32; 4]; 4]>,
    /// Scene units per render unit.
    pub length: f64,
}

impl Frame {
    /// Returns the frame of a camera, with a render unit of `length` scene units; `None` if a number of it is too large
    /// for a file.
    pub(crate) fn new(camera: &Camera, length: f64) -> Option<Self> {
        let camera_from_world = DMat4::from(camera.world_from_camera.inverse());
        let screen = screen_from_camera(camera.projection);
        let ndc_from_screen = DMat4::from_translation(DVec3::splat(0.5)) * DMat4::from_scale(DVec3::splat(0.5));
        let rows = |matrix: DMat4| matrix.transpose().to_cols_array_2d().map(|row| row.map(|it| it as f32));
        let frame = Self {
            world_to_camera: rows(camera_from_world),
            world_to_ndc: screen.map(|screen| rows(ndc_from_screen * screen * camera_from_world)),
            length,
        };
        Some(frame).filter(Self::is_finite)
    }

    fn is_finite(&self) -> bool {
        let ndc = self.world_to_ndc.unwrap_or_default();
        self.length.is_finite() && self.world_to_camera.iter().chain(&ndc).flatten().all(|it| it.is_finite())
    }
}

/// Returns pbrt's projection to its screen space; `None` if it has none.
fn screen_from_camera(projection: Projection) -> Option<DMat4> {
    match projection {
        Projection::Perspective { tan_half_fov } => {
            let [near, far] = NEAR_AND_FAR;
            let (across, depth) = (1.0 / tan_half_fov, far / (far - near));
            Some(DMat4::from_cols(
                DVec4::new(across, 0.0, 0.0, 0.0),
                DVec4::new(0.0, across, 0.0, 0.0),
                DVec4::new(0.0, 0.0, depth, 1.0),
                DVec4::new(0.0, 0.0, -near * depth, 0.0),
            ))
        }
        Projection::Orthographic => Some(DMat4::IDENTITY),
        Projection::Equirectangular | Projection::EqualArea => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;

    fn frame(camera: &str) -> Frame {
        let text = format!("{camera}\nWorldBegin\nShape \"sphere\"");
        Frame::new(&Scene::parse(&text, "camera.pbrt", ".").unwrap().camera, 1.0).unwrap()
    }

    /// Returns the product with a point, divided by its last coordinate.
    fn apply(rows: [[f32; 4]; 4], [x, y, z]: [f64; 3]) -> [f64; 3] {
        let [x, y, z, w] = rows.map(|row| {
            let [a, b, c, d] = row.map(f64::from);
            a * x + b * y + c * z + d
        });
        [x / w, y / w, z / w]
    }

    fn assert_near(found: [f64; 3], expected: [f64; 3]) {
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-4), "{found:?}, expected {expected:?}");
    }

    #[test]
    fn matrices_multiply_columns_and_end_in_device_coordinates() {
        let frame = frame("LookAt 0 0 -5  0 0 0  0 1 0\nCamera \"perspective\" \"float fov\" 90");
        assert_near(apply(frame.world_to_camera, [1.0, 2.0, 3.0]), [1.0, 2.0, 8.0]);
        // The translation is the last column.
        assert_eq!(frame.world_to_camera[2][3], 5.0);
        let ndc = frame.world_to_ndc.unwrap();
        // 45 degrees off the axis is the edge of the screen; depths from 0.01 to 1000 go from 0.5 to 1.
        assert_near(apply(ndc, [5.0, -5.0, 0.0]), [1.0, 0.0, 0.5 + 0.5 * 1000.0 / 999.99 * (1.0 - 0.01 / 5.0)]);
        assert_near(apply(ndc, [0.0, 0.0, 995.0]), [0.5, 0.5, 1.0]);
        assert_near(apply(ndc, [0.0, 0.0, -4.99]), [0.5, 0.5, 0.5]);
    }

    #[test]
    fn cameras_of_all_directions_have_no_device_coordinates() {
        assert_eq!(frame("Camera \"spherical\"").world_to_ndc, None);
        assert_near(
            apply(frame("Camera \"orthographic\"").world_to_ndc.unwrap(), [0.5, -1.0, 0.25]),
            [0.75, 0.0, 0.625],
        );
    }
}
