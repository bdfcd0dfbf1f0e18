//! Wide hierarchies, which the device traverses: inner nodes have up to four children.

use obvhs::aabb::Aabb;

use crate::gpu_scene::collapse::Collapse;
use crate::kernels::{
    BVH_PLANES, BVH_WIDTH, COUNT_SHIFT, INDEX_MASK, INSTANCE, INSTANCE_LEAF, KIND_SHIFT, MAX_BVH_NODES, NONE,
    QUADRIC_LEAF, REVOLUTION, REVOLUTION_LEAF, TRIANGLE,
};

const WIDTH: usize = BVH_WIDTH as usize;
/// A coordinate beyond all boxes.
const FAR: f32 = 3e38;

/// The arrays of hierarchies on the device.
#[derive(Default)]
pub struct Wide {
    /// [`BVH_PLANES`] of each inner node.
    pub planes: Vec<[f32; 4]>,
    /// References to the children of each inner node.
    pub children: Vec<[u32; 4]>,
    /// Indices of triangles, in the order of the leaves. References to leaves count in this order.
    pub triangles: Vec<u32>,
}

impl Wide {
    /// Appends the hierarchy below the pair `root`, and returns the index of its root.
    pub fn append(&mut self, collapse: &Collapse, root: u32) -> u32 {
        let first = self.reserve();
        let mut pending = vec![(first, root)];
        while let Some((node, pair)) = pending.pop() {
            // No ray enters a box that is not valid.
            let children = collapse.children(pair).into_iter().filter(|child| child.bounds().valid());
            for (slot, child) in children.enumerate() {
                let reference = match collapse.leaf(&child) {
                    Some(primitives) => self.add_leaf(&primitives, child.bounds()),
                    None => {
                        let index = self.reserve();
                        pending.push((index, child.first()));
                        index
                    }
                };
                self.set(node, slot, &child.bounds(), reference);
            }
        }
        first
    }

    /// Returns whether the nodes can be numbered.
    pub fn fits(&self) -> bool {
        self.children.len() <= MAX_BVH_NODES as usize
    }

    /// Adds a node without children: boxes that are inverted, at the largest distance.
    fn reserve(&mut self) -> u32 {
        let (lower, upper) = ([[FAR; 4]; 3], [[-FAR; 4]; 3]);
        self.planes.extend(lower);
        self.planes.extend(upper);
        self.children.push([NONE; 4]);
        self.children.len() as u32 - 1
    }

    fn set(&mut self, node: u32, slot: usize, bounds: &Aabb, reference: u32) {
        let planes = &mut self.planes[(node * BVH_PLANES) as usize..];
        for axis in 0..3 {
            planes[axis][slot] = bounds.min[axis];
            planes[axis + 3][slot] = bounds.max[axis];
        }
        self.children[node as usize][slot] = reference;
    }

    /// Adds the primitives of a leaf, and returns the reference to it: to a node of several leaves if a leaf of
    /// the device cannot have them all.
    fn add_leaf(&mut self, primitives: &[u32], bounds: Aabb) -> u32 {
        let (triangles, others): (Vec<u32>, Vec<u32>) =
            primitives.iter().partition(|primitive| **primitive >> KIND_SHIFT == TRIANGLE);
        let mut references: Vec<u32> = others.into_iter().map(leaf_of).collect();
        if !triangles.is_empty() {
            references.push((triangles.len() as u32) << COUNT_SHIFT | self.triangles.len() as u32);
            self.triangles.extend(triangles.iter().map(|triangle| triangle & INDEX_MASK));
        }
        // Nodes over four references each, until there is one left.
        while references.len() > 1 {
            let merged = references.len().min(WIDTH);
            let node = self.reserve();
            for (slot, reference) in references.drain(..merged).enumerate() {
                self.set(node, slot, &bounds, reference);
            }
            references.push(node);
        }
        references.first().copied().unwrap_or(NONE)
    }
}

/// Returns the reference to the leaf of a primitive that is no triangle.
fn leaf_of(primitive: u32) -> u32 {
    let kind = match primitive >> KIND_SHIFT {
        INSTANCE => INSTANCE_LEAF,
        REVOLUTION => REVOLUTION_LEAF,
        _ => QUADRIC_LEAF,
    };
    kind << COUNT_SHIFT | primitive & INDEX_MASK
}

#[cfg(test)]
mod tests {
    use glam::Vec3A;

    use super::*;
    use crate::gpu_scene::bvh::{CompactBox, build};
    use crate::kernels::{DISK, FIRST_MASK, MAX_LEAF_COUNT};

    /// Returns how often a walk from the node reaches each triangle and each quadric, by their indices; checks
    /// that boxes contain the boxes below them.
    fn visits(wide: &Wide, root: u32, count: usize) -> [Vec<u32>; 2] {
        let mut visits = [vec![0; count], vec![0; count]];
        let mut pending = vec![(root, [f32::NEG_INFINITY; 3], [f32::INFINITY; 3])];
        while let Some((node, lower, upper)) = pending.pop() {
            let planes = &wide.planes[(node * BVH_PLANES) as usize..];
            for (slot, reference) in wide.children[node as usize].into_iter().enumerate() {
                let (low, high) = ([0, 1, 2].map(|axis| planes[axis][slot]), [3, 4, 5].map(|axis| planes[axis][slot]));
                if reference == NONE {
                    assert!((0..3).all(|axis| low[axis] == FAR && high[axis] == -FAR));
                    continue;
                }
                assert!((0..3).all(|axis| lower[axis] <= low[axis] && high[axis] <= upper[axis]));
                let index = reference & FIRST_MASK;
                match reference >> COUNT_SHIFT {
                    0 => pending.push((index, low, high)),
                    QUADRIC_LEAF => visits[1][index as usize] += 1,
                    length => {
                        assert!(length <= MAX_LEAF_COUNT);
                        (index..index + length)
                            .for_each(|place| visits[0][wide.triangles[place as usize] as usize] += 1);
                    }
                }
            }
        }
        visits
    }

    #[test]
    fn every_primitive_is_in_one_leaf() {
        for count in [1, 2, 5, 17, 400] {
            let boxes: Vec<CompactBox> = (0..count)
                .map(|i| {
                    // Many in one place, so that leaves are full.
                    let center = Vec3A::new((i % 7) as f32, (i % 3) as f32, 0.0) * 0.1;
                    Aabb::new(center, center + 0.01).into()
                })
                .collect();
            for divisor in [1, 2, 3, 1000] {
                let is_quadric = |i: u32| i.is_multiple_of(divisor);
                let reference = |i: u32| if is_quadric(i) { DISK } else { TRIANGLE } << KIND_SHIFT | i;
                let bvh = build(&boxes, &(0..count as u32).map(reference).collect::<Vec<u32>>(), 64);
                let collapse = Collapse::of(&bvh, |reference| reference >> KIND_SHIFT == TRIANGLE);
                let mut wide = Wide::default();
                wide.append(&collapse, 0);
                let root = wide.append(&collapse, 0);
                let [triangles, quadrics] = visits(&wide, root, count);
                for i in 0..count {
                    let expected = if is_quadric(i as u32) { (0, 1) } else { (1, 0) };
                    assert_eq!((triangles[i], quadrics[i]), expected, "{i} of {count}");
                }
            }
        }
    }
}
