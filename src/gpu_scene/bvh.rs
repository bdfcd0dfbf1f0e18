//! Binary bounding volume hierarchies over primitives. [`crate::gpu_scene::wide`] converts them to wide ones for the device.

use std::hash::{DefaultHasher, Hash, Hasher};

use glam::Vec3A;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::ploc::PlocBuilder;
use obvhs::{Boundable, BvhBuildParams};

use crate::kernels::{COUNT_SHIFT, FIRST_MASK, MAX_LEAF_COUNT};

/// Padding of boxes on each side: the resolution of f32 at the size of render space. A ray in the plane of
/// a face must not miss the box, flat or not.
pub const PADDING: f32 = f32::EPSILON;

/// A box in a quarter less memory than [`Aabb`]'s.
#[derive(Clone, Copy, Debug)]
pub struct CompactBox {
    lower: [f32; 3],
    upper: [f32; 3],
}

impl From<Aabb> for CompactBox {
    fn from(bounds: Aabb) -> Self {
        Self { lower: bounds.min.to_array(), upper: bounds.max.to_array() }
    }
}

impl From<CompactBox> for Aabb {
    fn from(bounds: CompactBox) -> Self {
        Aabb::new(bounds.lower.into(), bounds.upper.into())
    }
}

impl Boundable for CompactBox {
    /// Returns the box with a padding: the builder's cost needs boxes with an area.
    fn aabb(&self) -> Aabb {
        padded((*self).into())
    }
}

/// A child of an inner node.
#[derive(Clone, Copy, Debug)]
pub struct Child {
    bounds: CompactBox,
    /// A leaf's number of primitives in the bits from [`COUNT_SHIFT`] on, and the index of its first one; for
    /// an inner node, the index of the pair of its children.
    pub reference: u32,
}

impl Child {
    pub fn new(bounds: Aabb, reference: u32) -> Self {
        Self { bounds: bounds.into(), reference }
    }

    /// Returns a box that contains what is below the child, with a padding. A box that no ray enters is inverted.
    pub fn bounds(&self) -> Aabb {
        self.bounds.into()
    }

    /// Returns the number of primitives of a leaf, 0 for an inner node.
    pub fn count(&self) -> u32 {
        self.reference >> COUNT_SHIFT
    }

    /// Returns the index of a leaf's first primitive, or that of an inner node's pair.
    pub fn first(&self) -> u32 {
        self.reference & FIRST_MASK
    }
}

/// A binary hierarchy.
pub struct Bvh {
    /// Pairs of children, one per inner node, each before the pairs below it; the root's pair is the first.
    pub pairs: Vec<[Child; 2]>,
    /// References to primitives, in the order of the leaves.
    pub primitives: Vec<u32>,
    /// Maximum number of nodes on a path from a root to a leaf, both included.
    pub depth: usize,
}

impl Bvh {
    /// Appends another hierarchy, and returns the index of the pair of its root's children.
    pub fn append(&mut self, other: Bvh) -> u32 {
        let (first_pair, first_place) = (self.pairs.len() as u32, self.primitives.len() as u32);
        let moved = |child: Child| {
            let by = if child.count() == 0 { first_pair } else { first_place };
            Child { reference: child.reference + by, ..child }
        };
        self.pairs.extend(other.pairs.into_iter().map(|pair| pair.map(moved)));
        self.primitives.extend(other.primitives);
        first_pair
    }

    /// Visits every primitive below the pair `root` whose leaf's box touches `bounds`.
    pub fn visit(&self, root: u32, bounds: &Aabb, visit: &mut impl FnMut(u32)) {
        let mut pending = vec![root];
        while let Some(index) = pending.pop() {
            for child in &self.pairs[index as usize] {
                let own = child.bounds();
                if own.min.cmpgt(bounds.max).any() || own.max.cmplt(bounds.min).any() {
                    continue;
                }
                let first = child.first();
                if child.count() == 0 {
                    pending.push(first);
                }
                (first..first + child.count()).for_each(|place| visit(self.primitives[place as usize]));
            }
        }
    }

    /// Returns boxes that together contain all primitives: the boxes of nodes `levels` below the root, and
    /// of leaves above that level.
    pub fn cover(&self, levels: u32) -> Vec<Aabb> {
        let mut boxes = Vec::new();
        let mut pending = vec![(0, 1)];
        while let Some((index, level)) = pending.pop() {
            for child in &self.pairs[index as usize] {
                if level < levels && child.count() == 0 {
                    pending.push((child.first(), level + 1));
                } else if child.bounds().valid() {
                    boxes.push(child.bounds());
                }
            }
        }
        boxes
    }
}

/// Smallest permitted bound of a hierarchy's depth: halving the largest permitted number of primitives
/// takes no more levels.
const LEAST_DEPTH: usize = 32;
/// Maximum depth of the hierarchy of an object. Its traversal uses the stack above the entries of the
/// scene's hierarchy.
pub const OBJECT_DEPTH: usize = LEAST_DEPTH;

/// Maximum number of boxes that are sampled for equal boxes, besides all small ones. Equal boxes make the
/// builder add nodes one by one in a chain, with a recursion as deep as the chain.
const SAMPLES: usize = 4096;
/// Boxes with sides below this size are all examined, because rounding may have made them equal.
const SMALL: f32 = 8.0 * PADDING;
/// Maximum number of equal boxes for which the clustering builder is used.
const MOST_EQUAL: usize = 32;

/// Builds a hierarchy over the boxes of one or more primitives. Its depth is at most `most`, which must be
/// [`LEAST_DEPTH`] or more. `references[i]` names the primitive of `boxes[i]`.
pub fn build(boxes: &[CompactBox], references: &[u32], most: usize) -> Bvh {
    let (pairs, order, depth) = (most_equal(boxes) <= MOST_EQUAL)
        .then(|| clusters(boxes))
        .map(|bvh| (pairs(&bvh), bvh.primitive_indices))
        .filter(|((_, depth), _)| *depth <= most)
        .map_or_else(|| Halving::of(boxes), |((pairs, depth), order)| (pairs, order, depth));
    Bvh { pairs, primitives: order.iter().map(|index| references[*index as usize]).collect(), depth }
}

/// Returns the largest number of equal boxes among up to [`SAMPLES`] boxes and the small ones.
fn most_equal(boxes: &[CompactBox]) -> usize {
    // Boxes are compared as padded: boxes that differ by less than the padding are in one place, too.
    let hash = |bounds: &CompactBox| {
        let bounds = bounds.aabb();
        let mut hasher = DefaultHasher::new();
        bytemuck::bytes_of(&[bounds.min, bounds.max].map(|corner| corner.to_array())).hash(&mut hasher);
        hasher.finish()
    };
    let step = boxes.len().div_ceil(SAMPLES).max(1);
    let is_small = |bounds: &CompactBox| Aabb::from(*bounds).diagonal().max_element() < SMALL;
    let looked_at = boxes.iter().enumerate().filter(|(i, bounds)| i % step == 0 || is_small(bounds));
    let mut hashes: Vec<u64> = looked_at.map(|(_, bounds)| hash(bounds)).collect();
    hashes.sort_unstable();
    hashes.chunk_by(|a, b| a == b).map(<[u64]>::len).max().unwrap_or(0)
}

/// Returns a box with the padding on each side.
fn padded(bounds: Aabb) -> Aabb {
    let padding = Vec3A::splat(PADDING);
    Aabb::new(bounds.min - padding, bounds.max + padding)
}

/// Builds a hierarchy by clustering neighbouring boxes, and improves it by moving nodes.
fn clusters(boxes: &[CompactBox]) -> Bvh2 {
    let params = if boxes.len() > 2_000_000 { BvhBuildParams::fast_build() } else { BvhBuildParams::medium_build() };
    let mut bvh = PlocBuilder::with_capacity(boxes.len()).build(
        params.ploc_search_distance,
        boxes,
        (0..boxes.len() as u32).collect(),
        params.sort_precision,
        params.search_depth_threshold,
    );
    let mut optimizer = ReinsertionOptimizer::default();
    optimizer.run(&mut bvh, params.reinsertion_batch_ratio, None);
    let again = params.reinsertion_batch_ratio * params.post_collapse_reinsertion_batch_ratio_multiplier;
    optimizer.run(&mut bvh, again, None);
    bvh
}

/// An inner node whose pair of children is to be added.
struct Pending {
    /// The place of the pair in the builder's nodes.
    first: u32,
    /// The pair and the side of the node itself; nothing for the root.
    parent: Option<(usize, usize)>,
    /// Number of nodes on the path from the root to the children.
    depth: usize,
}

/// Returns the pairs of children, depth first, and the maximum number of nodes on a path from the root to a leaf.
fn pairs(bvh: &Bvh2) -> (Vec<[Child; 2]>, usize) {
    let nodes = &bvh.nodes;
    if nodes[0].prim_count > 0 {
        // The root is a leaf: its sibling is a box that no ray enters.
        let nothing = Child::new(Aabb::INVALID, 1 << COUNT_SHIFT);
        return (vec![[child(*nodes[0].aabb(), leaf(&nodes[0])), nothing]], 1);
    }
    let mut pairs: Vec<[Child; 2]> = Vec::with_capacity(nodes.len() / 2);
    let mut deepest = 0;
    let mut pending = vec![Pending { first: nodes[0].first_index, parent: None, depth: 2 }];
    while let Some(Pending { first, parent, depth }) = pending.pop() {
        let pair = pairs.len();
        if let Some((above, side)) = parent {
            pairs[above][side].reference = pair as u32;
        }
        let children = [first, first + 1].map(|index| &nodes[index as usize]);
        pairs.push(children.map(|node| child(*node.aabb(), leaf(node))));
        deepest = deepest.max(depth);
        for (side, node) in children.into_iter().enumerate().filter(|(_, node)| node.prim_count == 0) {
            pending.push(Pending { first: node.first_index, parent: Some((pair, side)), depth: depth + 1 });
        }
    }
    (pairs, deepest)
}

/// Returns a child with a padded box.
fn child(bounds: Aabb, reference: u32) -> Child {
    Child::new(padded(bounds), reference)
}

/// Returns the reference to a leaf.
fn leaf(node: &Bvh2Node) -> u32 {
    node.prim_count << COUNT_SHIFT | node.first_index
}

/// Builder of a hierarchy by halving along the longest axis: slower to traverse, but shallow.
struct Halving<'a> {
    boxes: &'a [CompactBox],
    pairs: Vec<[Child; 2]>,
}

impl Halving<'_> {
    /// Returns pairs, order of primitives and depth; for more boxes than fit in a leaf.
    fn of(boxes: &[CompactBox]) -> (Vec<[Child; 2]>, Vec<u32>, usize) {
        let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
        let mut halving = Halving { boxes, pairs: Vec::new() };
        let (_, _, depth) = halving.node(&mut order, 0);
        (halving.pairs, order, depth)
    }

    /// Adds a node over part of the order, and returns its box, its reference and its depth.
    fn node(&mut self, part: &mut [u32], first: u32) -> (Aabb, u32, usize) {
        let bounds = part.iter().fold(Aabb::empty(), |all, index| all.union(&self.boxes[*index as usize].into()));
        if part.len() <= MAX_LEAF_COUNT as usize {
            return (bounds, (part.len() as u32) << COUNT_SHIFT | first, 1);
        }
        let extent = bounds.max - bounds.min;
        let axis = if extent.x >= extent.y.max(extent.z) { 0 } else { 1 + usize::from(extent.z > extent.y) };
        let place = |index: &u32| {
            let bounds = &self.boxes[*index as usize];
            bounds.lower[axis] + bounds.upper[axis]
        };
        let middle = part.len() / 2;
        part.select_nth_unstable_by(middle, |a, b| place(a).total_cmp(&place(b)));
        let index = self.pairs.len();
        self.pairs.push([child(Aabb::empty(), 0); 2]);
        let (before, after) = part.split_at_mut(middle);
        let (left, left_bits, left_depth) = self.node(before, first);
        let (right, right_bits, right_depth) = self.node(after, first + middle as u32);
        self.pairs[index] = [child(left, left_bits), child(right, right_bits)];
        (bounds, index as u32, 1 + left_depth.max(right_depth))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn build_over(boxes: &[Aabb], most: usize) -> Bvh {
        let all: Vec<u32> = (0..boxes.len() as u32).collect();
        let boxes: Vec<CompactBox> = boxes.iter().map(|bounds| (*bounds).into()).collect();
        build(&boxes, &all, most)
    }

    /// Returns the number of times that a walk from the first pair reaches each box; checks that boxes
    /// contain the boxes below them.
    fn visits(bvh: &Bvh, boxes: &[Aabb]) -> Vec<u32> {
        let mut visits = vec![0; boxes.len()];
        let mut pending = vec![(0, Vec3A::splat(f32::NEG_INFINITY), Vec3A::splat(f32::INFINITY))];
        while let Some((index, lower, upper)) = pending.pop() {
            for child in &bvh.pairs[index as usize] {
                let (low, high) = (child.bounds().min, child.bounds().max);
                if low.cmpgt(high).any() {
                    continue; // no ray enters
                }
                assert!(low.cmpge(lower).all() && high.cmple(upper).all());
                let (first, count) = (child.first(), child.count());
                if count == 0 {
                    pending.push((first, low, high));
                }
                for place in first..first + count {
                    let index = bvh.primitives[place as usize] as usize;
                    assert!(low.cmplt(boxes[index].min).all() && high.cmpgt(boxes[index].max).all());
                    visits[index] += 1;
                }
            }
        }
        visits
    }

    proptest! {
        /// Flat and nested boxes of all sizes, such as those of walls and rings.
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
            let bvh = build_over(&boxes, 64);
            prop_assert_eq!(visits(&bvh, &boxes), vec![1; boxes.len()]);
            prop_assert!(bvh.depth <= 64);
        }
    }

    /// A mesh that is far smaller than the scene is a single point in f32.
    #[test]
    fn boxes_that_have_collapsed_make_no_deep_hierarchy() {
        let mut boxes = vec![Aabb::new(Vec3A::ZERO, Vec3A::ZERO); 200_000];
        boxes.extend((0..2000).map(|i| Aabb::new(Vec3A::splat(-1.0), Vec3A::splat(i as f32 / 2000.0))));
        let bvh = build_over(&boxes, LEAST_DEPTH);
        assert_eq!(visits(&bvh, &boxes), vec![1; boxes.len()]);
        // The boxes differ, but their areas are 0 in f32.
        for (i, it) in boxes.iter_mut().enumerate() {
            it.max += Vec3A::new(1e-30, 2e-30, 3e-30) * (i as f32).sin().abs();
        }
        let bvh = build_over(&boxes, LEAST_DEPTH);
        assert_eq!(visits(&bvh, &boxes), vec![1; boxes.len()]);
    }

    #[test]
    fn boxes_in_one_place_make_no_deep_hierarchy() {
        let boxes = [Aabb::new(Vec3A::splat(-0.5), Vec3A::splat(0.25)); 5000];
        let bvh = build_over(&boxes, LEAST_DEPTH);
        assert!(bvh.depth <= LEAST_DEPTH);
        assert_eq!(visits(&bvh, &boxes), vec![1; boxes.len()]);
    }
}
