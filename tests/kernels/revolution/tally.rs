//! What the kernels found of what there is, by the angle at which rays meet the surface.

use std::fmt;

use crate::fixture::EPS;
use crate::revolution::line::Line;
use crate::revolution::oracle::{Oracle, Root};

/// Upper ends of the bins of |N.D|, but the last.
const BINS: [f64; 4] = [1e-4, 1e-3, 1e-2, 1e-1];
/// Bins from here on are clean: rays cross the surface at more than 0.57 degrees.
const CLEAN: usize = 3;
/// Roots this near to each other are not told apart.
const TOGETHER: f64 = 4e-6;
/// The largest error of a distance that is none of them.
pub const MOST_OFF: f64 = 5e-6;
/// Failures of each sort that are kept to be shown.
const SHOWN: usize = 3;

fn bin(cosine: f64) -> usize {
    BINS.iter().position(|most| cosine.abs() <= *most).unwrap_or(BINS.len())
}

#[derive(Clone, Copy, Debug, Default)]
pub struct Bin {
    /// Roots of lines that fp32 must find, and those that it does not.
    pub roots: u64,
    pub missed: u64,
    /// Found where there is none; up to 0.01 they are false grazes.
    pub not_there: u64,
    /// Rays whose nearest hit is another, by the root that was missed or not there.
    pub wrong: u64,
    /// Distances that were compared, the sum and the largest of their errors, and of these
    /// the largest times the cosine: how far the surface was from where it is.
    pub compared: u64,
    pub error: f64,
    pub largest: f64,
    pub off: f64,
}

/// A root as the kernels give it.
#[derive(Clone, Copy, Debug)]
pub struct Found {
    pub t: f32,
    pub x: f32,
    pub piece: u32,
}

/// A root that was not among those found: nothing may be between these either.
#[derive(Clone, Debug)]
pub struct Missing {
    pub ray: usize,
    pub between: [f64; 2],
    pub bin: usize,
    pub shown: String,
}

#[derive(Clone, Debug, Default)]
pub struct Tally {
    pub rays: u64,
    pub bins: [Bin; BINS.len() + 1],
    /// Found at seams and ends, where fp32 may see another number of roots.
    pub at_seams: u64,
    failures: Vec<(&'static str, String)>,
}

impl Bin {
    fn merge(&mut self, other: &Self) {
        self.roots += other.roots;
        self.missed += other.missed;
        self.not_there += other.not_there;
        self.wrong += other.wrong;
        self.compared += other.compared;
        self.error += other.error;
        self.largest = self.largest.max(other.largest);
        self.off = self.off.max(other.off);
    }

    pub fn mean(&self) -> f64 {
        self.error / self.compared.max(1) as f64
    }
}

impl Tally {
    pub fn merge(&mut self, other: &Self) {
        self.rays += other.rays;
        self.at_seams += other.at_seams;
        for (bin, other) in self.bins.iter_mut().zip(&other.bins) {
            bin.merge(other);
        }
        for (what, shown) in &other.failures {
            self.keep(what, shown);
        }
    }

    /// All bins with |N.D| > 0.01.
    pub fn clean(&self) -> Bin {
        let mut sum = Bin::default();
        self.bins[CLEAN..].iter().for_each(|bin| sum.merge(bin));
        sum
    }

    fn keep(&mut self, what: &'static str, shown: impl fmt::Display) {
        if self.failures.iter().filter(|(other, _)| *other == what).count() < SHOWN {
            self.failures.push((what, shown.to_string()));
        }
    }

    fn fail(&mut self, what: &'static str, bin: usize, shown: impl fmt::Display) {
        if bin >= CLEAN {
            self.keep(what, shown);
        }
    }

    pub fn miss(&mut self, missing: &Missing) {
        self.bins[missing.bin].missed += 1;
        self.fail("missed", missing.bin, &missing.shown);
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{} rays, {} roots at seams that are not there", self.rays, self.at_seams)?;
        for (name, bin) in ["<=1e-4", "<=1e-3", "<=1e-2", "<=1e-1", ">1e-1"].iter().zip(&self.bins) {
            let Bin { roots, missed, not_there, wrong, largest, off, .. } = bin;
            let mean = bin.mean();
            write!(f, "    {name:<7} {roots:>10} {missed:>7} {not_there:>9} {wrong:>7}")?;
            writeln!(f, " {mean:>9.1e} {largest:>9.1e} {off:>9.1e}")?;
        }
        self.failures.iter().try_for_each(|(what, shown)| writeln!(f, "  {what}: {shown}"))
    }
}

/// What the columns of a tally are.
pub const HEADING: &str = "    |N.D|        roots  missed not there   wrong      mean   largest   surface";

/// A ray and what is known of it.
pub struct View<'a> {
    pub body: &'a str,
    pub oracle: &'a Oracle,
    pub line: &'a Line,
    /// Length of the direction in render space, where bodies have about unit size.
    pub size: f64,
    /// Farther off, it is another root.
    pub same: f64,
    /// By k.
    pub roots: &'a [Root],
    /// In any order.
    pub found: &'a [Found],
    pub nearest: Option<Found>,
}

impl fmt::Display for View<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let bits = |v: glam::DVec3| v.to_array().map(|x| format!("{:#010x}", (x as f32).to_bits())).join(", ");
        let (o, d) = (self.line.origin, self.line.direction);
        writeln!(f, "{} from {o} [{}] along {d} [{}] in unit space", self.body, bits(o), bits(d))?;
        for Root { k, cosine, required, at_seam } in self.roots {
            writeln!(f, "    is {k:.9} cosine {cosine:+.2e} required {required} at seam {at_seam}")?;
        }
        for found in self.found {
            writeln!(f, "    found {found:?}")?;
        }
        write!(f, "    nearest {:?}", self.nearest)
    }
}

impl View<'_> {
    /// Between a root that was found and one there is. The rounding of t itself, half a unit
    /// in its last place, is not charged: far from a body it is all there is.
    fn distance(&self, found: &Found, root: &Root) -> f64 {
        let t = f64::from(found.t);
        ((t - root.k).abs() - EPS * t.abs()).max(0.0) * self.size
    }

    /// How near another root may be that cannot be told from one at k.
    fn together(&self, k: f64) -> f64 {
        TOGETHER / self.size + 4.0 * EPS * k.abs()
    }

    /// The cosine at a point that is no root, unless it is at a seam and on the surface.
    fn judge(&self, found: &Found) -> Option<f64> {
        let (cosine, off, at_seam) = self.oracle.judge(self.line, found.t.into(), found.piece, found.x.into());
        (!at_seam || off > TOGETHER).then_some(cosine)
    }

    /// Compares all roots of the line. Each that was found belongs to the nearest that there
    /// is; of those that are not told apart there must be as many.
    pub fn count_roots(&self, ray: usize, tally: &mut Tally, missing: &mut Vec<Missing>) {
        let mut found = vec![(0, f64::INFINITY); self.roots.len()];
        for one in self.found {
            let errors = self.roots.iter().map(|root| self.distance(one, root)).enumerate();
            match errors.min_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, error)| *error <= self.same) {
                Some((i, error)) => found[i] = (found[i].0 + 1, error.min(found[i].1)),
                None => self.count_not_there(one, tally),
            }
        }
        let apart = |i: &usize| self.roots[*i].k - self.roots[i - 1].k >= self.together(self.roots[*i].k);
        let mut first = 0;
        while first < self.roots.len() {
            let end = (first + 1..self.roots.len()).find(apart).unwrap_or(self.roots.len());
            let mut spare: u32 = found[first..end].iter().map(|(count, _)| count).sum();
            for (i, root) in self.roots.iter().enumerate().take(end).skip(first) {
                let place = &mut tally.bins[bin(root.cosine)];
                place.roots += u64::from(root.required);
                let (count, error) = found[i];
                if count > 0 && end == first + 1 && !root.at_seam {
                    place.compared += 1;
                    place.error += error;
                    place.largest = place.largest.max(error);
                    place.off = place.off.max(error * root.cosine.abs());
                    if error > MOST_OFF {
                        tally.fail("off", bin(root.cosine), self);
                    }
                }
                if root.required && spare == 0 {
                    missing.push(self.missing(ray, i));
                }
                spare = spare.saturating_sub(u32::from(root.required));
            }
            first = end;
        }
    }

    /// Where only the root with this index is.
    fn missing(&self, ray: usize, i: usize) -> Missing {
        let Root { k, cosine, at_seam, .. } = self.roots[i];
        let (most, least) = (self.same / self.size, self.together(k));
        let reach = |other: Option<&Root>| {
            let half = other.map_or(most, |other| 0.5 * (other.k - k).abs());
            if at_seam { most } else { half.clamp(least, most.max(least)) }
        };
        let before = i.checked_sub(1).map(|i| &self.roots[i]);
        let between = [k - reach(before), k + reach(self.roots.get(i + 1))];
        let bin = bin(cosine);
        Missing { ray, between, bin, shown: if bin >= CLEAN { self.to_string() } else { String::new() } }
    }

    fn count_not_there(&self, found: &Found, tally: &mut Tally) {
        match self.judge(found) {
            Some(cosine) => {
                tally.bins[bin(cosine)].not_there += 1;
                tally.fail("not there", bin(cosine), self);
            }
            None => tally.at_seams += 1,
        }
    }

    /// Compares the nearest hit of the ray. Missing a root that grazes, or finding one that
    /// is not there but would, is binned as such.
    pub fn count_nearest(&self, tally: &mut Tally) {
        tally.rays += 1;
        let ahead = || self.roots.iter().filter(|root| root.k > 0.0);
        let met = self.nearest.and_then(|found| {
            let errors = ahead().map(|root| (root.k, self.distance(&found, root)));
            errors.min_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, error)| *error <= self.same)
        });
        let limit = match (met, &self.nearest) {
            (Some((k, _)), _) => k - self.together(k),
            (None, Some(found)) => found.t.into(),
            (None, None) => f64::INFINITY,
        };
        let passed = ahead().filter(|root| root.required && root.k < limit).map(|root| bin(root.cosine));
        let not_there = self.nearest.filter(|_| met.is_none()).and_then(|found| self.judge(&found)).map(bin);
        if let Some(place) = passed.chain(not_there).max() {
            tally.bins[place].wrong += 1;
            tally.fail("wrong nearest", place, self);
        }
    }
}
