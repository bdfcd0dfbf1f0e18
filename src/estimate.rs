//! The image as it stands: exact sums over iterations, their mean, and how far it may be off.

use crate::film::{Image, LUMINANCE};

/// Sums are in units of 2^-56 of [`Estimate::unit`]: `shaders/include/sum.glsl`.
const FRACTION_BITS: i32 = 56;
/// The weight of a pixel's relative error falls where it is darker than this part of the
/// image's typical luminance.
const DARK: f64 = 0.1;

/// 128 bits, the lowest word first.
pub type Sum = [u32; 4];

/// Sums of the radiance of each pixel over iterations. Sums of shares of the iterations add
/// up to the sums of all, to the last bit, in any order.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// Width and height in pixels.
    pub resolution: [u32; 2],
    /// Unit of the sums, W/(m² sr), a power of two.
    pub unit: f64,
    /// Iterations in the sums.
    pub iterations: u64,
    /// Whole rounds in them.
    pub rounds: u64,
    /// Radiance of each pixel, by channel.
    pub radiance: [Vec<Sum>; 3],
    /// Square of the luminance of each round's mean.
    pub square: Vec<Sum>,
}

/// A sum in units, to the nearest f64.
fn in_units(sum: Sum) -> f64 {
    let bits = sum.iter().rev().fold(0u128, |bits, word| bits << 32 | u128::from(*word));
    bits as f64 * f64::from(-FRACTION_BITS).exp2()
}

fn add(sum: &mut Sum, other: Sum) {
    let mut carry = 0;
    for (word, more) in sum.iter_mut().zip(other) {
        let total = u64::from(*word) + u64::from(more) + carry;
        *word = total as u32;
        carry = total >> 32;
    }
}

impl Estimate {
    /// The mean of the iterations; black without any.
    pub fn image(&self) -> Image {
        let [width, height] = self.resolution;
        let pixels = self.means().map(|mean| mean.map(|channel| (channel * self.unit) as f32)).collect();
        Image { width, height, pixels }
    }

    /// The mean of each pixel, in units.
    fn means(&self) -> impl Iterator<Item = [f64; 3]> {
        let scale = 1.0 / self.iterations.max(1) as f64;
        let [red, green, blue] = &self.radiance;
        red.iter().zip(green).zip(blue).map(move |((r, g), b)| [*r, *g, *b].map(|sum| in_units(sum) * scale))
    }

    /// The standard error of each pixel's luminance, W/(m² sr), from the spread of rounds
    /// about their mean; `None` with fewer than two. It knows of noise, and not of the blur
    /// that the radius makes.
    pub fn standard_error(&self) -> Option<Vec<f32>> {
        let errors = self.errors()?;
        Some(errors.map(|[_, error]| (error * self.unit) as f32).collect())
    }

    /// Luminance and standard error of each pixel, in units.
    fn errors(&self) -> Option<impl Iterator<Item = [f64; 2]>> {
        let rounds = self.rounds as f64;
        let error = move |(mean, square): ([f64; 3], &Sum)| {
            let luminance = LUMINANCE[0] * mean[0] + LUMINANCE[1] * mean[1] + LUMINANCE[2] * mean[2];
            let variance = in_units(*square) / rounds - luminance * luminance;
            [luminance, (variance.max(0.0) / (rounds - 1.0)).sqrt()]
        };
        (self.rounds > 1).then(|| self.means().zip(&self.square).map(error))
    }

    /// The root mean square over pixels of the standard error over the luminance. Pixels
    /// darker than a tenth of the image's median count as that bright, so that black ones do
    /// not decide.
    pub fn relative_error(&self) -> Option<f64> {
        let errors: Vec<[f64; 2]> = self.errors()?.collect();
        let mut lit: Vec<f64> = errors.iter().map(|[luminance, _]| *luminance).filter(|it| *it > 0.0).collect();
        if lit.is_empty() {
            return Some(0.0);
        }
        let middle = lit.len() / 2;
        let (_, median, _) = lit.select_nth_unstable_by(middle, f64::total_cmp);
        let floor = (DARK * *median).powi(2);
        let squares = errors.iter().map(|[luminance, error]| error * error / (luminance * luminance + floor));
        Some((squares.sum::<f64>() / errors.len() as f64).sqrt())
    }

    /// The sums of red, green, blue and squared luminance.
    pub fn sums(&self) -> [&[Sum]; 4] {
        let [red, green, blue] = &self.radiance;
        [red, green, blue, &self.square]
    }

    /// Adds another share of the iterations. Both must be of the same render.
    pub fn add(&mut self, other: &Self) {
        assert_eq!((self.resolution, self.unit), (other.resolution, other.unit));
        let shares = self.radiance.iter_mut().zip(&other.radiance).chain([(&mut self.square, &other.square)]);
        for (sums, more) in shares {
            sums.iter_mut().zip(more).for_each(|(sum, more)| add(sum, *more));
        }
        self.iterations += other.iterations;
        self.rounds += other.rounds;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sum of so many units of 2^-56.
    fn sum(bits: u128) -> Sum {
        [0, 32, 64, 96].map(|shift| (bits >> shift) as u32)
    }

    const ONE: u128 = 1 << FRACTION_BITS;

    /// Pixels of one colour each, as sums over iterations; squares are given as they are.
    fn estimate(
        iterations: u64,
        rounds: u64,
        red: &[u128],
        green: &[u128],
        blue: &[u128],
        square: &[u128],
    ) -> Estimate {
        let sums = |values: &[u128]| values.iter().map(|value| sum(*value)).collect::<Vec<_>>();
        let radiance = [sums(red), sums(green), sums(blue)];
        Estimate { resolution: [red.len() as u32, 1], unit: 4.0, iterations, rounds, radiance, square: sums(square) }
    }

    /// All channels alike, so that they are the luminance.
    fn grey(rounds: u64, values: &[u128], squares: &[u128]) -> Estimate {
        estimate(rounds, rounds, values, values, values, squares)
    }

    #[test]
    fn the_image_is_the_mean_in_the_unit() {
        let estimate = estimate(8, 8, &[ONE, 3 * ONE / 2], &[ONE << 40, 0], &[1, 8], &[0, 0]);
        let tiny = f32::exp2(-56.0) * 0.5;
        assert_eq!(estimate.image().pixels, [[0.5, f32::exp2(39.0), tiny], [0.75, 0.0, 8.0 * tiny]]);
        let nothing = Estimate { iterations: 0, rounds: 0, ..estimate };
        assert!(nothing.image().pixels.iter().flatten().all(|value| value.is_finite()));
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

    #[test]
    fn shares_add_up_in_any_order() {
        let mut bits = 1u128;
        let mut share = |iterations| {
            let mut value = || {
                bits = bits.wrapping_mul(0x2360_ed05_1fc6_5da4_4385_df64_9fcc_f645).wrapping_add(1);
                bits >> 4
            };
            let [r, g, b, s] = std::array::from_fn(|_| [value(), value(), value()]);
            estimate(iterations, iterations / 2, &r, &g, &b, &s)
        };
        let shares = [share(3), share(2), share(8), share(0)];
        let total = |order: [usize; 4]| {
            let mut total = shares[order[0]].clone();
            order[1..].iter().for_each(|index| total.add(&shares[*index]));
            total
        };
        let expected = total([0, 1, 2, 3]);
        assert_eq!((expected.iterations, expected.rounds), (13, 6));
        for order in [[3, 2, 1, 0], [1, 0, 3, 2], [2, 3, 0, 1]] {
            assert_eq!(total(order), expected, "{order:?}");
        }
        let mut right = shares[1].clone();
        right.add(&shares[2]);
        right.add(&shares[3]);
        let mut grouped = shares[0].clone();
        grouped.add(&right);
        assert_eq!(grouped, expected);
    }

    /// Rounds of 1, 2, 3 and 6 units: a mean of 3, squares of 50 in all. The variance of the
    /// mean is (50 / 4 - 9) / 3 = 7 / 6.
    #[test]
    fn the_standard_error_is_that_of_the_mean_of_rounds() {
        let error = |rounds, values: &[u128], squares: &[u128]| grey(rounds, values, squares).standard_error();
        let expected = (4.0 * (7.0_f64 / 6.0).sqrt()) as f32;
        let close = |value: f32, expected: f32| (value - expected).abs() <= 1e-6 * expected;
        let errors = error(4, &[12 * ONE, 8 * ONE], &[50 * ONE, 16 * ONE]).unwrap();
        assert!(close(errors[0], expected), "{errors:?}");
        assert!(errors[1] < 1e-6, "equal rounds: {errors:?}");
        // Of one round nothing is known; what rounding has made negative is none.
        assert_eq!(error(1, &[ONE], &[ONE]), None);
        assert_eq!(error(0, &[0], &[0]), None);
        assert_eq!(error(2, &[2 * ONE], &[2 * ONE - 1]).unwrap(), [0.0]);
    }

    /// Two rounds of 0 and 2 have an error of 1 at a luminance of 1; black pixels have none.
    #[test]
    fn the_relative_error_weighs_dark_pixels_less() {
        let relative = |values: &[u128], squares: &[u128]| grey(2, values, squares).relative_error().unwrap();
        let expect = |value: f64, expected: f64| assert!((value - expected).abs() < 1e-9, "{value}, not {expected}");
        expect(relative(&[2 * ONE], &[4 * ONE]), (1.0 / 1.01_f64).sqrt());
        expect(relative(&[2 * ONE, 0], &[4 * ONE, 0]), (0.5 / 1.01_f64).sqrt());
        // A hundredth as bright, and as noisy in itself.
        let squares = [4 * ONE, 4 * ONE, 4 * ONE / 10_000];
        let dark = 1e-4 / (1e-4 + 0.01);
        let values = [2 * ONE, 2 * ONE, 2 * ONE / 100];
        expect(relative(&values, &squares), ((2.0 / 1.01 + dark) / 3.0_f64).sqrt());
        assert_eq!(relative(&[0, 0], &[0, 0]), 0.0);
        assert_eq!(grey(1, &[ONE], &[ONE]).relative_error(), None);
    }
}
