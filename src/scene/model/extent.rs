//! Extents of shapes, and the memory that they take.

use glam::DVec3;

use crate::scene::model::{Geometry, Mesh};

impl Geometry {
    /// Returns true if `holds` is true for every point of a set whose convex hull contains the shape, in
    /// object space.
    pub fn hull_all(&self, mut holds: impl FnMut(DVec3) -> bool) -> bool {
        let mut of_box = |lower: DVec3, upper: DVec3| {
            (0..8).all(|corner| {
                let pick = |bit: u32, low: f64, high: f64| if corner >> bit & 1 == 0 { low } else { high };
                holds(DVec3::new(pick(0, lower.x, upper.x), pick(1, lower.y, upper.y), pick(2, lower.z, upper.z)))
            })
        };
        match self {
            Self::Mesh(mesh) => mesh.positions.iter().all(|point| holds(*point)),
            Self::Sphere { radius, z_min, z_max, .. } => {
                of_box(DVec3::new(-radius, -radius, *z_min), DVec3::new(*radius, *radius, *z_max))
            }
            Self::Disk { height, radius, .. } => {
                of_box(DVec3::new(-radius, -radius, *height), DVec3::new(*radius, *radius, *height))
            }
            // The control points bound the curve, so their rings bound the body.
            Self::Revolution(profile) => profile
                .segments
                .iter()
                .flat_map(|segment| &segment.points)
                .all(|point| of_box(DVec3::new(-point.x, -point.x, point.y), DVec3::new(point.x, point.x, point.y))),
        }
    }

    /// Returns a lower bound of the bytes that a shape of this geometry takes on the device; `shines` if it
    /// emits. Each shape has triangles, normals and lights of its own, even if shapes share a mesh.
    pub(in crate::scene) fn placed_bytes(&self, shines: bool) -> u64 {
        let Self::Mesh(mesh) = self else { return PACKED_PRIMITIVE };
        // The estimate also charges for vertices that no triangle uses.
        let triangles = mesh.triangles.len().max(mesh.positions.len() / 3) as u64;
        let light = if shines { PACKED_LIGHT } else { 0 };
        let normals = if mesh.normals.is_empty() { 0 } else { PACKED_TRIANGLE };
        triangles * (PACKED_TRIANGLE + normals + light)
    }
}

/// Bytes of a triangle on the device, and bytes of its normals.
pub(crate) const PACKED_TRIANGLE: u64 = 48;
/// Approximate bytes of a primitive that is not a triangle.
const PACKED_PRIMITIVE: u64 = 512;
/// Bytes of a light and of its entries in tables.
pub(crate) const PACKED_LIGHT: u64 = 160;

impl Mesh {
    /// Returns the number of bytes that the arrays take.
    pub fn bytes(&self) -> u64 {
        let Self { positions, normals, uvs, triangles } = self;
        let sizes = [
            size_of_val(&positions[..]),
            size_of_val(&normals[..]),
            size_of_val(&uvs[..]),
            size_of_val(&triangles[..]),
        ];
        sizes.iter().map(|size| *size as u64).sum()
    }
}
