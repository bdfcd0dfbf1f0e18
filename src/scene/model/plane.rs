//! Detection of scenes whose surfaces all lie in one plane: light that leaves one surface cannot reach
//! another.

use glam::DVec3;

use crate::scene::model::{Geometry, Input, Scene, Shape};

/// Maximum distance of points from their common plane, relative to the largest distance between them and
/// the first point.
const FLAT: f64 = 1e-9;

impl Scene {
    /// Returns true if all surfaces with an alpha above 0 lie in one plane. A scene with instances counts
    /// as not plane.
    pub fn is_plane(&self) -> bool {
        if !self.instances.is_empty() {
            return false;
        }
        let mut points = Vec::new();
        for shape in self.shapes.iter().filter(|shape| shape.alpha != Input::Constant(0.0)) {
            let Some(more) = shape.corners() else { return false };
            points.extend(more);
        }
        are_in_a_plane(&points)
    }
}

impl Shape {
    /// Returns true if the shape lies in a plane.
    pub(in crate::scene) fn is_plane(&self) -> bool {
        self.corners().is_some_and(|points| are_in_a_plane(&points))
    }

    /// Returns points in world space that lie in a plane only if the shape does; `None` if the shape is
    /// curved.
    fn corners(&self) -> Option<Vec<DVec3>> {
        let place = |point: DVec3| self.world_from_object.transform_point3(point);
        match &self.geometry {
            Geometry::Mesh(mesh) => Some(mesh.positions.iter().map(|point| place(*point)).collect()),
            Geometry::Disk { height, radius, .. } => {
                let rim = [(0.0, 0.0), (*radius, 0.0), (0.0, *radius)];
                Some(rim.map(|(x, y)| place(DVec3::new(x, y, *height))).to_vec())
            }
            Geometry::Sphere { .. } | Geometry::Revolution(_) => None,
        }
    }
}

fn are_in_a_plane(points: &[DVec3]) -> bool {
    let Some(origin) = points.first().copied() else { return true };
    let farthest = |distance: &dyn Fn(DVec3) -> f64| {
        points.iter().map(|point| *point - origin).max_by(|a, b| distance(*a).total_cmp(&distance(*b)))
    };
    let along = farthest(&|d| d.length_squared()).unwrap_or_default();
    let aside = farthest(&|d| d.cross(along).length_squared()).unwrap_or_default();
    let normal = aside.cross(along).normalize_or_zero();
    points.iter().all(|point| (*point - origin).dot(normal).abs() <= FLAT * along.length())
}

#[cfg(test)]
mod tests {
    use crate::scene::Scene;

    fn scene(world: &str) -> Scene {
        Scene::parse(&format!("WorldBegin\nLightSource \"distant\"\n{world}"), "t.pbrt", "").unwrap()
    }

    #[test]
    fn planes_are_told_from_what_lights_itself() {
        let square = "Shape \"bilinearmesh\" \"point3 P\" [-3 0 -3  3 0 -3  -3 0 3  3 0 3]\n";
        let turned = format!("Rotate 33 1 2 3 Translate 1 2 3 Scale 9 2 1\n{square}");
        let disk = "Translate 9 0 1 Rotate 90 1 0 0 Shape \"disk\"\n";
        for plane in [square, &turned, disk, &format!("{square}{disk}")] {
            assert!(scene(plane).is_plane(), "{plane}");
        }
        let above = "AttributeBegin Translate 0 1 0\nShape \"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 0 1 1 0 1]\nAttributeEnd\n";
        for other in [
            &format!("{square}{above}"),
            "Shape \"sphere\"",
            "Shape \"cylinder\"",
            &format!("{square}Rotate 1 1 0 0\n{square}"),
        ] {
            assert!(!scene(other).is_plane(), "{other}");
        }
        // A shape of alpha 0 cannot be lit.
        let lamp = above.replace("Shape", "AreaLightSource \"diffuse\"\nShape").replace("]\n", "] \"float alpha\" 0\n");
        assert!(scene(&format!("{square}{lamp}")).is_plane());
    }
}
