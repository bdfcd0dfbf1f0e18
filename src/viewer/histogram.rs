//! The histogram of a picture: how many pixels have which value.

use super::quantity::Picture;
use crate::render::aov::AovKind;

/// The number of bins.
pub const BINS: usize = 96;
/// The longest logarithmic scale, in stops below the largest value: beyond what a screen and a file of 16 bits have.
const STOPS: f32 = 24.0;

/// The shares of the pixels with values in bins.
#[derive(Clone, Debug, PartialEq)]
pub struct Histogram {
    /// For each axis of the values, the share of the pixels in each bin.
    pub shares: Vec<Vec<f32>>,
    /// The values at the ends of the scale, in the unit of the quantity.
    pub ends: [f32; 2],
    /// Whether the scale is logarithmic.
    pub is_log: bool,
    /// The share of values, over all axes, that a logarithmic scale cannot show: 0 and less. Values that are no numbers
    /// count too.
    pub left_out: f32,
}

impl Histogram {
    /// Counts the values of a picture.
    pub fn of(picture: &Picture) -> Self {
        let kind = picture.quantity.kind();
        let axes = picture.quantity.axes().len();
        let is_log = matches!(kind, AovKind::Light | AovKind::Amount);
        let ends = match (is_log, picture.ends) {
            (true, _) => ends_of_logarithm(picture, axes),
            (false, Some([least, most])) if most.is_finite() => [least, most],
            (false, _) => [0.0, 1.0],
        };
        let [from, to] = if is_log { ends.map(logarithm) } else { ends };
        let per_value = BINS as f32 / (to - from);
        let mut counts = vec![[0_u32; BINS]; axes];
        let mut left_out = 0_u32;
        for values in &picture.values {
            for (counts, value) in counts.iter_mut().zip(values) {
                if value.is_nan() || is_log && *value <= 0.0 {
                    left_out += 1;
                } else {
                    let place = if is_log { logarithm(*value) } else { *value };
                    // What is beyond an end is in its bin.
                    counts[(((place - from) * per_value).max(0.0) as usize).min(BINS - 1)] += 1;
                }
            }
        }
        let all = picture.values.len().max(1) as f32;
        let shares = counts.iter().map(|counts| counts.iter().map(|count| *count as f32 / all).collect()).collect();
        Self { shares, ends, is_log, left_out: left_out as f32 / (all * axes as f32) }
    }

    /// Returns the place of a value on the scale: 0 is its beginning, 1 its end.
    pub fn place(&self, value: f32) -> f32 {
        let [from, to, value] =
            [self.ends[0], self.ends[1], value].map(|value| if self.is_log { logarithm(value) } else { value });
        (value - from) / (to - from)
    }
}

/// Returns the logarithm to base 2, linear between powers of two: what the bits of a number say, so that millions of
/// pixels take milliseconds. Errors are less than 0.09.
fn logarithm(value: f32) -> f32 {
    value.to_bits() as f32 * (-23_f32).exp2() - 127.0
}

fn ends_of_logarithm(picture: &Picture, axes: usize) -> [f32; 2] {
    let above = picture.values.iter().flat_map(|values| &values[..axes]).filter(|value| **value > 0.0);
    let (mut least, mut most) = (f32::INFINITY, 0.0_f32);
    for value in above.filter(|value| value.is_finite()) {
        (least, most) = (least.min(*value), most.max(*value));
    }
    if most == 0.0 {
        return [0.1, 1.0];
    }
    let least = least.max(most * (-STOPS).exp2()).min(0.5 * most);
    [least, most]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::aov::Aov;
    use crate::viewer::quantity::Quantity;

    fn picture(name: &str, values: &[f32], ends: Option<[f32; 2]>) -> Picture {
        let quantity = Aov::named(name).map_or(Quantity::Image, Quantity::Aov);
        let values: Vec<_> = values.iter().map(|value| [*value, *value, *value, 0.0]).collect();
        Picture { size: [values.len() as u32, 1], values, quantity, ends }
    }

    #[test]
    fn light_is_counted_by_stops() {
        let histogram =
            Histogram::of(&picture("image", &[0.0, 1.0, 2.0, 2.0, 4.0, f32::NAN, f32::INFINITY, -1.0], None));
        assert_eq!((histogram.ends, histogram.is_log), ([1.0, 4.0], true));
        assert_eq!(histogram.shares.len(), 3, "red, green, blue");
        for shares in &histogram.shares {
            assert_eq!((shares[0], shares[BINS / 2], shares[BINS - 1]), (0.125, 0.25, 0.25));
            assert_eq!(shares.iter().sum::<f32>(), 0.625);
        }
        assert_eq!(histogram.left_out, 0.375);
        assert!((histogram.place(2.0) - 0.5).abs() < 1e-6);
    }

    #[test]
    fn numbers_are_counted_between_their_ends() {
        let histogram = Histogram::of(&picture("Z", &[0.0, 5.0, 9.99, 1e9], Some([0.0, 10.0])));
        assert_eq!((histogram.shares.len(), histogram.is_log, histogram.left_out), (1, false, 0.0));
        assert_eq!((histogram.shares[0][0], histogram.shares[0][BINS / 2]), (0.25, 0.25));
        assert_eq!(histogram.shares[0][BINS - 1], 0.5, "the end has what is beyond it");
    }

    #[test]
    fn no_picture_is_too_strange() {
        for values in
            [vec![], vec![0.0; 3], vec![f32::NAN; 3], vec![f32::INFINITY; 2], vec![3.0], vec![f32::MIN_POSITIVE]]
        {
            for (name, ends) in [("image", None), ("Z", Some([0.0, f32::INFINITY])), ("Albedo", None)] {
                let histogram = Histogram::of(&picture(name, &values, ends));
                assert!(histogram.ends[0] < histogram.ends[1], "{name} {values:?} {histogram:?}");
                let sum: f32 = histogram.shares.iter().flatten().sum();
                assert!(sum.is_finite() && sum <= 3.001, "{name} {values:?}");
            }
        }
    }

    #[test]
    fn a_logarithm_of_bits_is_nearly_one() {
        for step in 1..1000 {
            let value = 1e-6 * 1.05_f32.powi(step);
            assert!((logarithm(value) - value.log2()).abs() < 0.09, "{value}");
        }
    }
}
