//! Exact sums in the format of `shaders/include/math/sum.glsl`.

use crate::kernels::FRACTION_BITS;

/// A signed number of 128 bits in two's complement, the lowest word first, in units of 2^-56 of what the sum is of.
pub type Sum = [u32; 4];

/// Returns a sum in its smallest units.
pub(super) fn whole(sum: Sum) -> i128 {
    sum.iter().rev().fold(0u128, |bits, word| bits << 32 | u128::from(*word)).cast_signed()
}

/// Returns a sum from its smallest units as the nearest f64.
pub(super) fn from_whole(bits: i128) -> f64 {
    bits as f64 * (-f64::from(FRACTION_BITS)).exp2()
}

/// Adds a sum to another one.
pub(super) fn add(sum: &mut Sum, other: Sum) {
    let mut carry = 0;
    for (word, more) in sum.iter_mut().zip(other) {
        let total = u64::from(*word) + u64::from(more) + carry;
        *word = total as u32;
        carry = total >> 32;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the sum that is `bits` times 2^-56.
    fn sum(bits: u128) -> Sum {
        [0, 32, 64, 96].map(|shift| (bits >> shift) as u32)
    }

    #[test]
    fn sums_carry_through_all_words() {
        let max = u128::from(u64::MAX);
        for (a, b) in [(1, 1), (u32::MAX.into(), 1), (max, 1), (max, max), (max << 32 | 0xffff_ffff, 1), (1 << 96, 7)] {
            for (a, b) in [(a, b), (b, a)] {
                let mut total = sum(a);
                add(&mut total, sum(b));
                assert_eq!(total, sum(a + b), "{a:x} + {b:x}");
            }
        }
    }
}
