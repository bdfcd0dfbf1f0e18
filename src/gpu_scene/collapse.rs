//! Which nodes of a binary hierarchy become nodes of the device's, and which become leaves.
//!
//! Of all ways to do that, the one of least expected cost for a random ray: Ylitie and others, "Efficient
//! Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", 2017, section 3.1.

use crate::gpu_scene::bvh::{Bvh, Child};
use crate::kernels::{BVH_WIDTH, MAX_LEAF_COUNT};

const WIDTH: usize = BVH_WIDTH as usize;
/// Cost of a step at an inner node, in those of a test of a triangle. Measured on llvmpipe.
const NODE_COST: f32 = 3.0;
/// The count of a subtree that cannot become a leaf.
const TOO_MANY: u32 = MAX_LEAF_COUNT + 1;

/// A part of a binary hierarchy, as it is to be on the device.
pub struct Collapse<'a> {
    bvh: &'a Bvh,
    /// Of each inner node: the least cost of its subtree if it may become up to 1, 2 or 3 nodes.
    costs: Vec<[f32; WIDTH - 1]>,
    /// Of each inner node: the number of triangles below it, or [`TOO_MANY`].
    counts: Vec<u32>,
}

impl<'a> Collapse<'a> {
    /// Finds the costs. `is_triangle` tells whether a primitive may share a leaf.
    pub fn of(bvh: &'a Bvh, is_triangle: impl Fn(u32) -> bool) -> Self {
        let pairs = bvh.pairs.len();
        let mut collapse = Self { bvh, costs: vec![[0.0; WIDTH - 1]; pairs], counts: vec![0; pairs] };
        for pair in below_first(bvh) {
            collapse.weigh(pair, &is_triangle);
        }
        collapse
    }

    /// Returns the children that the node of a pair has on the device: up to [`BVH_WIDTH`].
    pub fn children(&self, pair: u32) -> Vec<Child> {
        let mut children = Vec::with_capacity(WIDTH);
        self.spread(pair, WIDTH, &mut children);
        children
    }

    /// Returns the primitives of a child that becomes a leaf, or nothing if it becomes an inner node.
    pub fn leaf(&self, child: &Child) -> Option<Vec<u32>> {
        let is_leaf = child.count() > 0 || self.leaf_cost(child) <= self.node_cost(child);
        is_leaf.then(|| {
            let mut primitives = Vec::new();
            self.gather(child, &mut primitives);
            primitives
        })
    }

    fn gather(&self, child: &Child, primitives: &mut Vec<u32>) {
        let first = child.first() as usize;
        if child.count() == 0 {
            self.bvh.pairs[first].iter().for_each(|child| self.gather(child, primitives));
        }
        primitives.extend(&self.bvh.primitives[first..first + child.count() as usize]);
    }

    fn weigh(&mut self, pair: u32, is_triangle: &impl Fn(u32) -> bool) {
        let children = self.bvh.pairs[pair as usize];
        let count = |child: &Child| match child.count() {
            0 => self.counts[child.first() as usize],
            count => {
                let mut own = self.bvh.primitives[child.first() as usize..][..count as usize].iter();
                if own.all(|primitive| is_triangle(*primitive)) { count } else { TOO_MANY }
            }
        };
        self.counts[pair as usize] = (count(&children[0]) + count(&children[1])).min(TOO_MANY);
        let bounds = children[0].bounds.union(&children[1].bounds);
        let whole = Child { bounds, reference: pair };
        let one = self.leaf_cost(&whole).min(self.node_cost(&whole));
        let two = one.min(self.split(pair, 2).0);
        self.costs[pair as usize] = [one, two, two.min(self.split(pair, 3).0)];
    }

    /// Cost of an inner node's subtree as one leaf.
    fn leaf_cost(&self, child: &Child) -> f32 {
        let count = self.counts[child.first() as usize];
        if count > MAX_LEAF_COUNT { f32::INFINITY } else { area(child) * count as f32 }
    }

    /// Cost of an inner node's subtree with that node on the device.
    fn node_cost(&self, child: &Child) -> f32 {
        self.split(child.first(), WIDTH).0 + area(child) * NODE_COST
    }

    /// Least cost of a subtree that may become up to `slots` nodes.
    fn cost(&self, child: &Child, slots: usize) -> f32 {
        match child.count() {
            0 => self.costs[child.first() as usize][slots - 1],
            count => area(child) * count as f32,
        }
    }

    /// Least cost of a pair of which both are to become nodes, `slots` in all, and the number of the first one's.
    fn split(&self, pair: u32, slots: usize) -> (f32, usize) {
        let [left, right] = &self.bvh.pairs[pair as usize];
        let cost = |first: usize| self.cost(left, first) + self.cost(right, slots - first);
        let ways = (1..slots).map(|first| (cost(first), first));
        ways.min_by(|a, b| a.0.total_cmp(&b.0)).expect("two or more slots")
    }

    /// Adds the nodes that a pair becomes, where each of the two becomes at least one.
    fn spread(&self, pair: u32, slots: usize, children: &mut Vec<Child>) {
        let first = self.split(pair, slots).1;
        for (child, slots) in self.bvh.pairs[pair as usize].iter().zip([first, slots - first]) {
            // As few nodes as the least cost takes.
            let needed = (1..=slots).find(|slots_| self.cost(child, *slots_) <= self.cost(child, slots));
            match needed.unwrap_or(1) {
                needed if needed > 1 && child.count() == 0 => self.spread(child.first(), needed, children),
                _ => children.push(*child),
            }
        }
    }
}

fn area(child: &Child) -> f32 {
    // A box that no ray enters costs nothing.
    if child.bounds.valid() { child.bounds.half_area() } else { 0.0 }
}

/// All pairs of all hierarchies, each after those below it.
fn below_first(bvh: &Bvh) -> Vec<u32> {
    let is_below: Vec<bool> = {
        let mut is_below = vec![false; bvh.pairs.len()];
        let inner = bvh.pairs.iter().flatten().filter(|child| child.count() == 0);
        inner.for_each(|child| is_below[child.first() as usize] = true);
        is_below
    };
    let roots = (0..bvh.pairs.len() as u32).filter(|pair| !is_below[*pair as usize]);
    let mut order: Vec<u32> = roots.collect();
    let mut next = 0;
    while let Some(pair) = order.get(next).copied() {
        let inner = bvh.pairs[pair as usize].iter().filter(|child| child.count() == 0);
        order.extend(inner.map(|child| child.first()));
        next += 1;
    }
    order.reverse();
    order
}
