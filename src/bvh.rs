//! The bounding volume hierarchy over all primitives.

use glam::Vec3A;
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::bvh2::node::Bvh2Node;

use crate::kernels::{BvhPair, COUNT_SHIFT, MAX_BVH_DEPTH, MAX_LEAF_COUNT};

/// Boxes are this much wider on each side: the resolution of f32 at the size of render
/// space. A ray in the plane of a face must not lose the box, flat or not.
const PADDING: f32 = f32::EPSILON;

/// A hierarchy as the GPU reads it.
pub struct Bvh {
    /// Children of each inner node; the root's are the first.
    pub pairs: Vec<BvhPair>,
    /// For each place of a leaf, which of the boxes given to [`build`] stands there.
    pub order: Vec<u32>,
}

/// Builds a hierarchy over boxes, of which there is at least one. `None` if it is deeper
/// than a ray can walk.
pub fn build(boxes: &[Aabb]) -> Option<Bvh> {
    let mut params =
        if boxes.len() > 2_000_000 { BvhBuildParams::fast_build() } else { BvhBuildParams::medium_build() };
    params.max_prims_per_leaf = params.max_prims_per_leaf.min(MAX_LEAF_COUNT);
    let bvh = build_bvh2(boxes, params, &mut Default::default());
    if depth(&bvh) > MAX_BVH_DEPTH as usize {
        return None;
    }
    Some(Bvh { pairs: pairs(&bvh), order: bvh.primitive_indices.clone() })
}

/// Children come in pairs behind the root: nodes 2i + 1 and 2i + 2 are pair i.
fn pairs(bvh: &Bvh2) -> Vec<BvhPair> {
    let empty = Bvh2Node::default();
    let nodes = &bvh.nodes;
    if nodes[0].prim_count > 0 {
        // A lone leaf: its sibling is a box that no ray enters.
        return vec![pair(&nodes[0], &Bvh2Node { aabb: Aabb::INVALID, prim_count: 1, ..empty })];
    }
    // The root's children are pair 0, and any child's pair stands where its nodes stand.
    nodes[1..].chunks_exact(2).map(|children| pair(&children[0], &children[1])).collect()
}

fn pair(left: &Bvh2Node, right: &Bvh2Node) -> BvhPair {
    let corner = |corner: Vec3A, bits: u32| [corner.x, corner.y, corner.z, f32::from_bits(bits)];
    let padding = Vec3A::splat(PADDING);
    BvhPair {
        left_lower: corner(left.aabb.min - padding, reference(left)),
        left_upper: corner(left.aabb.max + padding, 0),
        right_lower: corner(right.aabb.min - padding, reference(right)),
        right_upper: corner(right.aabb.max + padding, 0),
    }
}

fn reference(node: &Bvh2Node) -> u32 {
    if node.prim_count > 0 { node.prim_count << COUNT_SHIFT | node.first_index } else { (node.first_index - 1) / 2 }
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
