//! Left-balanced kd-trees over visible points (Bentley 1975; for photon maps, Jensen 2001).
//!
//! In a left-balanced tree all levels are full but the last, which is filled from the left. In heap order,
//! the children of node i are nodes 2i + 1 and 2i + 2. So the tree needs no pointers, and a traversal needs
//! only a few words of memory (`shaders/passes/gather_tree.comp`).
//!
//! The host builds the tree. If the device is the CPU, a build on the device would use the same cores. A
//! build on the device (Wald 2022, "GPU-friendly, Parallel, and (Almost-)In-Place Construction of
//! Left-Balanced k-d Trees") sorts all points once per level; this build partitions them once per level.

use crate::kernels::{AXIS_SHIFT, PIXEL_MASK};

/// A visible point. When it becomes a node, the bits of `pixel` from [`AXIS_SHIFT`] on get the split axis.
#[derive(Clone, Copy)]
struct Point {
    position: [f32; 3],
    pixel: u32,
}

/// Builds the tree over the points whose squared radius is above 0. `points` has the position and the
/// squared radius of each point, at most 2^28 points. Returns for each node, in heap order, the index of its
/// point, and in the bits from [`AXIS_SHIFT`] on the axis at which it splits. On this axis, points in the
/// left subtree have no larger coordinate than the node, and points in the right subtree no smaller one.
pub fn build(points: impl Iterator<Item = ([f32; 3], f32)>) -> Vec<u32> {
    let present = points.enumerate().filter(|(_, (_, radius2))| *radius2 > 0.0);
    let mut points: Vec<Point> =
        present.map(|(pixel, (position, _))| Point { position, pixel: pixel as u32 & PIXEL_MASK }).collect();
    arrange(&mut points);
    let mut nodes = vec![0; points.len()];
    flatten(&points, 0, &mut nodes);
    nodes
}

/// Sorts points into the order left subtree, node, right subtree, recursively.
fn arrange(points: &mut [Point]) {
    if points.is_empty() {
        return;
    }
    let axis = widest_axis(points);
    // Points with the same coordinate are ordered by pixel, so that the tree is unique.
    let (left, node, right) = points.select_nth_unstable_by(left_size(points.len()), |a, b| {
        a.position[axis].total_cmp(&b.position[axis]).then(a.pixel.cmp(&b.pixel))
    });
    node.pixel |= (axis as u32) << AXIS_SHIFT;
    arrange(left);
    arrange(right);
}

/// Returns the axis along which the extent of the points is largest. Visible points lie on surfaces, and a
/// split along the thickness of a wall would waste a level.
fn widest_axis(points: &[Point]) -> usize {
    let mut lower = [f32::INFINITY; 3];
    let mut upper = [f32::NEG_INFINITY; 3];
    for point in points {
        for axis in 0..3 {
            lower[axis] = lower[axis].min(point.position[axis]);
            upper[axis] = upper[axis].max(point.position[axis]);
        }
    }
    let extent = |axis: &usize| upper[*axis] - lower[*axis];
    (0..3).max_by(|a, b| extent(a).total_cmp(&extent(b))).unwrap_or(0)
}

/// Returns the number of nodes in the left subtree of a left-balanced tree of `count` nodes; `count` is not
/// 0.
fn left_size(count: usize) -> usize {
    let last_level = 1 << count.ilog2();
    // The left subtree has up to half of the last level, and `half - 1` nodes above it.
    let half = last_level / 2;
    let above = half.max(1) - 1;
    above + (count + 1 - last_level).min(half)
}

/// Writes arranged points in heap order into the subtree of `node`.
fn flatten(points: &[Point], node: usize, nodes: &mut [u32]) {
    if points.is_empty() {
        return;
    }
    let left = left_size(points.len());
    nodes[node] = points[left].pixel;
    flatten(&points[..left], 2 * node + 1, nodes);
    flatten(&points[left + 1..], 2 * node + 2, nodes);
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::{AXIS_SHIFT, PIXEL_MASK, left_size};

    /// Builds the tree over points whose fourth number is their squared radius.
    fn build(points: &[[f32; 4]]) -> Vec<u32> {
        super::build(points.iter().map(|&[x, y, z, radius2]| ([x, y, z], radius2)))
    }

    /// Checks all properties of a tree.
    fn assert_tree(points: &[[f32; 4]]) {
        let nodes = build(points);
        let mut pixels: Vec<usize> = nodes.iter().map(|node| (node & PIXEL_MASK) as usize).collect();
        pixels.sort_unstable();
        let present: Vec<usize> = (0..points.len()).filter(|pixel| points[*pixel][3] > 0.0).collect();
        assert_eq!(pixels, present, "each point once");
        for node in 1..nodes.len() {
            assert_splits(points, &nodes, node);
        }
    }

    /// Checks a node against all nodes above it.
    fn assert_splits(points: &[[f32; 4]], nodes: &[u32], node: usize) {
        let point = points[(nodes[node] & PIXEL_MASK) as usize];
        let mut child = node;
        while child > 0 {
            let parent = (child - 1) / 2;
            let axis = (nodes[parent] >> AXIS_SHIFT) as usize;
            let split = points[(nodes[parent] & PIXEL_MASK) as usize][axis];
            let is_left = child % 2 == 1;
            assert!(
                if is_left { point[axis] <= split } else { point[axis] >= split },
                "node {node} is on the wrong side of node {parent}"
            );
            child = parent;
        }
    }

    #[test]
    fn left_subtrees_have_as_many_nodes_as_heap_order_gives_them() {
        for count in 1..2000 {
            let mut size = 0;
            let (mut first, mut width) = (1, 1);
            while first < count {
                size += width.min(count - first);
                (first, width) = (2 * first + 1, 2 * width);
            }
            assert_eq!(left_size(count), size, "of {count}");
        }
    }

    #[test]
    fn few_points_make_a_tree() {
        let points = [[0.5, 2.0, 0.0, 0.1], [0.25, -1.0, 0.0, 0.1], [0.0, 7.0, 0.0, 0.1]];
        assert!(build(&[]).is_empty());
        assert!(build(&[[1.0, 2.0, 3.0, 0.0]]).is_empty());
        (1..=3).for_each(|count| assert_tree(&points[..count]));
        let y = 1 << AXIS_SHIFT;
        // The last axis is the widest of a single point.
        let z = 2 << AXIS_SHIFT;
        assert_eq!(build(&points), [y, 1 | z, 2 | z]);
        // The last level is filled from the left.
        assert_eq!(build(&points[..2]), [y, 1 | z]);
    }

    #[test]
    fn sorted_points_make_a_tree() {
        let line = |step: f32| (0..5000).map(move |i| [1.0, step * i as f32, 2.0, 0.1]).collect::<Vec<_>>();
        assert_tree(&line(1.0));
        assert_tree(&line(-1.0));
    }

    #[test]
    fn equal_points_make_a_tree() {
        assert_tree(&vec![[0.5, -0.25, 0.0, 0.01]; 5000]);
    }

    proptest! {
        #[test]
        fn any_points_make_a_tree(points in prop::collection::vec(
            (prop::array::uniform3(-1e9_f32..1e9), 0..4_u8), 0..300,
        )) {
            let points: Vec<_> = points.iter().map(|&([x, y, z], w)| [x, y, z, f32::from(w)]).collect();
            assert_tree(&points);
        }

        /// Many share coordinates, of either zero too.
        #[test]
        fn points_of_a_lattice_make_a_tree(cells in prop::collection::vec(0..27_usize, 0..300)) {
            let coordinate = |cell: usize| [-0.0, 0.0, 1.0][cell % 3];
            let points: Vec<_> =
                cells.iter().map(|cell| [coordinate(*cell), coordinate(cell / 3), coordinate(cell / 9), 0.1]).collect();
            assert_tree(&points);
        }
    }
}
