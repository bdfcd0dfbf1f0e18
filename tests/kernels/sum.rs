//! Exact sums of radiance: to_term, to_signed_term and add_exactly.

use crate::fixture::{Fixture, Rng};
use crate::generated::{AddSums, AddTerms};

pub type Sum = [u32; 4];

/// The largest fp32 below 2^39.
const LARGEST: f32 = 549_755_781_120.0;

pub fn words(bits: u128) -> Sum {
    [0, 32, 64, 96].map(|shift| (bits >> shift) as u32)
}

pub fn number(sum: Sum) -> u128 {
    sum.iter().rev().fold(0, |bits, word| bits << 32 | u128::from(*word))
}

/// Nearest integer; exact, since a value has 24 bits and f64 holds 53.
pub fn to_term(value: f32) -> u128 {
    ((f64::from(value) * 56_f64.exp2()).round_ties_even() as i128).cast_unsigned()
}

/// Of either sign, from 0 to the largest, at every power of two and at every edge between the
/// words.
fn values() -> Vec<f32> {
    let mut rng = Rng(1);
    let mut values: Vec<f32> = (0..300_000).map(|_| rng.log_range(1e-20, 5.4975e11) as f32).collect();
    values.extend((0..100_000).map(|_| rng.range(0.0, 300.0) as f32));
    for exponent in -64..=39 {
        let power = f32::exp2(exponent as f32);
        values.extend([power.next_down(), power, power.next_up(), 1.5 * power, 2.5 * power]);
    }
    for step in 0..4096 {
        for edge in [256.0 * step as f32, (-24_f32).exp2() * step as f32, (-57_f32).exp2() * step as f32] {
            values.extend([edge.next_down().max(0.0), edge, edge.next_up()]);
        }
    }
    values.extend([0.0, f32::MIN_POSITIVE, LARGEST, LARGEST.next_down()]);
    values.retain(|value| *value <= LARGEST);
    values.iter_mut().step_by(3).for_each(|value| *value = -*value);
    values
}

#[test]
fn radiance_rounds_to_the_nearest_term_and_adds_exactly() {
    let values = values();
    let mut rng = Rng(2);
    // Also such as the term carries in.
    let full = [0, u128::MAX >> 1, u128::MAX >> 40, u64::MAX.into(), u32::MAX.into()];
    let sums: Vec<u128> = values
        .iter()
        .map(|_| if rng.chance(0.5) { full[rng.below(full.len())] } else { u128::from(rng.bits()) << rng.below(63) })
        .collect();
    let fixture = Fixture::new();
    let words: Vec<Sum> = sums.iter().copied().map(words).collect();
    let (input, before) = (fixture.upload(&values), fixture.upload(&words));
    let (terms, totals) = (fixture.output::<Sum>(values.len()), fixture.output::<Sum>(values.len()));
    fixture.run(&AddTerms { values: &input, sums: &before, terms: &terms, totals: &totals }, values.len());
    for (((value, sum), term), total) in values.iter().zip(sums).zip(fixture.read(&terms)).zip(fixture.read(&totals)) {
        assert_eq!(number(term), to_term(*value), "{value:e}");
        assert_eq!(number(total), sum.wrapping_add(to_term(*value)), "{sum:x} and {value:e}");
    }
}

#[test]
fn sums_of_any_bits_are_exact() {
    let mut rng = Rng(3);
    // Words that carry, and those that do so with a carry only.
    let extremes = [0, 1, 2, 0x7fff_ffff, 0x8000_0000, u32::MAX - 1, u32::MAX];
    let mut any = || -> Sum {
        let extreme = rng.chance(0.7);
        [0; 4].map(|_| if extreme { extremes[rng.below(extremes.len())] } else { rng.bits() as u32 })
    };
    let (left, right): (Vec<Sum>, Vec<Sum>) = (0..200_000).map(|_| (any(), any())).unzip();
    let fixture = Fixture::new();
    let (a, b, totals) = (fixture.upload(&left), fixture.upload(&right), fixture.output::<Sum>(left.len()));
    fixture.run(&AddSums { left: &a, right: &b, totals: &totals }, left.len());
    for ((left, right), total) in left.iter().zip(&right).zip(fixture.read(&totals)) {
        // No sum of radiance comes near 2^128, where this begins again.
        assert_eq!(total, words(number(*left).wrapping_add(number(*right))), "{left:x?} + {right:x?}");
    }
}
