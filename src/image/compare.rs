//! The error of an image against a reference: metrics, and limits for the metrics.
//!
//! Sums are f64. A value that is not finite is counted, makes the metrics that contain it not finite, and
//! fails every limit.

use serde::Serialize;

use crate::image::film::Image;

/// The term that is added to the square of a reference value before a squared error is divided by it.
pub(crate) const DARK_SQUARE: f64 = 0.01;

/// Two images of different sizes cannot be compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "the image is {}x{} and the reference {}x{}: expected the same size",
    .image[0], .image[1], .reference[0], .reference[1]
)]
pub struct SizeMismatch {
    /// Width and height of the image.
    pub image: [u32; 2],
    /// Width and height of the reference.
    pub reference: [u32; 2],
}

/// The result of [`compare`]: over all pixels, or, where "trimmed", without the
/// [`left_out`](Self::left_out) pixels of the largest relative squared error. In JSON, a value that is not
/// finite is `null`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Mean over pixels and channels of the image, over that of the reference.
    /// 1 when both are black.
    pub energy_ratio: f64,
    /// [`energy_ratio`](Self::energy_ratio), trimmed.
    pub energy_ratio_trimmed: f64,
    /// Root of the mean over pixels and channels of (x - r)²; radiance.
    pub rmse: f64,
    /// Mean over pixels and channels of (x - r)² / (r² + 0.01).
    pub relmse: f64,
    /// [`relmse`](Self::relmse), trimmed.
    pub relmse_trimmed: f64,
    /// The largest |x - r| of any pixel and channel; radiance.
    pub max_difference: f64,
    /// Pixels left out where trimmed: 0.1 % of them, rounded down.
    pub left_out: usize,
    /// Pixels of the image with a channel that is not finite.
    pub non_finite_image: usize,
    /// Pixels of the reference with a channel that is not finite.
    pub non_finite_reference: usize,
}

/// Limits for an image; `None` is no limit. Both are for trimmed values, and so for the same pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Gates {
    /// The largest [`Comparison::relmse_trimmed`].
    pub max_relmse: Option<f64>,
    /// The largest difference of [`Comparison::energy_ratio_trimmed`] from 1.
    pub max_energy: Option<f64>,
}

/// Compares an image with a reference.
///
/// # Errors
/// When their sizes differ.
pub fn compare(image: &Image, reference: &Image) -> Result<Comparison, SizeMismatch> {
    check_sizes(image, reference)?;
    let errors: Vec<f64> = pairs(image, reference).map(relative_error).collect();
    let left_out = errors.len() / 1000;
    let worst = worst_pixels(&errors, left_out);

    let mut all = Sums::default();
    let mut kept = Sums::default();
    let mut max_difference = 0.0;
    for (index, pair) in pairs(image, reference).enumerate() {
        all.add(pair, errors[index]);
        if !worst[index] {
            kept.add(pair, errors[index]);
        }
        for difference in differences(pair) {
            max_difference = max_or_nan(max_difference, difference.abs());
        }
    }
    Ok(Comparison {
        width: image.width,
        height: image.height,
        energy_ratio: all.energy_ratio(),
        energy_ratio_trimmed: kept.energy_ratio(),
        rmse: (all.squared / (3.0 * all.pixels)).sqrt(),
        relmse: all.relative / all.pixels,
        relmse_trimmed: kept.relative / kept.pixels,
        max_difference,
        left_out,
        non_finite_image: non_finite(image),
        non_finite_reference: non_finite(reference),
    })
}

impl Comparison {
    /// Returns a line for each limit that is exceeded, and one for values that are not finite; none if the
    /// image passes.
    #[must_use]
    pub fn failures(&self, gates: &Gates) -> Vec<String> {
        let mut failures = Vec::new();
        let energy_error = (self.energy_ratio_trimmed - 1.0).abs();
        for (what, value, limit) in
            [("relMSE", self.relmse_trimmed, gates.max_relmse), ("|energy ratio - 1|", energy_error, gates.max_energy)]
        {
            // `Some(Less | Equal)` and not `value > limit`: a NaN must not pass.
            let kept = |limit: f64| value.partial_cmp(&limit).is_some_and(|order| order.is_le());
            if let Some(limit) = limit.filter(|&limit| !kept(limit)) {
                failures.push(format!("{what} is {value:.5e}, above {limit}"));
            }
        }
        let broken = self.non_finite_image + self.non_finite_reference;
        if broken > 0 && *gates != Gates::default() {
            failures.push(format!("{broken} pixels are not finite"));
        }
        failures
    }
}

/// A pixel of the image and that of the reference.
pub(crate) type Pair = ([f64; 3], [f64; 3]);

pub(crate) fn pairs<'a>(image: &'a Image, reference: &'a Image) -> impl Iterator<Item = Pair> + 'a {
    let both = image.pixels.iter().zip(&reference.pixels);
    both.map(|(x, r)| (x.map(f64::from), r.map(f64::from)))
}

pub(crate) fn differences((x, r): Pair) -> [f64; 3] {
    [x[0] - r[0], x[1] - r[1], x[2] - r[2]]
}

/// Returns the mean over the channels of (x - r)² / (r² + 0.01).
pub(crate) fn relative_error(pair: Pair) -> f64 {
    let squared = differences(pair).map(|difference| difference * difference);
    let channels = squared.iter().zip(pair.1);
    channels.map(|(squared, r)| squared / (r * r + DARK_SQUARE)).sum::<f64>() / 3.0
}

pub(crate) fn check_sizes(image: &Image, reference: &Image) -> Result<(), SizeMismatch> {
    let size = |image: &Image| [image.width, image.height];
    if size(image) != size(reference) || image.pixels.len() != reference.pixels.len() {
        return Err(SizeMismatch { image: size(image), reference: size(reference) });
    }
    Ok(())
}

/// Returns whether each pixel is one of the `count` pixels with the largest error. NaN is the largest
/// error; of equal errors the first are taken, so that the choice is reproducible.
fn worst_pixels(errors: &[f64], count: usize) -> Vec<bool> {
    let key = |index: usize| {
        if errors[index].is_nan() { f64::INFINITY } else { errors[index] }
    };
    let mut order: Vec<usize> = (0..errors.len()).collect();
    if count < order.len() {
        order.select_nth_unstable_by(count, |&a, &b| key(b).total_cmp(&key(a)).then(a.cmp(&b)));
    }
    let mut worst = vec![false; errors.len()];
    for &index in order.iter().take(count) {
        worst[index] = true;
    }
    worst
}

/// Returns the larger number, and NaN if one is NaN, which `f64::max` ignores.
fn max_or_nan(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) }
}

fn non_finite(image: &Image) -> usize {
    let broken = |pixel: &&[f32; 3]| pixel.iter().any(|value| !value.is_finite());
    image.pixels.iter().filter(broken).count()
}

#[derive(Default)]
struct Sums {
    pixels: f64,
    image: f64,
    reference: f64,
    squared: f64,
    relative: f64,
}

impl Sums {
    fn add(&mut self, pair: Pair, relative_error: f64) {
        self.pixels += 1.0;
        self.image += pair.0.iter().sum::<f64>();
        self.reference += pair.1.iter().sum::<f64>();
        self.squared += differences(pair).iter().map(|d| d * d).sum::<f64>();
        self.relative += relative_error;
    }

    fn energy_ratio(&self) -> f64 {
        if self.image == 0.0 && self.reference == 0.0 { 1.0 } else { self.image / self.reference }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STRICT: Gates = Gates { max_relmse: Some(1e30), max_energy: Some(1e30) };

    fn image(width: u32, pixels: Vec<[f32; 3]>) -> Image {
        let height = pixels.len() as u32 / width;
        Image::from_pixels(width, height, pixels).unwrap()
    }

    fn near(a: f64, b: f64) -> bool {
        (a - b).abs() <= 1e-12 * b.abs().max(1.0)
    }

    #[test]
    fn the_metrics_of_two_pixels_by_hand() {
        let reference = image(2, vec![[1.0, 2.0, 0.0], [0.5, 0.0, 0.0]]);
        let rendered = image(2, vec![[1.5, 2.0, 0.0], [0.5, -0.25, 1.0]]);
        let result = compare(&rendered, &reference).unwrap();
        assert!(near(result.energy_ratio, 4.75 / 3.5));
        assert!(near(result.rmse, ((0.25 + 0.0625 + 1.0) / 6.0f64).sqrt()));
        let relative = 0.25 / 1.01 + 0.0625 / 0.01 + 1.0 / 0.01;
        assert!(near(result.relmse, relative / 6.0));
        assert_eq!(result.relmse_trimmed, result.relmse);
        assert_eq!((result.max_difference, result.left_out), (1.0, 0));
    }

    #[test]
    fn the_worst_pixel_in_a_thousand_is_left_out() {
        let reference = image(100, vec![[1.0; 3]; 1000]);
        let mut rendered = image(100, vec![[1.1; 3]; 1000]);
        rendered.pixels[137] = [101.0, 1.0, 1.0];
        let result = compare(&rendered, &reference).unwrap();
        let small = f64::from(1.1f32) - 1.0;
        assert_eq!(result.left_out, 1);
        assert!(near(result.relmse_trimmed, small * small / 1.01));
        assert!(near(result.energy_ratio_trimmed, 1.0 + small));
        let relmse = (999.0 * small * small + 1e4 / 3.0) / 1010.0;
        assert!(near(result.relmse, relmse));
        assert!(near(result.energy_ratio, (2997.0 * (1.0 + small) + 103.0) / 3000.0));

        rendered.pixels.truncate(900);
        rendered.height = 9;
        let fewer = image(100, vec![[1.0; 3]; 900]);
        assert_eq!(compare(&rendered, &fewer).unwrap().left_out, 0);
    }

    #[test]
    fn a_value_that_is_not_finite_never_passes_a_gate() {
        let clean = image(100, vec![[1.0; 3]; 5000]);
        assert!(compare(&clean, &clean).unwrap().failures(&STRICT).is_empty());
        for bad in [f32::NAN, -f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            // Fewer than are left out, and more.
            for count in [1, 5, 6] {
                let mut broken = clean.clone();
                for pixel in &mut broken.pixels[..count] {
                    pixel[1] = bad;
                }
                for (x, r) in [(&broken, &clean), (&clean, &broken), (&broken, &broken)] {
                    let result = compare(x, r).unwrap();
                    assert!(!result.failures(&STRICT).is_empty(), "{result:?}");
                    assert!(!result.max_difference.is_finite());
                    assert_eq!(result.relmse_trimmed.is_finite(), count <= 5, "{result:?}");
                    assert!(result.failures(&Gates::default()).is_empty());
                }
            }
        }
    }

    #[test]
    fn gates_fail_above_their_limit_only() {
        let reference = image(1, vec![[1.0; 3]]);
        let rendered = image(1, vec![[0.5; 3]]);
        let result = compare(&rendered, &reference).unwrap();
        let failures = |max_relmse, max_energy| {
            let gates = Gates { max_relmse, max_energy };
            result.failures(&gates).len()
        };
        assert_eq!(failures(Some(0.25), Some(0.5)), 0);
        assert_eq!(failures(Some(0.24), None), 1);
        assert_eq!(failures(None, Some(0.49)), 1);
        assert_eq!(failures(Some(0.24), Some(0.49)), 2);
    }

    #[test]
    fn light_from_a_black_reference_is_not_a_match() {
        let black = Image::new(2, 2);
        let grey = image(2, vec![[0.1; 3]; 4]);
        assert_eq!(compare(&black, &black).unwrap().energy_ratio, 1.0);
        let result = compare(&grey, &black).unwrap();
        assert_eq!(result.energy_ratio, f64::INFINITY);
        assert_eq!(result.failures(&STRICT).len(), 1);
        let json = serde_json::to_value(result).unwrap();
        assert!(json["energy_ratio"].is_null() && json["rmse"].is_number());
    }

    #[test]
    fn different_sizes_are_an_error() {
        let result = compare(&Image::new(2, 3), &Image::new(3, 2));
        let message = result.unwrap_err().to_string();
        assert!(message.contains("2x3") && message.contains("3x2"), "{message}");
    }
}
