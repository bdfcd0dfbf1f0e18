//! The order of triangles.

use super::Packer;
use crate::gpu_scene::wide::Wide;
use crate::kernels::{AREA, INDEX_MASK, KIND_SHIFT, NONE, TRIANGLE};

impl Packer {
    /// Puts triangles in the order of the leaves: those of a leaf lie side by side in memory. In a scene of
    /// visible triangles alone, the n-th primitive of the leaves is then triangle n, and kernels read no
    /// references.
    pub(super) fn order_triangles(&mut self, wide: &mut Wide) {
        let mut places = vec![NONE; self.triangles.len()];
        let mut order = Vec::with_capacity(self.triangles.len());
        for reference in wide.primitives.iter_mut().filter(|reference| **reference >> KIND_SHIFT == TRIANGLE) {
            let index = *reference & INDEX_MASK;
            *reference = TRIANGLE << KIND_SHIFT | order.len() as u32;
            places[index as usize] = order.len() as u32;
            order.push(index);
        }
        // No ray meets the others, but they may emit.
        for (index, place) in places.iter_mut().enumerate().filter(|(_, place)| **place == NONE) {
            *place = order.len() as u32;
            order.push(index as u32);
        }
        self.triangles = order.iter().map(|index| self.triangles[*index as usize]).collect();
        if !self.triangle_uvs.is_empty() {
            self.triangle_uvs = order.iter().map(|index| self.triangle_uvs[*index as usize]).collect();
        }
        for light in self.lights.iter_mut().filter(|light| light.kind == AREA) {
            if light.primitive >> KIND_SHIFT == TRIANGLE {
                light.primitive = TRIANGLE << KIND_SHIFT | places[(light.primitive & INDEX_MASK) as usize];
            }
        }
    }
}
