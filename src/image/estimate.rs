//! An image in progress: exact sums over iterations, their mean, and an estimate of its error.

use glam::{DMat3, DVec3};

use crate::image::film::{Image, Window, balanced_luminance};
use crate::image::layers::{LayerForm, Layers};
pub use crate::image::sum::Sum;
use crate::image::sum::{add, from_whole, whole};

/// Relative errors of pixels that are darker than this share of the image's median luminance weigh less.
const DARK: f64 = 0.1;

/// Sums over iterations of each pixel's radiance, times the film's exposure and before its white balance. Sums
/// over parts of the iterations add up to the sums over all, to the last bit, in any order.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// Width and height in pixels.
    pub resolution: [u32; 2],
    /// The position of the pixels in the full image of the camera.
    pub window: Window,
    /// Unit of the sums in W/(m² sr): a power of two times the film's exposure.
    pub unit: f64,
    /// The white balance of the image: a matrix on linear RGB in the sRGB primaries; `None` if the film has none.
    pub white_balance: Option<DMat3>,
    /// Iterations in the sums, for each half: [`crate::render::sequence::Place::half`].
    pub halves: [u64; 2],
    /// Sums of radiance of each pixel, for red, green and blue.
    pub radiance: [Vec<Sum>; 3],
    /// Sums of luminance after the white balance of each pixel over the iterations of the second half.
    pub second_half: Vec<Sum>,
    /// Sums of the layers that were asked for.
    pub layers: Layers,
}

/// Returns a sum in multiples of its unit, as the nearest f64.
fn in_units(sum: Sum) -> f64 {
    from_whole(whole(sum))
}

/// Returns the term that is added to squared luminances before errors are divided by them: the square of
/// a tenth of the median of the luminances above 0. `None` if all are 0.
pub fn dark_square(luminances: impl Iterator<Item = f64>) -> Option<f64> {
    median_lit(luminances).map(|median| (DARK * median).powi(2))
}

/// Returns the median of the luminances above 0; `None` if all are 0.
fn median_lit(luminances: impl Iterator<Item = f64>) -> Option<f64> {
    let mut lit: Vec<f64> = luminances.filter(|luminance| *luminance > 0.0).collect();
    if lit.is_empty() {
        return None;
    }
    let middle = lit.len() / 2;
    let (_, median, _) = lit.select_nth_unstable_by(middle, f64::total_cmp);
    Some(*median)
}

impl Estimate {
    /// Returns the mean over the iterations, after the white balance; black if there is no iteration.
    pub fn image(&self) -> Image {
        let [width, height] = self.resolution;
        let pixels = self.means().map(|mean| self.balanced(mean).map(|channel| channel as f32)).collect();
        Image { width, height, pixels }
    }

    /// Returns radiance in multiples of the unit as the image has it: after the white balance, in W/(m² sr).
    pub(super) fn balanced(&self, radiance: [f64; 3]) -> [f64; 3] {
        let balanced = self.white_balance.map_or(radiance, |matrix| (matrix * DVec3::from(radiance)).to_array());
        balanced.map(|channel| channel * self.unit)
    }

    /// Returns the number of iterations in the sums.
    pub fn iterations(&self) -> u64 {
        self.halves[0] + self.halves[1]
    }

    /// Returns the mean of each pixel before the white balance, in multiples of the unit.
    pub(super) fn means(&self) -> impl Iterator<Item = [f64; 3]> {
        let scale = 1.0 / self.iterations().max(1) as f64;
        let [red, green, blue] = &self.radiance;
        red.iter().zip(green).zip(blue).map(move |((r, g), b)| [*r, *g, *b].map(|sum| in_units(sum) * scale))
    }

    /// Returns the sum over the iterations of each pixel's luminance, in multiples of the unit.
    pub fn luminance_sums(&self) -> impl Iterator<Item = f64> {
        let (luminance, iterations) = (self.luminance(), self.iterations() as f64);
        self.means().map(move |mean| luminance(mean) * iterations)
    }

    /// Returns the function from a pixel before the white balance to the luminance after it.
    fn luminance(&self) -> impl Fn([f64; 3]) -> f64 + use<> {
        let weights = balanced_luminance(self.white_balance);
        move |[red, green, blue]| weights[0] * red + weights[1] * green + weights[2] * blue
    }

    /// Returns the standard error of each pixel's luminance in W/(m² sr); `None` before both halves have an
    /// iteration. It contains noise, but not the blur from the radius. It comes from two halves, so that
    /// the value of a single pixel is uncertain; its square is right in the mean over many pixels.
    pub fn standard_error(&self) -> Option<Vec<f32>> {
        Some(self.errors()?.map(|[_, variance]| (variance.sqrt() * self.unit) as f32).collect())
    }

    /// Returns [`Estimate::standard_error`], or infinity for each pixel where that is `None`: the error of an
    /// image that is unknown has no bound.
    pub fn standard_error_or_infinite(&self) -> Vec<f32> {
        self.standard_error().unwrap_or_else(|| vec![f32::INFINITY; self.second_half.len()])
    }

    /// Returns the luminance of each pixel in each half of the iterations, in multiples of the unit: two
    /// numbers with the same mean and independent noise. `None` before both halves have an iteration.
    pub fn half_luminances(&self) -> Option<impl Iterator<Item = [f64; 2]>> {
        let [first, second] = self.halves.map(|iterations| iterations as f64);
        let luminance = self.luminance();
        let halves = move |(mean, sum): ([f64; 3], &Sum)| {
            let sum = in_units(*sum);
            [(luminance(mean) * (first + second) - sum) / first, sum / second]
        };
        (first > 0.0 && second > 0.0).then(|| self.means().zip(&self.second_half).map(halves))
    }

    /// Returns the luminance of each pixel in multiples of the unit, and an estimate of its variance.
    fn errors(&self) -> Option<impl Iterator<Item = [f64; 2]>> {
        let [first, second] = self.halves.map(|iterations| iterations as f64);
        let [part, rest] = [first, second].map(|half| half / (first + second));
        // For independent means a and b over n and m iterations of variance s^2, the mean of (a - b)^2 is
        // s^2 (1 / n + 1 / m). The variance of the mean over all is s^2 / (n + m).
        let error = move |[a, b]: [f64; 2]| [part * a + rest * b, (a - b).powi(2) * part * rest];
        Some(self.half_luminances()?.map(error))
    }

    /// Returns the root mean square over pixels of the standard error divided by the luminance. The
    /// squared luminance is increased by [`dark_square`], so that black pixels do not dominate. `None` before
    /// both halves have an iteration.
    pub fn relative_error(&self) -> Option<f64> {
        let errors: Vec<[f64; 2]> = self.errors()?.collect();
        let Some(floor) = dark_square(errors.iter().map(|[luminance, _]| *luminance)) else { return Some(0.0) };
        let squares = errors.iter().map(|[luminance, variance]| variance / (luminance * luminance + floor));
        Some((squares.sum::<f64>() / errors.len() as f64).sqrt())
    }

    /// Returns the median luminance of the pixels that are not black, in multiples of the unit; `None` if
    /// all are black.
    pub fn median_lit(&self) -> Option<f64> {
        median_lit(self.means().map(self.luminance()))
    }

    /// Returns whether these are the resolution, the unit, the white balance and the form of the layers: only sums
    /// of the same form can be added.
    pub fn has_form(&self, resolution: [u32; 2], unit: f64, white_balance: Option<DMat3>, layers: &LayerForm) -> bool {
        (self.resolution, self.unit, self.white_balance, &self.layers.form) == (resolution, unit, white_balance, layers)
    }

    /// Returns the sums of red, green and blue, and of the second half's luminance.
    pub fn sums(&self) -> [&[Sum]; 4] {
        let [red, green, blue] = &self.radiance;
        [red, green, blue, &self.second_half]
    }

    /// Adds the sums over other iterations of the same render. Panics if resolution, unit, white balance or the
    /// form of the layers differ.
    pub fn add(&mut self, other: &Self) {
        let is_alike = self.has_form(other.resolution, other.unit, other.white_balance, &other.layers.form);
        assert!(is_alike, "sums of another form");
        let shares = self.radiance.iter_mut().zip(&other.radiance).chain([(&mut self.second_half, &other.second_half)]);
        for (sums, more) in shares {
            sums.iter_mut().zip(more).for_each(|(sum, more)| add(sum, *more));
        }
        self.layers.add(&other.layers);
        for (iterations, more) in self.halves.iter_mut().zip(other.halves) {
            *iterations += more;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::FRACTION_BITS;

    /// Returns the sum that is `bits` times 2^-56.
    fn sum(bits: u128) -> Sum {
        [0, 32, 64, 96].map(|shift| (bits >> shift) as u32)
    }

    const ONE: u128 = 1 << FRACTION_BITS;

    /// A row of pixels, as sums over iterations.
    fn estimate(halves: [u64; 2], radiance: [&[u128]; 3], second_half: &[u128]) -> Estimate {
        let sums = |values: &[u128]| values.iter().map(|value| sum(*value)).collect::<Vec<_>>();
        let resolution = [second_half.len() as u32, 1];
        Estimate {
            resolution,
            window: Window::whole(resolution),
            unit: 4.0,
            white_balance: None,
            halves,
            radiance: radiance.map(sums),
            second_half: sums(second_half),
            layers: Layers::default(),
        }
    }

    /// All channels alike, so that they are the luminance.
    fn grey(halves: [u64; 2], values: &[u128], second_half: &[u128]) -> Estimate {
        estimate(halves, [values; 3], second_half)
    }

    #[test]
    fn the_image_is_the_mean_in_the_unit() {
        let estimate = estimate([5, 3], [&[ONE, 3 * ONE / 2], &[ONE << 40, 0], &[1, 8]], &[0, 0]);
        let tiny = f32::exp2(-56.0) * 0.5;
        assert_eq!(estimate.image().pixels, [[0.5, f32::exp2(39.0), tiny], [0.75, 0.0, 8.0 * tiny]]);
        let nothing = Estimate { halves: [0, 0], ..estimate };
        assert!(nothing.image().pixels.iter().flatten().all(|value| value.is_finite()));
    }

    /// Rows of the matrix: twice the blue; half the red and green; red, and blue off.
    #[test]
    fn the_white_balance_changes_the_image_and_its_error() {
        let matrix = DMat3::from_cols_array_2d(&[[0.0, 0.5, 1.0], [0.0, 0.5, 0.0], [2.0, 0.0, -1.0]]);
        let plain = estimate([1, 1], [&[2 * ONE], &[4 * ONE], &[6 * ONE]], &[0]);
        let halves = [[0.5, 3.0, 1.0], [1.5, 1.0, 5.0]];
        let balanced = halves.map(|[r, g, b]| [2.0 * b, 0.5 * (r + g), r - b]);
        let lit = |[r, g, b]: [f64; 3]| 0.2126 * r + 0.7152 * g + 0.0722 * b;
        let second = (lit(balanced[1]) * ONE as f64) as u128;
        let sums = Estimate { white_balance: Some(matrix), second_half: vec![sum(second)], ..plain.clone() };
        assert_eq!(plain.image().pixels, [[4.0, 8.0, 12.0]]);
        assert_eq!(sums.image().pixels, [[24.0, 6.0, -8.0]]);
        let [a, b] = sums.half_luminances().unwrap().next().unwrap();
        assert!((a - lit(balanced[0])).abs() < 1e-12 && (b - lit(balanced[1])).abs() < 1e-12, "{a} {b}");
        let error = f64::from(sums.standard_error().unwrap()[0]);
        assert!((error - 4.0 * (a - b).abs() / 2.0).abs() < 1e-6, "{error}");
        assert!((sums.median_lit().unwrap() - (a + b) / 2.0).abs() < 1e-12);
        let layers = LayerForm::default();
        assert!(!sums.has_form([1, 1], 4.0, None, &layers) && sums.has_form([1, 1], 4.0, Some(matrix), &layers));
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
            estimate([iterations, iterations / 2], [&r, &g, &b], &s)
        };
        let shares = [share(3), share(2), share(8), share(0)];
        let total = |order: [usize; 4]| {
            let mut total = shares[order[0]].clone();
            order[1..].iter().for_each(|index| total.add(&shares[*index]));
            total
        };
        let expected = total([0, 1, 2, 3]);
        assert_eq!(expected.halves, [13, 6]);
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

    /// Halves of 3 and 1 iterations, with means of 2 and 6 units: (2 - 6)^2 * 3 / 16 = 3.
    #[test]
    fn the_standard_error_is_that_of_the_mean_of_two_halves() {
        let error = |halves, values: &[u128], second: &[u128]| grey(halves, values, second).standard_error();
        let close =
            |value: f32, expected: f64| assert!((f64::from(value) - expected).abs() <= 1e-6 * expected, "{value}");
        close(error([3, 1], &[12 * ONE], &[6 * ONE]).unwrap()[0], 4.0 * 3.0_f64.sqrt());
        assert_eq!(error([3, 1], &[8 * ONE], &[2 * ONE]).unwrap(), [0.0], "equal halves");
        for halves in [[0, 0], [0, 7], [7, 0]] {
            assert_eq!(error(halves, &[ONE], &[0]), None);
        }
    }

    /// Halves of 0 and 2 have an error of 1 at a luminance of 1; black pixels have none.
    #[test]
    fn the_relative_error_weighs_dark_pixels_less() {
        let relative = |values: &[u128]| grey([1, 1], values, values).relative_error().unwrap();
        let expect = |value: f64, expected: f64| assert!((value - expected).abs() < 1e-6, "{value}, not {expected}");
        expect(relative(&[2 * ONE]), (1.0 / 1.01_f64).sqrt());
        expect(relative(&[2 * ONE, 0]), (0.5 / 1.01_f64).sqrt());
        // A hundredth as bright, and as noisy in itself.
        let dark = 1e-4 / (1e-4 + 0.01);
        expect(relative(&[2 * ONE, 2 * ONE, 2 * ONE / 100]), ((2.0 / 1.01 + dark) / 3.0_f64).sqrt());
        assert_eq!(relative(&[0, 0]), 0.0);
        assert_eq!(grey([1, 0], &[ONE], &[0]).relative_error(), None);
    }
}
