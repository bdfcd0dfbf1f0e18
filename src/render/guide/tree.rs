//! The tree of guided emission: a density of the six random numbers by which a photon is emitted, learned from the photons
//! of a pilot. `shaders/include/light/guide.glsl` warps random numbers by this density.
//!
//! The best density of a cell is proportional to sqrt(q / c), where q is the mean square of the light that its photons
//! bring, and c is their mean cost. It minimizes the product of variance and time. With this density in each leaf, the
//! product is (sum over leaves of sqrt(Q C))², where Q and C are the integrals of squares and of costs over a leaf (by the
//! Cauchy-Schwarz inequality). A cell is split where the split lowers its mass sqrt(Q C) by more than noise would.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::cell::{AXES, Cell, Integrals, Sample, Split, Term};
use crate::kernels::{GUIDE_LEAF, GuideNode};

/// The largest number of leaves of a tree.
pub const MOST_LEAVES: usize = 2048;
/// The number of nodes of the largest tree.
pub const MOST_NODES: usize = 2 * MOST_LEAVES - 1;

/// How much a tree may rely on its samples.
#[derive(Clone, Copy, Debug)]
pub struct Caution {
    /// The share of all photons that are emitted with density 1.
    pub uniform_share: f64,
    /// The share of a cell's probability that is spread over its volume. A part in which no sample brings light may still
    /// not be dark.
    pub spread: f64,
    /// The least decrease of a cell's mass by a split, as a share of the mass times the effective number of samples. The
    /// share by which noise lowers the mass is proportional to 1 over this number.
    pub penalty: f64,
    /// The largest number of leaves, at most [`MOST_LEAVES`].
    pub leaves: usize,
}

/// A density of the random numbers by which a photon is emitted.
#[derive(Clone, Debug)]
pub struct Tree {
    /// The nodes, as kernels read them.
    pub nodes: Vec<GuideNode>,
}

impl Tree {
    /// Returns the density that is 1 everywhere.
    pub fn uniform() -> Self {
        Self { nodes: vec![leaf(1.0)] }
    }

    /// Returns whether the density is 1 everywhere.
    pub fn is_uniform(&self) -> bool {
        self.nodes.len() == 1
    }

    /// Returns the best density for the samples, within the limits of `caution`; the density that is 1 everywhere if no
    /// sample brings light.
    pub fn learn(samples: &[Sample], caution: Caution) -> Self {
        let mut terms: Vec<Term> = samples.iter().map(Term::of).collect();
        let mut cells = vec![Cell::root(&terms)];
        if cells[0].integrals.square <= 0.0 {
            return Self::uniform();
        }
        let mut splits = Vec::new();
        // Cells ordered by the gain of their best split. The bits of positive numbers have the order of the numbers.
        let mut gains = BinaryHeap::new();
        let consider = |cell: &Cell, terms: &[Term], splits: &mut Vec<Option<Split>>, gains: &mut BinaryHeap<_>| {
            let split = cell.best_split(terms, caution.penalty);
            gains.extend(split.map(|split| (split.gain.to_bits(), Reverse(splits.len()))));
            splits.push(split);
        };
        consider(&cells[0], &terms, &mut splits, &mut gains);
        while cells.len() + 2 <= 2 * caution.leaves.min(MOST_LEAVES) {
            let Some((_, Reverse(index))) = gains.pop() else { break };
            let Some(split) = splits[index] else { break };
            cells[index].child = Some(cells.len());
            for part in cells[index].divide(split, &mut terms) {
                consider(&part, &terms, &mut splits, &mut gains);
                cells.push(part);
            }
        }
        Self::from_cells(&cells, &splits, caution)
    }

    /// Returns the tree of cells, with the split of each inner cell.
    fn from_cells(cells: &[Cell], splits: &[Option<Split>], caution: Caution) -> Self {
        let chances = chances(cells, caution);
        let node = |(index, cell): (usize, &Cell)| match (cell.child, splits[index]) {
            (Some(child), Some(Split { axis, .. })) => GuideNode {
                axis: axis as u32,
                lower: child as u32,
                at: (cells[child].extent[axis] / cell.extent[axis]) as f32,
                // A probability of 0 or 1 would lead to a division by 0.
                value: (chances[child] / chances[index]).clamp(1e-30, 1.0 - 1e-7) as f32,
            },
            _ => leaf((cell.volume() / chances[index]) as f32),
        };
        Self { nodes: cells.iter().enumerate().map(node).collect() }
    }

    /// Returns the density at a point of the space of random numbers.
    pub fn density(&self, numbers: &[f32; AXES]) -> f64 {
        let (mut lower, mut extent) = ([0.0_f64; AXES], [1.0_f64; AXES]);
        let mut node = &self.nodes[0];
        while node.axis != GUIDE_LEAF {
            let axis = node.axis as usize;
            let width = f64::from(node.at) * extent[axis];
            let is_lower = f64::from(numbers[axis]) < lower[axis] + width;
            lower[axis] += if is_lower { 0.0 } else { width };
            extent[axis] = if is_lower { width } else { extent[axis] - width };
            node = &self.nodes[node.lower as usize + usize::from(!is_lower)];
        }
        1.0 / f64::from(node.value)
    }

    /// Returns the factor by which this density lowers the product of variance and time, estimated from samples.
    pub fn gain(&self, samples: &[Sample]) -> f64 {
        let (mut before, mut after) = (Integrals::default(), Integrals::default());
        for sample in samples {
            let density = self.density(&sample.numbers);
            before = before.plus(Integrals::of(sample));
            let guided = Sample { square: sample.square / density, cost: sample.cost * density, ..*sample };
            after = after.plus(Integrals::of(&guided));
        }
        let product = |integrals: Integrals| integrals.square * integrals.cost;
        if product(after) > 0.0 { product(before) / product(after) } else { 1.0 }
    }
}

/// Returns the factor by which a learned density lowers the product of variance and time: the geometric mean of two
/// estimates, each with a density that is learned from one half of the samples and applied to the other half.
pub fn gain_of_halves(samples: &[Sample], caution: Caution) -> f64 {
    let half = |parity: usize| -> Vec<Sample> { samples.iter().skip(parity).step_by(2).copied().collect() };
    let [even, odd] = [half(0), half(1)];
    let gain = |learned: &[Sample], tested: &[Sample]| Tree::learn(learned, caution).gain(tested);
    (gain(&even, &odd) * gain(&odd, &even)).sqrt()
}

fn leaf(weight: f32) -> GuideNode {
    GuideNode { axis: GUIDE_LEAF, lower: 0, at: 0.0, value: weight }
}

/// Returns the probability of each cell. That of a leaf is by the best density; that of another cell is the sum of its
/// parts. A share of each cell's probability is spread over its volume, and a share of the whole over the unit cube.
fn chances(cells: &[Cell], caution: Caution) -> Vec<f64> {
    let inner = || cells.iter().enumerate().filter_map(|(index, cell)| cell.child.map(|child| (index, child)));
    let mut best: Vec<f64> = cells.iter().map(|cell| cell.volume() * cell.integrals.best_density()).collect();
    // The parts of a cell have larger indices than the cell.
    for (index, child) in inner().collect::<Vec<_>>().into_iter().rev() {
        best[index] = best[child] + best[child + 1];
    }
    let mut learned = vec![1.0; cells.len()];
    for (index, child) in inner() {
        for part in [child, child + 1] {
            let of_best = if best[index] > 0.0 { best[part] / best[index] } else { 0.0 };
            let of_volume = cells[part].volume() / cells[index].volume();
            learned[part] = learned[index] * (of_best + caution.spread * (of_volume - of_best));
        }
    }
    let mix = |(cell, learned): (&Cell, f64)| learned + caution.uniform_share * (cell.volume() - learned);
    cells.iter().zip(learned).map(mix).collect()
}

#[cfg(test)]
mod tests;
