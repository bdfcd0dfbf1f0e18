//! The bounding volume hierarchy over all primitives.

use std::collections::HashMap;

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

/// So many boxes that are the same leave a builder that goes by cost without a clue: it makes
/// a chain of them, by a recursion as deep, or none at all.
const MAX_ALIKE: usize = 64;

/// Builds a hierarchy over boxes, of which there is at least one. `None` if it is deeper
/// than a ray can walk.
pub fn build(boxes: &[Aabb]) -> Option<Bvh> {
    let padding = Vec3A::splat(PADDING);
    // Also for the builder, so that no area is 0.
    let boxes: Vec<Aabb> = boxes.iter().map(|it| Aabb::new(it.min - padding, it.max + padding)).collect();
    let boxes = &boxes[..];
    if are_alike(boxes) {
        return Some(balanced(boxes));
    }
    let mut params =
        if boxes.len() > 2_000_000 { BvhBuildParams::fast_build() } else { BvhBuildParams::medium_build() };
    params.max_prims_per_leaf = params.max_prims_per_leaf.min(MAX_LEAF_COUNT);
    let bvh = build_bvh2(boxes, params, &mut Default::default());
    if depth(&bvh) > MAX_BVH_DEPTH as usize {
        return None;
    }
    Some(Bvh { pairs: pairs(&bvh.nodes), order: bvh.primitive_indices })
}

/// Whether too many boxes in a row are the same, or of those too small to differ by much.
fn are_alike(boxes: &[Aabb]) -> bool {
    const SMALL: f32 = 8.0 * PADDING;
    if boxes.windows(MAX_ALIKE).any(|row| row[0] == row[MAX_ALIKE - 1] && row.iter().all(|other| *other == row[0])) {
        return true;
    }
    let mut counts = HashMap::<[[u32; 3]; 2], usize>::new();
    boxes.iter().filter(|it| it.diagonal().max_element() < SMALL).any(|it| {
        let bits = [it.min, it.max].map(|corner| corner.to_array().map(f32::to_bits));
        let count = counts.entry(bits).or_default();
        *count += 1;
        *count >= MAX_ALIKE
    })
}

/// A hierarchy of the least depth, whatever the boxes are.
fn balanced(boxes: &[Aabb]) -> Bvh {
    const LEAF: usize = 4;
    let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
    let mut nodes = vec![Bvh2Node::default()];
    let mut pending = vec![(0, 0..boxes.len())];
    while let Some((index, range)) = pending.pop() {
        let members = &mut order[range.clone()];
        let bounds = members.iter().fold(Aabb::empty(), |bounds, member| bounds.union(&boxes[*member as usize]));
        nodes[index].aabb = bounds;
        if members.len() <= LEAF {
            nodes[index].prim_count = members.len() as u32;
            nodes[index].first_index = range.start as u32;
            continue;
        }
        let axis = (bounds.max - bounds.min).max_position();
        let center = |member: &u32| boxes[*member as usize].center()[axis];
        members.select_nth_unstable_by(range.len() / 2, |a, b| center(a).total_cmp(&center(b)));
        let middle = range.start + range.len() / 2;
        let children = nodes.len();
        nodes[index].first_index = children as u32;
        nodes.extend([Bvh2Node::default(); 2]);
        pending.extend([(children, range.start..middle), (children + 1, middle..range.end)]);
    }
    Bvh { pairs: pairs(&nodes), order }
}

/// Children come in pairs behind the root: nodes 2i + 1 and 2i + 2 are pair i.
fn pairs(nodes: &[Bvh2Node]) -> Vec<BvhPair> {
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
    BvhPair {
        left_lower: corner(left.aabb.min, reference(left, first)),
        left_upper: corner(left.aabb.max, 0),
        right_lower: corner(right.aabb.min, reference(right, first)),
        right_upper: corner(right.aabb.max, 0),
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

    /// A mesh that is far smaller than the scene is a point in f32.
    #[test]
    fn boxes_that_are_all_the_same_make_a_shallow_tree() {
        let mut boxes = vec![Aabb::new(Vec3A::ZERO, Vec3A::ZERO); 200_000];
        boxes.push(Aabb::new(Vec3A::ONE, Vec3A::ONE));
        let bvh = build(&boxes).expect("a shallow tree");
        assert_eq!(visits(&bvh, &boxes), vec![1; boxes.len()]);
        // Not the same, but without an area that f32 could hold.
        for (i, it) in boxes.iter_mut().enumerate() {
            it.max += Vec3A::new(1e-30, 2e-30, 3e-30) * (i as f32).sin().abs();
        }
        let bvh = build(&boxes).expect("a shallow tree");
        assert_eq!(visits(&bvh, &boxes), vec![1; boxes.len()]);
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
