//! Cells of the space of random numbers by which a photon is emitted, and the places where they are split.

use std::ops::Range;

/// The number of random numbers by which a photon is emitted.
pub const AXES: usize = 6;
/// The number of bins of a cell along an axis. A cell is split between two bins.
pub const BINS: usize = 16;
/// The largest depth of a cell, which bounds the loop of the kernel.
const MOST_DEPTH: u32 = 64;
/// A cell with fewer photons is not split.
const FEWEST: usize = 32;
/// The least extent of a cell that is split. Random numbers have steps of 6e-8.
const LEAST_EXTENT: f64 = 1e-6;

/// A photon of a pilot.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// The random numbers by which it was emitted.
    pub numbers: [f32; AXES],
    /// 1 / (density of these numbers among all samples × number of samples).
    pub weight: f64,
    /// The square of the light that a photon with these numbers brings if the density is 1 everywhere.
    pub square: f64,
    /// The cost of its path; 1 for a path without records.
    pub cost: f64,
}

/// Integrals over a cell of squares and of costs.
#[derive(Clone, Copy, Debug, Default)]
pub struct Integrals {
    pub square: f64,
    pub cost: f64,
    /// The sum of the squares of the terms of `square`.
    second: f64,
}

/// A sample's random numbers and its terms of the integrals.
#[derive(Clone, Copy, Debug)]
pub struct Term {
    numbers: [f32; AXES],
    integrals: Integrals,
}

/// A cell of a tree while it is learned.
#[derive(Clone, Debug)]
pub struct Cell {
    pub lower: [f64; AXES],
    pub extent: [f64; AXES],
    depth: u32,
    /// The range of its terms.
    terms: Range<usize>,
    pub integrals: Integrals,
    /// The index of the cell of the lower part; the cell of the upper part is the next one. `None` for a leaf.
    pub child: Option<usize>,
}

/// A place to split a cell.
#[derive(Clone, Copy, Debug)]
pub struct Split {
    pub axis: usize,
    /// The first bin of the upper part.
    bin: usize,
    /// The decrease of the sum of masses.
    pub gain: f64,
}

impl Integrals {
    pub fn of(sample: &Sample) -> Self {
        let square = sample.weight * sample.square;
        Self { square, cost: sample.weight * sample.cost, second: square * square }
    }

    pub fn plus(self, other: Self) -> Self {
        Self { square: self.square + other.square, cost: self.cost + other.cost, second: self.second + other.second }
    }

    /// Returns the best density in a leaf, up to a factor.
    pub fn best_density(self) -> f64 {
        if self.cost > 0.0 { (self.square / self.cost).sqrt() } else { 0.0 }
    }

    /// Returns the mass of a leaf. With the best density, the product of variance and time is the square of the sum of
    /// masses.
    pub fn mass(self) -> f64 {
        (self.square * self.cost).sqrt()
    }

    /// Returns the number of samples with equal squares that would be as noisy (Kish 1965); 0 if all are 0.
    fn effective(self) -> f64 {
        if self.second > 0.0 { self.square * self.square / self.second } else { 0.0 }
    }
}

impl Term {
    pub fn of(sample: &Sample) -> Self {
        Self { numbers: sample.numbers, integrals: Integrals::of(sample) }
    }
}

/// Adds terms in their order.
fn sum(terms: &[Term]) -> Integrals {
    terms.iter().fold(Integrals::default(), |sum, term| sum.plus(term.integrals))
}

/// Returns the bins with the largest square of each bin and its neighbours. There may be more light beside the samples
/// that have found light so far, as in an opening; a split at the last of these samples would cut it off.
fn dilated(bins: &[Integrals; BINS]) -> [Integrals; BINS] {
    std::array::from_fn(|bin| {
        let near = &bins[bin.saturating_sub(1)..(bin + 2).min(BINS)];
        let square = near.iter().map(|bin| bin.square).fold(0.0, f64::max);
        Integrals { square, ..bins[bin] }
    })
}

impl Cell {
    /// Returns the cell that contains all random numbers.
    pub fn root(terms: &[Term]) -> Self {
        Self {
            lower: [0.0; AXES],
            extent: [1.0; AXES],
            depth: 0,
            terms: 0..terms.len(),
            integrals: sum(terms),
            child: None,
        }
    }

    pub fn volume(&self) -> f64 {
        self.extent.iter().product()
    }

    /// Returns a function from a number to its bin along an axis.
    fn bins(&self, axis: usize) -> impl Fn(f32) -> usize + use<> {
        let (lower, scale) = (self.lower[axis] as f32, (BINS as f64 / self.extent[axis]) as f32);
        move |number| (((number - lower) * scale) as usize).min(BINS - 1)
    }

    /// Returns the best place to split the cell; `None` if the split lowers the mass by no more than noise would. Noise
    /// lowers it by a share of about `penalty` / effective number of samples.
    pub fn best_split(&self, terms: &[Term], penalty: f64) -> Option<Split> {
        let terms = &terms[self.terms.clone()];
        if terms.len() < FEWEST || self.depth >= MOST_DEPTH || self.integrals.square <= 0.0 {
            return None;
        }
        let mut best: Option<(Split, f64)> = None;
        for axis in (0..AXES).filter(|axis| self.extent[*axis] >= LEAST_EXTENT) {
            let bin = self.bins(axis);
            let mut bins = [Integrals::default(); BINS];
            for Term { numbers, integrals } in terms {
                let sum = &mut bins[bin(numbers[axis])];
                *sum = sum.plus(*integrals);
            }
            let bins = dilated(&bins);
            // Sums are made from both ends, because differences of sums would not be exact.
            let mut upper = [Integrals::default(); BINS + 1];
            for bin in (0..BINS).rev() {
                upper[bin] = bins[bin].plus(upper[bin + 1]);
            }
            let mass = upper[0].mass();
            let mut lower = Integrals::default();
            for bin in 1..BINS {
                lower = lower.plus(bins[bin - 1]);
                let gain = mass - lower.mass() - upper[bin].mass();
                if best.is_none_or(|(split, _)| gain > split.gain) {
                    best = Some((Split { axis, bin, gain }, mass));
                }
            }
        }
        let least = penalty / self.integrals.effective();
        best.filter(|(split, mass)| split.gain > least * mass).map(|(split, _)| split)
    }

    /// Divides the cell's terms between the two parts of a split, and returns the parts.
    pub fn divide(&self, Split { axis, bin, .. }: Split, terms: &mut [Term]) -> [Self; 2] {
        let bin_of = self.bins(axis);
        let terms = &mut terms[self.terms.clone()];
        // Both parts keep the order of the samples, on which sums depend.
        let (lower, upper): (Vec<Term>, Vec<Term>) = terms.iter().partition(|term| bin_of(term.numbers[axis]) < bin);
        terms[..lower.len()].copy_from_slice(&lower);
        terms[lower.len()..].copy_from_slice(&upper);
        let middle = self.terms.start + lower.len();
        let width = bin as f64 / BINS as f64 * self.extent[axis];
        let part = |offset: f64, width: f64, range: Range<usize>, terms: &[Term]| {
            let depth = self.depth + 1;
            let mut part = Self { depth, terms: range, integrals: sum(terms), child: None, ..self.clone() };
            part.lower[axis] += offset;
            part.extent[axis] = width;
            part
        };
        [
            part(0.0, width, self.terms.start..middle, &lower),
            part(width, self.extent[axis] - width, middle..self.terms.end, &upper),
        ]
    }
}
