//! The tree of guided emission: a density over the six numbers by which a photon begins, learned from the photons of a
//! pilot. `shaders/include/light/guide.glsl` warps numbers by it.
//!
//! The best density in a cell is proportional to the square root of the mean square of what its photons bring, over
//! their mean cost: it minimizes the product of variance and time. A tree of cells then has the product of (sum over
//! leaves of sqrt(Q C))², where Q and C are the integrals of squares and costs over a leaf (by the Cauchy-Schwarz
//! inequality). A cell is split where this helps photons that the split was not chosen by.

use crate::kernels::{GUIDE_LEAF, GuideNode};

/// The number of numbers by which a photon begins.
pub const AXES: usize = 6;
/// The most leaves of a tree.
const MOST_LEAVES: usize = 2048;
/// The number of nodes of the largest tree.
pub const MOST_NODES: usize = 2 * MOST_LEAVES - 1;
/// The deepest leaf: the kernel's loop is short.
const MOST_DEPTH: u32 = 64;
/// A cell with fewer photons is not split.
const FEWEST: usize = 32;
/// Parts of a cell along an axis; it is split between two of them.
const BINS: usize = 16;
/// A split must lower the product of variance and time at least by this factor.
const WORTH: f64 = 0.98;
/// The photons that the expectation of a cell counts as in its parts: a part without hits is not known to be dark.
const BELIEF: f64 = 8.0;

/// A photon of a pilot.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// The numbers by which it began.
    pub numbers: [f32; AXES],
    /// 1 over the density of such numbers among all samples, over the number of samples.
    pub weight: f64,
    /// The square of what a photon with these numbers brings if the density is 1 everywhere.
    pub square: f64,
    /// Its cost; 1 for a path that ends at once.
    pub cost: f64,
}

/// Integrals over a cell of squares and of costs.
#[derive(Clone, Copy, Debug, Default)]
struct Integrals {
    square: f64,
    cost: f64,
}

impl Integrals {
    fn add(&mut self, sample: &Sample) {
        self.square += sample.weight * sample.square;
        self.cost += sample.weight * sample.cost;
    }

    fn plus(self, other: Self) -> Self {
        Self { square: self.square + other.square, cost: self.cost + other.cost }
    }

    fn minus(self, other: Self) -> Self {
        // Rounding must not make an integral negative.
        Self { square: (self.square - other.square).max(0.0), cost: (self.cost - other.cost).max(0.0) }
    }

    /// Returns the integrals of a part of a cell, with those that a share of the cell's volume would have, `belief`
    /// times.
    fn smoothed(self, cell: Self, share: f64, belief: f64) -> Self {
        let mix = |part: f64, whole: f64| (part + belief * share * whole) / (1.0 + belief);
        Self { square: mix(self.square, cell.square), cost: mix(self.cost, cell.cost) }
    }

    /// Returns the mass that the best density gives to a leaf, up to a factor.
    fn mass(self) -> f64 {
        (self.square * self.cost).sqrt()
    }
}

/// A node while the tree is learned.
struct Cell {
    lower: [f64; AXES],
    extent: [f64; AXES],
    depth: u32,
    /// The range of its samples in the order.
    samples: std::ops::Range<usize>,
    integrals: Integrals,
    split: Option<Split>,
    /// The node of the lower part; 0 for a leaf.
    child: usize,
}

/// A place to split a cell.
#[derive(Clone, Copy, Debug)]
struct Split {
    axis: usize,
    /// The bin that the upper part begins with.
    bin: usize,
    /// By how much it lowers the sum of masses.
    gain: f64,
}

impl Split {
    fn at(self) -> f64 {
        self.bin as f64 / BINS as f64
    }
}

/// A density over the numbers by which a photon begins.
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

    /// Learns the best density from samples, mixed with a uniform density that has a share of all photons. Returns the
    /// uniform density if the samples bring nothing.
    pub fn learn(samples: &[Sample], uniform_share: f64) -> Self {
        let mut order: Vec<u32> = (0..samples.len() as u32).collect();
        let mut root = Cell {
            lower: [0.0; AXES],
            extent: [1.0; AXES],
            depth: 0,
            samples: 0..samples.len(),
            integrals: Integrals::default(),
            split: None,
            child: 0,
        };
        samples.iter().for_each(|sample| root.integrals.add(sample));
        if root.integrals.square <= 0.0 {
            return Self::uniform();
        }
        root.split = best_split(&root, samples, &order);
        let mut cells = vec![root];
        while cells.len() + 2 <= MOST_NODES {
            let gain = |cell: &Cell| cell.split.map_or(0.0, |split| split.gain);
            let best = (0..cells.len()).max_by(|a, b| gain(&cells[*a]).total_cmp(&gain(&cells[*b])).then(b.cmp(a)));
            let Some(best) = best.filter(|best| cells[*best].split.is_some()) else { break };
            let [lower, upper] = divide(&mut cells[best], samples, &mut order);
            cells[best].child = cells.len();
            for mut part in [lower, upper] {
                part.split = best_split(&part, samples, &order);
                cells.push(part);
            }
        }
        Self::from_cells(&cells, samples.len(), uniform_share)
    }

    fn from_cells(cells: &[Cell], count: usize, uniform_share: f64) -> Self {
        let chances = chances(cells, count, uniform_share);
        let node = |(index, cell): (usize, &Cell)| {
            let volume: f64 = cell.extent.iter().product();
            if cell.child == 0 {
                return leaf((volume / chances[index]) as f32);
            }
            // A chance of 0 or 1 would divide by 0.
            let share = (chances[cell.child] / chances[index]).clamp(1e-30, 1.0 - 1e-7);
            let extent = |index: usize| cells[index].extent;
            let axis =
                (0..AXES).find(|axis| extent(cell.child)[*axis] != cell.extent[*axis]).expect("a part is smaller");
            let at = extent(cell.child)[axis] / cell.extent[axis];
            GuideNode { axis: axis as u32, lower: cell.child as u32, at: at as f32, value: share as f32 }
        };
        Self { nodes: cells.iter().enumerate().map(node).collect() }
    }

    /// Returns the density at some numbers.
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

    /// Returns by which factor this density lowers the product of variance and time, as far as samples tell.
    pub fn gain(&self, samples: &[Sample]) -> f64 {
        let (mut before, mut after) = (Integrals::default(), Integrals::default());
        for sample in samples {
            let density = self.density(&sample.numbers);
            before.add(sample);
            after.add(&Sample { square: sample.square / density, cost: sample.cost * density, ..*sample });
        }
        let product = |integrals: Integrals| integrals.square * integrals.cost;
        if product(after) > 0.0 { product(before) / product(after) } else { 1.0 }
    }
}

/// Returns by which factor a density that is learned from half of the samples lowers the product of variance and time of
/// the other half: the mean of both halves' logarithms.
pub fn gain_of_halves(samples: &[Sample], uniform_share: f64) -> f64 {
    let half = |parity: usize| -> Vec<Sample> { samples.iter().skip(parity).step_by(2).copied().collect() };
    let [even, odd] = [half(0), half(1)];
    let gain = |learned: &[Sample], tested: &[Sample]| Tree::learn(learned, uniform_share).gain(tested);
    (gain(&even, &odd) * gain(&odd, &even)).sqrt()
}

fn leaf(weight: f32) -> GuideNode {
    GuideNode { axis: GUIDE_LEAF, lower: 0, at: 0.0, value: weight }
}

/// Returns the chance of each cell: of leaves by the best density, of others as the sum of their parts.
fn chances(cells: &[Cell], count: usize, uniform_share: f64) -> Vec<f64> {
    // Parts come after their cell.
    let mut smoothed = vec![cells[0].integrals; cells.len()];
    for (index, cell) in cells.iter().enumerate().filter(|(_, cell)| cell.child != 0) {
        let belief = BELIEF / cell.samples.len().max(1) as f64;
        let volume = |cell: &Cell| cell.extent.iter().product::<f64>();
        for part in [cell.child, cell.child + 1] {
            let share = volume(&cells[part]) / volume(cell);
            smoothed[part] = cells[part].integrals.smoothed(smoothed[index], share, belief);
        }
    }
    debug_assert!(count > 0);
    let mut chances: Vec<f64> = smoothed.iter().map(|integrals| integrals.mass()).collect();
    let leaves = || (0..cells.len()).filter(|index| cells[*index].child == 0);
    let total: f64 = leaves().map(|index| chances[index]).sum();
    for index in leaves() {
        let volume: f64 = cells[index].extent.iter().product();
        chances[index] = (1.0 - uniform_share) * chances[index] / total + uniform_share * volume;
    }
    for (index, cell) in cells.iter().enumerate().rev().filter(|(_, cell)| cell.child != 0) {
        chances[index] = chances[cell.child] + chances[cell.child + 1];
    }
    chances
}

/// Returns the bin of a number along an axis of a cell.
fn bin_of(cell: &Cell, axis: usize, number: f32) -> usize {
    let place = (f64::from(number) - cell.lower[axis]) / cell.extent[axis];
    ((place * BINS as f64) as usize).min(BINS - 1)
}

/// Splits a cell as it says.
fn divide(cell: &mut Cell, samples: &[Sample], order: &mut [u32]) -> [Cell; 2] {
    let split = cell.split.take().expect("the cell has a split");
    let range = cell.samples.clone();
    let is_lower = |index: &u32| bin_of(cell, split.axis, samples[*index as usize].numbers[split.axis]) < split.bin;
    // In the order of the samples, on which sums depend.
    let (lower, upper): (Vec<u32>, Vec<u32>) = order[range.clone()].iter().partition(|index| is_lower(index));
    let middle = range.start + lower.len();
    order[range.clone()].copy_from_slice(&[lower, upper].concat());
    [(range.start..middle, true), (middle..range.end, false)].map(|(samples_of_part, is_lower)| {
        let mut part = Cell {
            lower: cell.lower,
            extent: cell.extent,
            depth: cell.depth + 1,
            samples: samples_of_part.clone(),
            integrals: Integrals::default(),
            split: None,
            child: 0,
        };
        let width = split.at() * cell.extent[split.axis];
        part.lower[split.axis] += if is_lower { 0.0 } else { width };
        part.extent[split.axis] = if is_lower { width } else { cell.extent[split.axis] - width };
        for index in &order[samples_of_part] {
            part.integrals.add(&samples[*index as usize]);
        }
        part
    })
}

/// Integrals of the two halves of a cell's samples.
type Halves = [Integrals; 2];

/// Returns the best place to split a cell, if one is worth it.
fn best_split(cell: &Cell, samples: &[Sample], order: &[u32]) -> Option<Split> {
    if cell.samples.len() < FEWEST || cell.depth >= MOST_DEPTH || cell.integrals.square <= 0.0 {
        return None;
    }
    let mut bins = [[Halves::default(); BINS]; AXES];
    for index in &order[cell.samples.clone()] {
        let sample = &samples[*index as usize];
        for (axis, bins) in bins.iter_mut().enumerate() {
            bins[bin_of(cell, axis, sample.numbers[axis])][(*index % 2) as usize].add(sample);
        }
    }
    let belief = BELIEF / cell.samples.len() as f64;
    let both = |halves: Halves| halves[0].plus(halves[1]);
    let before = cell.integrals.mass();
    let mut best: Option<(Split, [Halves; 2])> = None;
    for (axis, bins) in bins.iter().enumerate() {
        // A cell narrower than the numbers' own steps has nothing to learn.
        if cell.extent[axis] < 1e-6 {
            continue;
        }
        let whole = bins.iter().fold(Halves::default(), |sum, bin| [0, 1].map(|half| sum[half].plus(bin[half])));
        let mut lower = Halves::default();
        for bin in 1..BINS {
            lower = [0, 1].map(|half| lower[half].plus(bins[bin - 1][half]));
            let upper = [0, 1].map(|half| whole[half].minus(lower[half]));
            let gain = before - both(lower).mass() - both(upper).mass();
            if best.as_ref().is_none_or(|(split, _)| gain > split.gain) {
                best = Some((Split { axis, bin, gain }, [lower, upper]));
            }
        }
    }
    best.filter(|(split, parts)| split.gain > 0.0 && is_worth(*split, parts, belief)).map(|(split, _)| split)
}

/// Returns whether densities that are learned from one half of the samples are better for the other half.
fn is_worth(split: Split, parts: &[Halves; 2], belief: f64) -> bool {
    let shares = [split.at(), 1.0 - split.at()];
    let mut ratio = 1.0;
    for (learned, tested) in [(0, 1), (1, 0)] {
        let cell = |half: usize| parts[0][half].plus(parts[1][half]);
        let density = [0, 1].map(|part| {
            let Integrals { square, cost } = parts[part][learned].smoothed(cell(learned), shares[part], 2.0 * belief);
            (square / cost.max(f64::MIN_POSITIVE)).sqrt()
        });
        let sum = |term: &dyn Fn(Integrals, f64) -> f64| -> f64 {
            (0..2).map(|part| term(parts[part][tested], density[part])).sum()
        };
        let after = sum(&|part, density| if part.square > 0.0 { part.square / density } else { 0.0 })
            * sum(&|part, density| part.cost * density);
        let before = cell(tested).square * cell(tested).cost;
        if before <= 0.0 {
            return false;
        }
        ratio *= after / before;
    }
    ratio < WORTH
}

#[cfg(test)]
mod tests;
