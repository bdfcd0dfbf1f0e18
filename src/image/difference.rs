//! Maps of the difference of an image from a reference: a value for each pixel, false colours, and their scale.

use crate::base::names::named;
use crate::image::compare::{DARK_SQUARE, Pair, SizeMismatch, check_sizes, differences, pairs, relative_error};
use crate::image::false_color::{NOT_FINITE, Palette, bytes};
use crate::image::film::{Image, LUMINANCE};

named! {
    /// What a map of differences shows.
    pub enum Difference = Relative {
        /// Relative error of the channels: the root of a pixel's part of relMSE
        Relative: "relative",
        /// Relative difference of luminance: red too bright, blue too dark, white equal
        Signed: "signed",
        /// Absolute difference, mean of the channels, W/(m² sr)
        Absolute: "absolute",
        /// FLIP: the difference that people see, from 0 to 1
        Flip: "flip",
    }
}

impl Difference {
    /// The name of the quantity, with its unit, for people.
    #[must_use]
    pub fn title(self) -> &'static str {
        match self {
            Self::Relative => "relative error",
            Self::Signed => "relative difference",
            Self::Absolute => "difference, W/(m² sr)",
            Self::Flip => "FLIP",
        }
    }

    /// The unit; 1 for ratios.
    #[must_use]
    pub fn unit(self) -> &'static str {
        if self == Self::Absolute { "W/(m² sr)" } else { "1" }
    }

    /// The palette of its maps.
    #[must_use]
    pub fn palette(self) -> Palette {
        if self == Self::Signed { Palette::Diverging } else { Palette::Magma }
    }

    /// Returns the value of a pixel; `None` for [`Difference::Flip`], which depends on other pixels.
    fn value(self, pair: Pair) -> Option<f64> {
        let luminance =
            |pixel: [f64; 3]| pixel.iter().zip(LUMINANCE).map(|(value, weight)| value * weight).sum::<f64>();
        match self {
            Self::Relative => Some(relative_error(pair).sqrt()),
            Self::Signed => {
                let reference = luminance(pair.1);
                Some(luminance(differences(pair)) / (reference * reference + DARK_SQUARE).sqrt())
            }
            Self::Absolute => Some(differences(pair).iter().map(|difference| difference.abs()).sum::<f64>() / 3.0),
            Self::Flip => None,
        }
    }
}

/// The difference of each pixel of an image from a reference.
#[derive(Clone, Debug, PartialEq)]
pub struct DifferenceMap {
    /// What the values are.
    pub kind: Difference,
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// `width * height` values, row-major, the top row first.
    pub values: Vec<f32>,
}

impl DifferenceMap {
    /// Measures the difference of each pixel. `None` for [`Difference::Flip`], whose values another crate has.
    ///
    /// # Errors
    /// The sizes differ.
    pub fn new(kind: Difference, image: &Image, reference: &Image) -> Result<Option<Self>, SizeMismatch> {
        check_sizes(image, reference)?;
        let values: Option<Vec<f32>> =
            pairs(image, reference).map(|pair| kind.value(pair).map(|value| value as f32)).collect();
        Ok(values.map(|values| Self { kind, width: image.width, height: image.height, values }))
    }

    /// Returns a scale on which 99 % of the pixels lie, with a round end. FLIP has the scale of its authors, 0 to 1.
    #[must_use]
    pub fn scale(&self) -> Scale {
        let most = if self.kind == Difference::Flip { 1.0 } else { round_above(self.largest_but_one_percent()) };
        Scale::new(self.kind, most)
    }

    /// Returns the least value that is at least as far from 0 as 99 % of the finite ones.
    fn largest_but_one_percent(&self) -> f64 {
        let mut sizes: Vec<f32> = self.values.iter().map(|value| value.abs()).filter(|size| size.is_finite()).collect();
        let Some(last) = sizes.len().checked_sub(1) else { return 0.0 };
        let index = last - last / 100;
        let (_, size, _) = sizes.select_nth_unstable_by(index, f32::total_cmp);
        f64::from(*size)
    }

    /// Returns the map in false colours: row-major, three bytes a pixel, sRGB.
    #[must_use]
    pub fn picture(&self, scale: &Scale) -> Vec<u8> {
        self.values.iter().flat_map(|value| scale.color(*value)).collect()
    }

    /// Returns the values as an image whose three channels are equal.
    #[must_use]
    pub fn image(&self) -> Image {
        let pixels = self.values.iter().map(|value| [*value; 3]).collect();
        Image { width: self.width, height: self.height, pixels }
    }
}

/// The values at the ends of a palette.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// What the values are.
    pub kind: Difference,
    /// The value of the last colour; that of the first is 0, or the negative of this one.
    pub most: f64,
}

impl Scale {
    /// Creates a scale. `most` is above 0.
    #[must_use]
    pub fn new(kind: Difference, most: f64) -> Self {
        Self { kind, most }
    }

    /// Returns the values of the first and the last colour.
    #[must_use]
    pub fn ends(&self) -> [f64; 2] {
        [if self.kind == Difference::Signed { -self.most } else { 0.0 }, self.most]
    }

    /// Returns the place of a value: 0 at the first colour, 1 at the last.
    #[must_use]
    pub fn place(&self, value: f64) -> f64 {
        let [least, most] = self.ends();
        (value - least) / (most - least)
    }

    /// Returns the colour of a value, sRGB. Values beyond an end have its colour; what is not finite is green.
    #[must_use]
    pub fn color(&self, value: f32) -> [u8; 3] {
        if !value.is_finite() {
            return bytes(NOT_FINITE);
        }
        self.kind.palette().bytes(self.place(f64::from(value)) as f32)
    }

    /// Returns round values on the scale with their texts, the least first.
    #[must_use]
    pub fn ticks(&self) -> Vec<(f64, String)> {
        let [least, most] = self.ends();
        let step = round_above((most - least) / 5.0 * (1.0 - 1e-9));
        // Integers, so that no sum of roundings becomes a text.
        let [first, last] = [least, most].map(|end| (end / step * (1.0 + 1e-9)).trunc() as i64);
        (first..=last).map(|i| (i as f64 * step, text(i, step))).collect()
    }
}

/// Returns the text of `i` steps.
fn text(i: i64, step: f64) -> String {
    let value = i as f64 * step;
    let decade = step.log10().floor();
    match decade as i32 {
        _ if i == 0 => "0".to_owned(),
        0..=4 => format!("{value:.0}"),
        // A step is 1, 2 or 5 times its decade.
        -4..0 => format!("{value:.*}", -decade as usize),
        _ => format!("{:e}", value as f32),
    }
}

/// Returns the least of 1, 2 and 5 times the powers of ten that is not below a value; 1 for a value that is 0 or
/// not finite.
fn round_above(value: f64) -> f64 {
    if value <= 0.0 || !value.is_finite() {
        return 1.0;
    }
    let decade = value.log10().floor() as i32;
    // Values are f32, so that 0.2 may be a little more.
    let candidates = [1.0, 2.0, 5.0, 10.0, 20.0].map(|digit| power(digit, decade));
    candidates.into_iter().find(|candidate| *candidate >= value * (1.0 - 1e-6)).unwrap_or(value)
}

/// Returns a digit times a power of ten, rounded once.
fn power(digit: f64, decade: i32) -> f64 {
    if decade < 0 && decade > -300 { digit / 10_f64.powi(-decade) } else { digit * 10_f64.powi(decade) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(pixels: Vec<[f32; 3]>) -> Image {
        Image::from_pixels(pixels.len() as u32, 1, pixels).unwrap()
    }

    fn map(kind: Difference, image: &Image, reference: &Image) -> DifferenceMap {
        DifferenceMap::new(kind, image, reference).unwrap().unwrap()
    }

    /// By hand: √(0.99 + 0.01) = 1, so that differences of white from 0.99^½ are relative ones.
    #[test]
    fn values_are_those_of_their_formulas() {
        let one = 0.99_f32.sqrt();
        let reference = image(vec![[one; 3]; 4]);
        let rendered = image(vec![[one + 0.25, one, one], [one - 0.5; 3], [one; 3], [f32::NAN; 3]]);
        let near = |kind: Difference, expected: [f64; 3]| {
            let values = map(kind, &rendered, &reference).values;
            assert!(values[3].is_nan());
            for (value, expected) in values.iter().zip(expected) {
                assert!((f64::from(*value) - expected).abs() < 1e-6, "{kind}: {values:?}");
            }
        };
        near(Difference::Relative, [0.25 / 3.0_f64.sqrt(), 0.5, 0.0]);
        near(Difference::Signed, [0.25 * LUMINANCE[0], -0.5, 0.0]);
        near(Difference::Absolute, [0.25 / 3.0, 0.5, 0.0]);
        assert_eq!(DifferenceMap::new(Difference::Flip, &rendered, &reference), Ok(None));
        assert!(DifferenceMap::new(Difference::Signed, &image(vec![[0.0; 3]]), &reference).is_err());
    }

    #[test]
    fn a_scale_ends_at_a_round_number_above_99_percent_of_the_pixels() {
        let sizes = |count: usize, most: f32| {
            let mut values = vec![0.013; count - 1];
            values.push(-most);
            DifferenceMap { kind: Difference::Signed, width: count as u32, height: 1, values }.scale().most
        };
        assert_eq!(sizes(1000, 7.0), 0.02);
        assert_eq!(sizes(2, 7.0), 10.0);
        assert_eq!(sizes(1000, f32::NAN), 0.02);
        assert_eq!(sizes(1, 0.0), 1.0);
        for (value, expected) in [(0.2, 0.2), (0.201, 0.5), (1.0, 1.0), (6.0, 10.0), (3e-7, 5e-7), (2e30, 2e30)] {
            assert_eq!(round_above(value), expected, "{value}");
        }
    }

    #[test]
    fn colors_are_those_of_the_scale() {
        let signed = Scale::new(Difference::Signed, 0.5);
        assert_eq!([0.0, -0.0].map(|zero| signed.color(zero)), [[255; 3]; 2]);
        assert_eq!(signed.color(0.5), Palette::Diverging.bytes(1.0));
        assert_eq!(signed.color(-7.0), Palette::Diverging.bytes(0.0));
        assert_eq!(signed.color(0.25), Palette::Diverging.bytes(0.75));
        assert_eq!(signed.color(f32::NAN), [0, 255, 0]);
        let relative = Scale::new(Difference::Relative, 2.0);
        assert_eq!(relative.color(0.0), [0; 3]);
        assert_eq!(relative.color(1.0), Palette::Magma.bytes(0.5));
        assert_eq!(relative.color(f32::INFINITY), [0, 255, 0]);
        assert_eq!(relative.color(1e30), Palette::Magma.bytes(1.0));
    }

    #[test]
    fn ticks_are_round_and_on_the_scale() {
        let texts = |kind, most: f64| {
            let ticks = Scale::new(kind, most).ticks();
            assert!(ticks.iter().all(|(value, _)| value.abs() <= most * (1.0 + 1e-9)), "{ticks:?}");
            ticks.into_iter().map(|(_, text)| text).collect::<Vec<_>>()
        };
        assert_eq!(texts(Difference::Relative, 1.0), ["0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(texts(Difference::Relative, 0.02), ["0", "0.005", "0.010", "0.015", "0.020"]);
        assert_eq!(texts(Difference::Signed, 0.5), ["-0.4", "-0.2", "0", "0.2", "0.4"]);
        assert_eq!(texts(Difference::Signed, 20.0), ["-20", "-10", "0", "10", "20"]);
        assert_eq!(texts(Difference::Absolute, 0.37), ["0", "0.1", "0.2", "0.3"]);
        assert_eq!(texts(Difference::Absolute, 2e-7), ["0", "5e-8", "1e-7", "1.5e-7", "2e-7"]);
    }
}
