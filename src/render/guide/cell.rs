//! Cells of the space of random numbers by which a photon is emitted, and the places where they are split.

use std::ops::Range;

/// The number of numbers by which a photon begins.
pub const AXES: usize = 6;
/// Parts of a cell along an axis; it is split between two of them.
pub const BINS: usize = 16;
/// The deepest cell: the kernel's loop is short.
const MOST_DEPTH: u32 = 64;
/// A cell with fewer photons is not split.
const FEWEST: usize = 32;
/// The least extent of a cell that is split: the numbers have steps of 6e-8.
const LEAST_EXTENT: f64 = 1e-6;

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
pub struct Integrals {
    pub square: f64,
    pub cost: f64,
    /// The sum of the squares of the terms of `square`.
    second: f64,
}

/// A sample's numbers and its terms of the integrals.
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
    /// The range of the terms that are in it.
    terms: Range<usize>,
    pub integrals: Integrals,
    /// The cell of the lower part; that of the upper part is next. `None` for a leaf.
    pub child: Option<usize>,
}

/// A place to split a cell.
#[derive(Clone, Copy, Debug)]
pub struct Split {
    pub axis: usize,
    /// The bin that the upper part begins with.
    bin: usize,
    /// By how much it lowers the sum of masses.
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

    /// Returns the root of what a leaf adds to the product of variance and time by the best density: its mass.
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

/// Returns the bins of an axis with squares that are as large as those of their neighbours: light that comes through an
/// opening is found beyond the samples that have come through it so far, and no split should cut it off.
fn dilated(bins: &[Integrals; BINS]) -> [Integrals; BINS] {
    std::array::from_fn(|bin| {
        let near = &bins[bin.saturating_sub(1)..(bin + 2).min(BINS)];
        let square = near.iter().map(|bin| bin.square).fold(0.0, f64::max);
        Integrals { square, ..bins[bin] }
    })
}

impl Cell {
    /// Returns the cell of all numbers.
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

    /// Returns the best place to split the cell, if it lowers the sum of masses by more than noise would: by a share of
    /// `penalty` over the effective number of samples.
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
            // Sums from both ends, since differences would not be exact.
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

    /// Divides the cell's terms between the two parts of a split, and returns these.
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
