//! guide.glsl: the numbers by which photons begin, warped by a tree.

use crate::fixture::{Fixture, Rng};
use crate::generated::{EmissionNumbers, GUIDE_LEAF, GuideLight, GuideNode, WarpEmission, Warped};
use crate::statistics::{assert_near, assert_uniform, cells};

const COUNT: usize = 1 << 18;

/// The lights of all tests here: chances of 1/2, 1/4 and 1/4, in another order than that of their numbers.
const LIGHTS: [GuideLight; 3] = [
    GuideLight { end: 0.25, light: 2, pad0: 0, pad1: 0 },
    GuideLight { end: 0.75, light: 0, pad0: 0, pad1: 0 },
    GuideLight { end: 1.0, light: 1, pad0: 0, pad1: 0 },
];

fn inner(axis: u32, lower: u32, at: f32, share: f32) -> GuideNode {
    GuideNode { axis, lower, at, value: share }
}

fn leaf(weight: f32) -> GuideNode {
    GuideNode { axis: GUIDE_LEAF, lower: 0, at: 0.0, value: weight }
}

/// Numbers in [0, 1) with six dimensions each.
fn numbers() -> Vec<EmissionNumbers> {
    let mut rng = Rng(11);
    let mut pair = || [rng.unit_f32(), rng.unit_f32()];
    let numbers = |_| EmissionNumbers {
        light: pair(),
        position: pair(),
        direction: pair(),
        weight: 1.0,
        pad: LIGHTS.len() as u32,
    };
    (0..COUNT).map(numbers).collect()
}

fn warp(nodes: &[GuideNode], numbers: &[EmissionNumbers]) -> Vec<Warped> {
    let fixture = Fixture::new();
    let (guide_nodes, guide_lights) = (fixture.upload_texels(nodes), fixture.upload_texels(&LIGHTS));
    let (numbers, warped) = (fixture.upload(numbers), fixture.output(numbers.len()));
    let kernel =
        WarpEmission { guide_nodes: &guide_nodes, guide_lights: &guide_lights, numbers: &numbers, warped: &warped };
    fixture.run(&kernel, numbers.len() as usize);
    fixture.read(&warped)
}

fn of(warped: &Warped) -> [f64; 6] {
    let Warped { light, position, direction, .. } = warped;
    [light[0], light[1], position[0], position[1], direction[0], direction[1]].map(f64::from)
}

/// The volume and the chance of a leaf, the corner and the extent of its cell, and its weight.
type Leaf = (f64, f64, [f64; 6], [f64; 6], f32);

fn leaves(nodes: &[GuideNode]) -> Vec<Leaf> {
    let mut open = vec![(0_usize, 1.0, [0.0; 6], [1.0; 6])];
    let mut leaves = Vec::new();
    while let Some((index, chance, corner, extent)) = open.pop() {
        let node = nodes[index];
        if node.axis == GUIDE_LEAF {
            leaves.push((extent.iter().product(), chance, corner, extent, node.value));
            continue;
        }
        let (axis, at, share) = (node.axis as usize, f64::from(node.at), f64::from(node.value));
        let width = at * extent[axis];
        let (mut lower, mut upper, mut beyond) = (extent, extent, corner);
        lower[axis] = width;
        upper[axis] -= width;
        beyond[axis] += width;
        open.push((node.lower as usize, chance * share, corner, lower));
        open.push((node.lower as usize + 1, chance * (1.0 - share), beyond, upper));
    }
    leaves
}

/// A tree that splits each axis, some of them twice, with cells of very different chances.
fn tree() -> Vec<GuideNode> {
    let mut nodes = vec![
        inner(2, 1, 0.25, 0.5),
        inner(5, 3, 0.5, 0.9),
        inner(0, 5, 0.75, 0.125),
        leaf(0.0),
        inner(4, 7, 0.0625, 0.6),
        leaf(0.0),
        inner(2, 9, 0.5, 0.01),
        leaf(0.0),
        leaf(0.0),
        inner(1, 11, 0.5, 0.3),
        inner(3, 13, 0.9, 0.999),
        leaf(0.0),
        leaf(0.0),
        leaf(0.0),
        leaf(0.0),
    ];
    let weights: Vec<(usize, f32)> = leaf_indices(&nodes).zip(weights(&nodes)).collect();
    weights.into_iter().for_each(|(index, weight)| nodes[index].value = weight);
    nodes
}

/// The leaves in the order of [`leaves`].
fn leaf_indices(nodes: &[GuideNode]) -> impl Iterator<Item = usize> + use<> {
    let mut open = vec![0_usize];
    let mut indices = Vec::new();
    while let Some(index) = open.pop() {
        match nodes[index].axis {
            GUIDE_LEAF => indices.push(index),
            _ => open.extend([nodes[index].lower as usize, nodes[index].lower as usize + 1]),
        }
    }
    indices.into_iter()
}

fn weights(nodes: &[GuideNode]) -> Vec<f32> {
    leaves(nodes).into_iter().map(|(volume, chance, ..)| (volume / chance) as f32).collect()
}

/// Each leaf has its chance of the numbers, spread evenly over its cell, with the weight of the leaf: so that the mean
/// weight is 1, and any function has the same mean as without the tree.
#[test]
fn numbers_are_warped_by_the_density_of_the_leaves() {
    let nodes = tree();
    let warped = warp(&nodes, &numbers());
    let mut total = 0;
    for (index, (volume, chance, corner, extent, weight)) in leaves(&nodes).into_iter().enumerate() {
        let within = |warped: &&Warped| {
            of(warped)
                .iter()
                .zip(corner.iter().zip(extent))
                .all(|(x, (corner, extent))| *x >= *corner && *x < corner + extent)
        };
        let in_leaf: Vec<&Warped> = warped.iter().filter(within).collect();
        total += in_leaf.len();
        // Five standard deviations of a binomial count, and the rounding at the edges of cells.
        let expected = COUNT as f64 * chance;
        let spread = 5.0 * expected.sqrt() + 2.0;
        assert!((in_leaf.len() as f64 - expected).abs() < spread, "leaf {index}: {} of {expected}", in_leaf.len());
        for warped in &in_leaf {
            assert_near(f64::from(warped.weight), volume / chance, 1e-5, "weight");
            assert_eq!(warped.weight, weight);
        }
        if in_leaf.len() > 20_000 {
            for axes in [[0, 1], [2, 3], [4, 5]] {
                let place = |warped: &&Warped| axes.map(|axis| (of(warped)[axis] - corner[axis]) / extent[axis]);
                assert_uniform(&cells(in_leaf.iter().map(place), 16), &format!("leaf {index}, axes {axes:?}"));
            }
        }
    }
    assert_eq!(total, COUNT, "every number is in one leaf");
    let mean = warped.iter().map(|warped| f64::from(warped.weight)).sum::<f64>() / COUNT as f64;
    // The weights' standard deviation is below 10 here.
    assert!((mean - 1.0).abs() < 0.1, "{mean}");
}

/// The deepest tree that the host learns halves a cell sixty-four times, on all axes in turns, and nearly all numbers go
/// to the smallest. None leaves [0, 1).
#[test]
fn deep_trees_keep_numbers_in_their_cells() {
    let mut nodes = Vec::new();
    for depth in 0..64 {
        nodes.push(inner(depth % 6, 2 * depth + 1, 0.5, 0.999));
        nodes.push(leaf(0.0));
    }
    // Children are neighbours: the lower part of each inner node is the next inner node, the upper part a leaf.
    let mut deep = vec![nodes[0]];
    for depth in 1..64_usize {
        deep.push(GuideNode { lower: 2 * depth as u32 + 1, ..nodes[2 * depth] });
        deep.push(leaf(1.0));
    }
    deep.extend([leaf(1.0), leaf(1.0)]);
    let mut numbers = numbers();
    numbers[0] = EmissionNumbers { light: [0.0; 2], position: [0.0; 2], direction: [0.0; 2], ..numbers[0] };
    let last = 1.0 - f32::EPSILON / 2.0;
    numbers[1] = EmissionNumbers { light: [last; 2], position: [last; 2], direction: [last; 2], ..numbers[0] };
    let warped = warp(&deep, &numbers);
    assert!(warped.iter().all(|warped| of(warped).iter().all(|x| (0.0..1.0).contains(x))));
    // Eleven halvings of an axis, or ten.
    let deepest = warped.iter().filter(|warped| of(warped).iter().all(|x| *x < 0.002)).count();
    let expected = 0.999_f64.powi(64) * COUNT as f64;
    assert!((deepest as f64 - expected).abs() < 5.0 * (COUNT as f64 - expected).sqrt() + 0.02 * expected, "{deepest}");
}

/// A number in [0, 1) samples the light in whose range of cumulative chances it is.
#[test]
fn lights_are_sampled_in_the_order_of_the_guide() {
    let mut numbers = numbers();
    for (index, (u, _)) in [(0.0, 2), (0.249_999_99, 2), (0.25, 0), (0.75, 1), (0.999_999_94, 1)].iter().enumerate() {
        numbers[index].light[0] = *u;
    }
    for warped in warp(&[leaf(1.0)], &numbers) {
        let expected = if warped.light[0] < 0.25 {
            2
        } else if warped.light[0] < 0.75 {
            0
        } else {
            1
        };
        assert_eq!(warped.chosen, expected, "{}", warped.light[0]);
    }
}
