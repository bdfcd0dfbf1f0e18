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
