//! The order of triangles in the device's arrays.

use super::Packer;
use crate::kernels::{AREA, INDEX_MASK, KIND_SHIFT, NONE, TRIANGLE};

impl Packer {
    /// Puts triangles in the order of the leaves: those of a leaf lie side by side in memory.
    pub(super) fn order_triangles(&mut self, mut order: Vec<u32>) {
        let mut places = vec![NONE; self.triangles.len()];
        order.iter().enumerate().for_each(|(place, index)| places[*index as usize] = place as u32);
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
