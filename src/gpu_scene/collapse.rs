//! The choice of the nodes of a binary hierarchy that become nodes or leaves of the device's wide hierarchy.
//!
//! The choice has the least expected cost for a random ray: Ylitie and others, "Efficient Incoherent Ray
//! Traversal on GPUs Through Compressed Wide BVHs", 2017, section 3.1.

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
    /// Of the subtree of each inner node.
    weights: Vec<Weight>,
}

#[derive(Clone, Copy, Default)]
struct Weight {
    /// The least cost if the subtree may become up to 1, 2 or 3 nodes.
    costs: [f32; WIDTH - 1],
    /// The number of triangles, or [`TOO_MANY`].
    count: u32,
}

impl<'a> Collapse<'a> {
    /// Finds the costs. `is_triangle` tells whether a primitive may share a leaf.
    pub fn of(bvh: &'a Bvh, is_triangle: impl Fn(u32) -> bool) -> Self {
        let mut collapse = Self { bvh, weights: vec![Weight::default(); bvh.pairs.len()] };
        // Each pair after those below it.
        for pair in (0..bvh.pairs.len() as u32).rev() {
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
            0 => self.weights[child.first() as usize].count,
            count => {
                let mut own = self.bvh.primitives[child.first() as usize..][..count as usize].iter();
                if own.all(|primitive| is_triangle(*primitive)) { count } else { TOO_MANY }
            }
        };
        self.weights[pair as usize].count = (count(&children[0]) + count(&children[1])).min(TOO_MANY);
        let whole = Child::new(children[0].bounds().union(&children[1].bounds()), pair);
        let one = self.leaf_cost(&whole).min(self.node_cost(&whole));
        let two = one.min(self.split(pair, 2).0);
        self.weights[pair as usize].costs = [one, two, two.min(self.split(pair, 3).0)];
    }

    /// Cost of an inner node's subtree as one leaf.
    fn leaf_cost(&self, child: &Child) -> f32 {
        let count = self.weights[child.first() as usize].count;
        if count > MAX_LEAF_COUNT { f32::INFINITY } else { area(child) * count as f32 }
    }

    /// Cost of an inner node's subtree with that node on the device.
    fn node_cost(&self, child: &Child) -> f32 {
        self.split(child.first(), WIDTH).0 + area(child) * NODE_COST
    }

    /// Least cost of a subtree that may become up to `slots` nodes.
    fn cost(&self, child: &Child, slots: usize) -> f32 {
        match child.count() {
            0 => self.weights[child.first() as usize].costs[slots - 1],
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
            let least = self.cost(child, slots);
            match (1..slots).find(|fewer| self.cost(child, *fewer) <= least).unwrap_or(slots) {
                1 => children.push(*child),
                needed => self.spread(child.first(), needed, children),
            }
        }
    }
}

fn area(child: &Child) -> f32 {
    // A box that no ray enters costs nothing.
    let bounds = child.bounds();
    if bounds.valid() { bounds.half_area() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use glam::Vec3A;
    use obvhs::aabb::Aabb;

    use super::*;
    use crate::gpu_scene::bvh::{CompactBox, build};

    /// The cost of what a pair becomes on the device.
    fn cost(collapse: &Collapse, pair: u32, bounds: &Aabb) -> f64 {
        let below: f64 = collapse
            .children(pair)
            .iter()
            .map(|child| match collapse.leaf(child) {
                Some(primitives) => f64::from(area(child)) * primitives.len() as f64,
                None => cost(collapse, child.first(), &child.bounds()),
            })
            .sum();
        below + f64::from(bounds.half_area() * NODE_COST)
    }

    /// The least cost by trying every way: a subtree becomes a leaf, a node, or up to `slots` nodes.
    fn least(bvh: &Bvh, child: &Child, slots: usize) -> f64 {
        let mut primitives = Vec::new();
        Collapse { bvh, weights: Vec::new() }.gather(child, &mut primitives);
        let is_small = primitives.len() <= MAX_LEAF_COUNT as usize;
        let leaf = if is_small { f64::from(area(child)) * primitives.len() as f64 } else { f64::INFINITY };
        if child.count() > 0 {
            return leaf;
        }
        let [left, right] = &bvh.pairs[child.first() as usize];
        let split = |slots: usize| {
            (1..slots)
                .map(|first| least(bvh, left, first) + least(bvh, right, slots - first))
                .fold(f64::INFINITY, f64::min)
        };
        leaf.min(split(WIDTH) + f64::from(area(child) * NODE_COST)).min(split(slots))
    }

    #[test]
    fn the_cost_is_the_least_of_all_ways() {
        for count in [2, 3, 9, 16, 23] {
            let boxes: Vec<CompactBox> = (0..count)
                .map(|i| {
                    let lower = Vec3A::new((i * 7 % 11) as f32, (i * 5 % 13) as f32, (i * 3 % 17) as f32);
                    Aabb::new(lower, lower + Vec3A::new(1.0, 0.1 * i as f32, 2.0)).into()
                })
                .collect();
            let bvh = build(&boxes, &(0..count).collect::<Vec<u32>>(), 64);
            let collapse = Collapse::of(&bvh, |_| true);
            let bounds = bvh.pairs[0][0].bounds().union(&bvh.pairs[0][1].bounds());
            let found = cost(&collapse, 0, &bounds);
            let [left, right] = &bvh.pairs[0];
            let ways = (1..WIDTH).map(|first| least(&bvh, left, first) + least(&bvh, right, WIDTH - first));
            let expected = ways.fold(f64::INFINITY, f64::min) + f64::from(bounds.half_area() * NODE_COST);
            assert!((found / expected - 1.0).abs() < 1e-5, "{count}: {found}, {expected}");
        }
    }
}
