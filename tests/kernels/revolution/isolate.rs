//! Real roots of polynomials in Bernstein form, isolated by Descartes' rule and halving
//! (Lane and Riesenfeld 1981). Signs count only where rounding cannot have made them.

use crate::revolution::wide::{Number, Wide};

/// The most coefficients: those of a squared profile.
pub const MOST: usize = 2 * 8 + 1;
pub type Row<T> = [T; MOST];

/// No interval is halved more often: roots as close as this touch.
const MOST_HALVINGS: i32 = 48;
/// Halvings before f64 gives up on a sign.
const FEW_HALVINGS: i32 = 10;

/// Part of [0, 1] with one root, or where the polynomial comes so close to zero that none
/// can be told from two.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bracket {
    pub from: f64,
    pub to: f64,
    pub kind: Kind,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    Rising,
    Falling,
    Touching,
}

fn binomial(n: usize, k: usize) -> f64 {
    (0..k).fold(1.0, |product, i| product * (n - i) as f64 / (i + 1) as f64)
}

/// Bernstein coefficients over [from, to] of the polynomial with these powers.
pub fn bernstein(powers: &[f64], [from, to]: [f64; 2]) -> Vec<Wide> {
    let degree = powers.len() - 1;
    // The powers of s, where x = from + (to - from) s, by Horner's rule.
    let (start, length) = (Wide::of(from), Wide::sum(to, -from));
    let mut shifted = vec![Wide::of(0.0); degree + 1];
    for power in powers.iter().rev() {
        for i in (0..=degree).rev() {
            let lower = if i > 0 { shifted[i - 1] * length } else { Wide::of(*power) };
            shifted[i] = shifted[i] * start + lower;
        }
    }
    (0..=degree)
        .map(|i| {
            let term = |j: usize| (shifted[j] * Wide::of(binomial(i, j))).over(binomial(degree, j));
            (0..=i).fold(Wide::of(0.0), |sum, j| sum + term(j))
        })
        .collect()
}

/// Bernstein coefficients of a product.
pub fn product(a: &[Wide], b: &[Wide]) -> Vec<Wide> {
    let (n, m) = (a.len() - 1, b.len() - 1);
    let mut sum = vec![Wide::of(0.0); n + m + 1];
    for (i, a) in a.iter().enumerate() {
        for (j, b) in b.iter().enumerate() {
            let weight = Wide::product(binomial(n, i), binomial(m, j)).over(binomial(n + m, i + j));
            sum[i + j] = sum[i + j] + *a * *b * weight;
        }
    }
    sum
}

/// Sign variations of coefficients known to within `error`, if that is enough to tell.
fn variations<T: Number>(row: &[T], error: f64) -> Option<usize> {
    let sign = |c: T| i32::from(c.value() > error) - i32::from(c.value() < -error);
    let mut last = sign(row[0]);
    if last == 0 || sign(row[row.len() - 1]) == 0 {
        return None;
    }
    let (mut count, mut unknown) = (0, 0);
    for c in &row[1..] {
        match sign(*c) {
            0 => unknown += 1,
            // One unknown sign between opposite ones changes nothing.
            sign if (sign == last && unknown == 0) || (sign != last && unknown <= 1) => {
                count += usize::from(sign != last);
                (last, unknown) = (sign, 0);
            }
            _ => return None,
        }
    }
    Some(count)
}

/// The polynomial before and after `at` (de Casteljau).
fn split<T: Number>(row: &[T], at: f64) -> [Row<T>; 2] {
    let mut left = [T::of(0.0); MOST];
    let mut right = left;
    right[..row.len()].copy_from_slice(row);
    for (i, first) in left.iter_mut().enumerate().take(row.len()) {
        *first = right[0];
        for j in 0..row.len() - 1 - i {
            right[j] = if at == 0.5 {
                (right[j] + right[j + 1]) * T::of(0.5)
            } else {
                right[j] + (right[j + 1] - right[j]) * T::of(at)
            };
        }
    }
    [left, right]
}

/// A Bernstein polynomial whose coefficients are at most `size`, and off by at most 32
/// roundings of that.
pub struct Isolation<'a> {
    pub size: f64,
    pub found: &'a mut Vec<Bracket>,
}

impl Isolation<'_> {
    /// Finds all roots in (0, 1), in order. Whether all signs were certain: for [`Wide`],
    /// which calls the rest touching, they are.
    pub fn run<T: Number>(&mut self, row: &[T]) -> bool {
        self.halve(row, [0.0, 1.0], 0)
    }

    fn halve<T: Number>(&mut self, row: &[T], [from, to]: [f64; 2], depth: i32) -> bool {
        // Each of up to 16 stages of a halving adds up to 3 roundings.
        let error = T::ROUNDING * self.size * f64::from(32 + 48 * depth);
        let last = row[row.len() - 1].value();
        let count = variations(row, error);
        let is_wide = T::ROUNDING < f64::EPSILON;
        match count {
            Some(0) => return true,
            Some(1) => {
                let kind = if last > 0.0 { Kind::Rising } else { Kind::Falling };
                self.found.push(Bracket { from, to, kind });
                return true;
            }
            None if !is_wide && (depth >= FEW_HALVINGS || last.abs() <= error || row[0].value().abs() <= error) => {
                return false;
            }
            _ => {}
        }
        let kind = match [row[0].value(), last] {
            [before, after] if before < -error && after > error => Kind::Rising,
            [before, after] if before > error && after < -error => Kind::Falling,
            _ => Kind::Touching,
        };
        if depth >= MOST_HALVINGS || row.iter().all(|c| c.value().abs() <= error) {
            self.found.push(Bracket { from, to, kind });
            return is_wide;
        }
        let (mut at, mut halves) = (0.5, split(row, 0.5));
        for elsewhere in [0.4375, 0.59375] {
            // Not at a root.
            if is_wide && halves[1][0].value().abs() <= error {
                (at, halves) = (elsewhere, split(row, elsewhere));
            }
        }
        let middle = from + (to - from) * at;
        let [left, right] = halves;
        self.halve(&left[..row.len()], [from, middle], depth + 1)
            && self.halve(&right[..row.len()], [middle, to], depth + 1)
    }
}

/// The root in a bracket, by Newton's method within it.
pub fn refine([mut low, mut high]: [f64; 2], kind: Kind, f: impl Fn(f64) -> [f64; 2]) -> f64 {
    let mut x = 0.5 * (low + high);
    if kind == Kind::Touching {
        return x;
    }
    let mut before = high - low;
    for _ in 0..100 {
        let [value, slope] = f(x);
        let step = -value / slope;
        // Steps that shrink no more are rounding.
        if step.abs() < 1e-15 || (before < 1e-9 && step.abs() >= 0.5 * before) {
            break;
        }
        if (value > 0.0) == (kind == Kind::Rising) {
            high = x;
        } else {
            low = x;
        }
        let next =
            if (low..high).contains(&(x + step)) && step.abs() < 0.5 * before { x + step } else { 0.5 * (low + high) };
        before = (next - x).abs();
        x = next;
    }
    x
}
