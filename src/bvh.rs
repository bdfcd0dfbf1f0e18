//! The bounding volume hierarchy over all primitives.

use glam::Vec3;
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;

use crate::kernels::{BvhNode, MAX_BVH_DEPTH};

/// A hierarchy as the GPU reads it.
pub struct Bvh {
    /// Nodes; the root is the first.
    pub nodes: Vec<BvhNode>,
    /// For each place of a leaf, which of the boxes given to [`build`] stands there.
    pub order: Vec<u32>,
}

/// Builds a hierarchy over boxes, of which there is at least one. `None` if it is deeper
/// than a ray can walk.
pub fn build(boxes: &[Aabb]) -> Option<Bvh> {
    let params = if boxes.len() > 2_000_000 { BvhBuildParams::fast_build() } else { BvhBuildParams::medium_build() };
    let bvh = build_bvh2(boxes, params, &mut Default::default());
    if depth(&bvh) > MAX_BVH_DEPTH as usize {
        return None;
    }
    let nodes = bvh.nodes.iter().map(|node| BvhNode {
        lower: Vec3::from(node.aabb.min).to_array(),
        first: node.first_index,
        upper: Vec3::from(node.aabb.max).to_array(),
        count: node.prim_count,
    });
    Some(Bvh { nodes: nodes.collect(), order: bvh.primitive_indices.clone() })
}

/// The most nodes between the root and a leaf, both counted.
fn depth(bvh: &Bvh2) -> usize {
    let mut deepest = 0;
    let mut pending = vec![(0, 1)];
    while let Some((index, depth)) = pending.pop() {
        deepest = deepest.max(depth);
        let node = &bvh.nodes[index as usize];
        if node.prim_count == 0 {
            pending.extend([(node.first_index, depth + 1), (node.first_index + 1, depth + 1)]);
        }
    }
    deepest
}
