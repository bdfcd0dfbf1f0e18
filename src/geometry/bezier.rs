//! Bezier curves in the half plane of (radius, height): the profiles of bodies of revolution. All numbers
//! are f64, in scene units.

use glam::DVec2;

/// The highest degree of a profile's segments.
pub const MAX_DEGREE: usize = 8;

/// One segment of a profile.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Control points (radius, height): degree + 1 of them, at least two.
    pub points: Vec<DVec2>,
}

/// A part of a curve.
#[derive(Clone, Debug, PartialEq)]
pub struct Stretch {
    /// Parameters of the whole curve at its ends, in [0, 1].
    pub range: [f64; 2],
    /// The part as a curve of its own.
    pub curve: Curve,
}

impl Curve {
    /// Returns the degree, at least 1.
    pub fn degree(&self) -> usize {
        self.points.len() - 1
    }

    /// Returns the point at a parameter in [0, 1].
    pub fn at(&self, t: f64) -> DVec2 {
        let mut row = self.points.clone();
        while row.len() > 1 {
            row = row.windows(2).map(|pair| pair[0].lerp(pair[1], t)).collect();
        }
        row[0]
    }

    /// Returns the parts of the curve before and after a parameter (de Casteljau).
    pub fn split(&self, t: f64) -> [Self; 2] {
        let mut row = self.points.clone();
        let (mut left, mut right) = (Vec::new(), Vec::new());
        while let (Some(first), Some(last)) = (row.first(), row.last()) {
            left.push(*first);
            right.push(*last);
            row = row.windows(2).map(|pair| pair[0].lerp(pair[1], t)).collect();
        }
        right.reverse();
        [left, right].map(|points| Self { points })
    }

    /// Returns the part of the curve between two parameters.
    pub fn part(&self, [from, to]: [f64; 2]) -> Self {
        let [left, _] = self.split(to);
        if from <= 0.0 { left } else { left.split(from / to)[1].clone() }
    }

    /// Returns the control points of the derivative by the parameter.
    pub fn hodograph(&self) -> Vec<DVec2> {
        let degree = self.degree() as f64;
        self.points.windows(2).map(|pair| (pair[1] - pair[0]) * degree).collect()
    }

    /// Returns the coefficients of the powers of the parameter, the lowest first, by forward differences.
    pub fn powers(&self) -> Vec<DVec2> {
        let degree = self.degree();
        let mut differences = self.points.clone();
        let mut powers = Vec::new();
        let mut binomial = 1.0;
        for i in 0..=degree {
            powers.push(differences[0] * binomial);
            binomial *= (degree - i) as f64 / (i + 1) as f64;
            differences = differences.windows(2).map(|pair| pair[1] - pair[0]).collect();
        }
        powers
    }

    /// Returns the coefficients of the powers of x = 2 t - 1, in [-1, 1], the lowest first.
    pub fn coefficients(&self) -> Vec<DVec2> {
        // Substitutes t = (x + 1) / 2 by Horner's rule.
        let degree = self.degree();
        let powers = self.powers();
        let mut result = vec![DVec2::ZERO; degree + 1];
        for power in powers.iter().rev() {
            for i in (0..=degree).rev() {
                let lower = if i > 0 { result[i - 1] } else { DVec2::ZERO };
                result[i] = 0.5 * (result[i] + lower);
            }
            result[0] += *power;
        }
        result
    }

    /// Splits the curve into parts on which radius and height are monotone and whose parameters span at
    /// most `1 / per_unit`. Parts without length are left out.
    pub fn monotone_stretches(&self, per_unit: f64) -> Vec<Stretch> {
        let mut cuts = vec![0.0];
        cuts.extend(self.turns());
        cuts.push(1.0);
        // This may remove the end: the last cut becomes 1.
        cuts.dedup_by(|later, earlier| *later - *earlier < 1e-9);
        if let Some(last) = cuts.last_mut() {
            *last = 1.0;
        }
        let mut stretches = Vec::new();
        for cut in cuts.windows(2) {
            let count = ((cut[1] - cut[0]) * per_unit - 1e-9).ceil().max(1.0);
            let at = |i: f64| if i < count { cut[0] + (cut[1] - cut[0]) * i / count } else { cut[1] };
            for i in 0..count as u32 {
                let range = [at(f64::from(i)), at(f64::from(i) + 1.0)];
                let curve = self.part(range);
                if curve.points.iter().any(|point| *point != curve.points[0]) {
                    stretches.push(Stretch { range, curve });
                }
            }
        }
        stretches
    }

    /// Returns the parameters in (0, 1) at which radius or height has an extremum, in order.
    fn turns(&self) -> Vec<f64> {
        let derivative = self.hodograph();
        let mut turns = Vec::new();
        for axis in 0..2 {
            let values: Vec<f64> = derivative.iter().map(|d| d[axis]).collect();
            sign_changes(&values, [0.0, 1.0], &mut turns);
        }
        turns.sort_by(f64::total_cmp);
        turns
    }
}

/// Appends the parameters at which a polynomial in Bernstein form changes sign, by Descartes' rule and
/// bisection.
fn sign_changes(values: &[f64], [from, to]: [f64; 2], found: &mut Vec<f64>) {
    let mut signs: Vec<bool> = values.iter().filter(|value| **value != 0.0).map(|value| *value > 0.0).collect();
    signs.dedup();
    if signs.len() <= 1 {
        return;
    }
    let middle = 0.5 * (from + to);
    if to - from < 1e-15 {
        found.push(middle);
        return;
    }
    let (mut left, mut right) = (Vec::new(), Vec::new());
    let mut row = values.to_vec();
    while let (Some(first), Some(last)) = (row.first(), row.last()) {
        left.push(*first);
        right.push(*last);
        row = row.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect();
    }
    right.reverse();
    if right[0] == 0.0 {
        found.push(middle); // neither half counts a root at its end
    }
    sign_changes(&left, [from, middle], found);
    sign_changes(&right, [middle, to], found);
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn curves() -> impl Strategy<Value = Curve> {
        prop::collection::vec((0.0..1.0, -1.0..1.0), 2..=MAX_DEGREE + 1)
            .prop_map(|points| Curve { points: points.into_iter().map(DVec2::from).collect() })
    }

    proptest! {
        #[test]
        fn parts_splits_and_powers_are_the_same_curve(curve in curves(), t in 0.0..1.0, s in 0.01..1.0) {
            let part = curve.part([t * s, s]);
            for i in 0..=4 {
                let x = f64::from(i) / 4.0;
                let there = curve.at(s * (t + (1.0 - t) * x));
                prop_assert!((part.at(x) - there).length() < 1e-12);
                let sum = part.coefficients().iter().rev().fold(DVec2::ZERO, |sum, c| sum * (2.0 * x - 1.0) + *c);
                prop_assert!((sum - there).length() < 1e-11);
            }
        }

        #[test]
        fn stretches_cover_the_curve_and_are_monotone(curve in curves()) {
            let stretches = curve.monotone_stretches(8.0);
            prop_assert_eq!(stretches[0].range[0], 0.0);
            prop_assert_eq!(stretches[stretches.len() - 1].range[1], 1.0);
            for pair in stretches.windows(2) {
                prop_assert_eq!(pair[0].range[1], pair[1].range[0]);
            }
            for stretch in &stretches {
                prop_assert!(stretch.range[1] - stretch.range[0] <= 0.125 + 1e-9);
                let steps: Vec<DVec2> = (0..=32).map(|i| stretch.curve.at(f64::from(i) / 32.0)).collect();
                let ends = steps[32] - steps[0];
                for pair in steps.windows(2) {
                    let step = (pair[1] - pair[0]) * ends.signum();
                    prop_assert!(step.min_element() > -1e-12, "{step} of {stretch:?}");
                }
            }
        }
    }

    #[test]
    fn stretches_without_length_are_left_out() {
        let point = DVec2::new(0.5, 1.0);
        assert!(Curve { points: vec![point; 4] }.monotone_stretches(8.0).is_empty());
    }
}
