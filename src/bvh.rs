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
pub const PADDING: f32 = f32::EPSILON;

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
    let nodes = &bvh.nodes;
    if nodes[0].prim_count > 0 {
        // A lone leaf: its sibling is a box that no ray enters.
        let nothing = Bvh2Node { aabb: Aabb::INVALID, prim_count: 1, ..Bvh2Node::default() };
        return vec![pair(&nodes[0], &nothing, 0)];
    }
    // Where nodes were put elsewhere to make a better tree, the root's pair may be any: it
    // changes places with the first.
    let first = pair_index(&nodes[0]);
    let mut pairs: Vec<BvhPair> =
        nodes[1..].chunks_exact(2).map(|children| pair(&children[0], &children[1], first)).collect();
    pairs.swap(0, first as usize);
    pairs
}

fn pair(left: &Bvh2Node, right: &Bvh2Node, first: u32) -> BvhPair {
    let corner = |corner: Vec3A, bits: u32| [corner.x, corner.y, corner.z, f32::from_bits(bits)];
    let padding = Vec3A::splat(PADDING);
    BvhPair {
        left_lower: corner(left.aabb.min - padding, reference(left, first)),
        left_upper: corner(left.aabb.max + padding, 0),
        right_lower: corner(right.aabb.min - padding, reference(right, first)),
        right_upper: corner(right.aabb.max + padding, 0),
    }
}

/// What a node is to its parent, with the pairs 0 and `first` swapped.
fn reference(node: &Bvh2Node, first: u32) -> u32 {
    match pair_index(node) {
        _ if node.prim_count > 0 => node.prim_count << COUNT_SHIFT | node.first_index,
        0 => first,
        index if index == first => 0,
        index => index,
    }
}

/// The pair of an inner node's children.
fn pair_index(node: &Bvh2Node) -> u32 {
    node.first_index.saturating_sub(1) / 2
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

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::kernels::FIRST_MASK;

    /// How often a walk from the first pair comes to each box; boxes hold what is below them.
    fn visits(bvh: &Bvh, boxes: &[Aabb]) -> Vec<u32> {
        let mut visits = vec![0; boxes.len()];
        let mut pending = vec![(0, Vec3A::splat(f32::NEG_INFINITY), Vec3A::splat(f32::INFINITY))];
        while let Some((index, lower, upper)) = pending.pop() {
            let BvhPair { left_lower, left_upper, right_lower, right_upper } = bvh.pairs[index as usize];
            for (low, high) in [(left_lower, left_upper), (right_lower, right_upper)] {
                let corner = |corner: [f32; 4]| Vec3A::new(corner[0], corner[1], corner[2]);
                let (low, high, node) = (corner(low), corner(high), low[3].to_bits());
                if low.cmpgt(high).any() {
                    continue; // no ray enters
                }
                assert!(low.cmpge(lower).all() && high.cmple(upper).all());
                let (first, count) = (node & FIRST_MASK, node >> COUNT_SHIFT);
                if count == 0 {
                    pending.push((first, low, high));
                }
                for place in first..first + count {
                    let index = bvh.order[place as usize] as usize;
                    assert!(low.cmplt(boxes[index].min).all() && high.cmpgt(boxes[index].max).all());
                    visits[index] += 1;
                }
            }
        }
        visits
    }

    proptest! {
        /// Flat and nested boxes of all sizes, as of walls and rings.
        #[test]
        fn every_box_is_reached_once(
            boxes in prop::collection::vec((prop::array::uniform3(-1.0_f32..1.0), prop::array::uniform3(0.0_f32..1.0), -9..0), 1..400)
        ) {
            let boxes: Vec<Aabb> = boxes
                .into_iter()
                .map(|(center, half, exponent)| {
                    let (center, half) = (Vec3A::from(center), Vec3A::from(half) * 2.0_f32.powi(exponent));
                    Aabb::new(center - half, center + half)
                })
                .collect();
            let bvh = build(&boxes).expect("a shallow tree");
            prop_assert_eq!(visits(&bvh, &boxes), vec![1; boxes.len()]);
        }
    }
}
