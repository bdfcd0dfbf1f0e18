//! The error of an image against a reference, and the sums from which bias and noise are computed.

use std::borrow::Cow;

use image::imageops::{FilterType, resize};
use image::{ImageBuffer, Rgb};
use serde::Serialize;

use crate::image::compare::{DARK_SQUARE, SizeMismatch, compare};
use crate::image::difference::{Difference, DifferenceMap};
use crate::image::exposure::exposed;
use crate::image::film::{Image, picture};
use crate::study::flip::{flip_with, viewing_stops};

/// The error of one image against the reference.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ErrorOf {
    /// [`crate::image::compare::Comparison::relmse`].
    pub relmse: f64,
    /// [`crate::image::compare::Comparison::relmse_trimmed`].
    pub relmse_trimmed: f64,
    /// [`crate::image::compare::Comparison::energy_ratio`].
    pub energy_ratio: f64,
    /// Perceived difference, 0 to 1: the mean of LDR-FLIP over the images as PNGs show them at
    /// [`Reference::exposure_stops`].
    pub flip: f64,
}

/// The image that is taken to be right.
pub struct Reference {
    image: Image,
    /// The exposure of pictures, stops.
    stops: f32,
    /// The image as 8-bit sRGB at this exposure, to which FLIP compares.
    picture: Vec<u8>,
    /// Whether images of other sizes are resampled to this one's size.
    resample: bool,
}

impl Reference {
    /// Creates a reference. Without `resample`, images of other sizes are errors.
    pub fn new(image: Image, resample: bool) -> Self {
        let stops = viewing_stops(&image);
        Self { picture: picture(&exposed(&image, stops)), stops, image, resample }
    }

    /// Returns the number of pixels.
    pub fn pixels(&self) -> usize {
        self.image.pixels.len()
    }

    /// Returns width and height in pixels.
    pub fn resolution(&self) -> [u32; 2] {
        [self.image.width, self.image.height]
    }

    /// Measures an image.
    ///
    /// # Errors
    /// It has another size.
    pub fn error_of(&self, image: &Image) -> Result<ErrorOf, SizeMismatch> {
        let image = &*self.resampled(image);
        let comparison = compare(image, &self.image)?;
        let (flip, _) = flip_with(image, &self.picture, self.stops);
        Ok(ErrorOf {
            relmse: comparison.relmse,
            relmse_trimmed: comparison.relmse_trimmed,
            energy_ratio: comparison.energy_ratio,
            flip: flip.mean,
        })
    }

    /// Adds each pixel's difference from the reference to `sums`, divided by √(r² + 0.01): its square is
    /// the pixel's term of relMSE.
    ///
    /// # Errors
    /// The image has another size.
    pub fn add_differences(&self, image: &Image, sums: &mut [[f32; 3]]) -> Result<(), SizeMismatch> {
        let image = self.resampled(image);
        for ((sum, x), r) in sums.iter_mut().zip(&image.pixels).zip(&self.image.pixels) {
            for ((sum, x), r) in sum.iter_mut().zip(x).zip(r) {
                let [x, r] = [x, r].map(|value| f64::from(*value));
                *sum += ((x - r) / (r * r + DARK_SQUARE).sqrt()) as f32;
            }
        }
        Ok(())
    }

    /// Returns the relMSE of the mean of `images` images, from the sums of their differences.
    pub fn squared_mean(&self, sums: &[[f32; 3]], images: usize) -> f64 {
        let squares = sums.iter().flatten().map(|sum| (f64::from(*sum) / images as f64).powi(2));
        squares.sum::<f64>() / (3 * sums.len()) as f64
    }

    /// Returns how the luminance differs from the reference's, in its size.
    ///
    /// # Errors
    /// The image has another size.
    pub fn difference(&self, image: &Image) -> Result<Option<DifferenceMap>, SizeMismatch> {
        DifferenceMap::new(Difference::Signed, &self.resampled(image), &self.image)
    }

    /// Returns the exposure at which FLIP and the report see images, in stops: [`viewing_stops`].
    pub fn exposure_stops(&self) -> f32 {
        self.stops
    }

    /// Returns the reference itself.
    pub fn image(&self) -> &Image {
        &self.image
    }

    fn resampled<'a>(&self, image: &'a Image) -> Cow<'a, Image> {
        let Image { width, height, .. } = self.image;
        if !self.resample || (image.width, image.height) == (width, height) {
            return Cow::Borrowed(image);
        }
        // `resize` keeps values within 0 to 1.
        let values = || image.pixels.iter().flatten().copied().filter(|value| value.is_finite());
        let (least, most) = (values().fold(0.0, f32::min), values().fold(f32::MIN_POSITIVE, f32::max));
        let values = image.pixels.iter().flatten().map(|value| (value - least) / (most - least)).collect();
        let Some(pixels) = ImageBuffer::<Rgb<f32>, Vec<f32>>::from_raw(image.width, image.height, values) else {
            return Cow::Borrowed(image);
        };
        let pixels = resize(&pixels, width, height, FilterType::Triangle);
        let pixels = pixels.pixels().map(|pixel| pixel.0.map(|value| value * (most - least) + least)).collect();
        Cow::Owned(Image { width, height, pixels })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(seed: u32) -> Image {
        let mut state = seed;
        let mut value = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            0.5 + (state >> 8) as f32 / (1 << 24) as f32 - 0.5
        };
        Image::from_pixels(64, 64, (0..4096).map(|_| [value(), value(), value()]).collect()).unwrap()
    }

    /// Noise of variance 1/12 and a bias of 0.1 around 0.5 add up.
    #[test]
    fn the_mean_of_images_has_the_bias_and_less_of_the_noise() {
        let reference = Reference::new(Image::from_pixels(64, 64, vec![[0.4; 3]; 4096]).unwrap(), false);
        let mut sums = vec![[0.0; 3]; 4096];
        let mut mean = 0.0;
        for seed in 0..8 {
            let image = noise(seed * 7919 + 1);
            mean += reference.error_of(&image).unwrap().relmse / 8.0;
            reference.add_differences(&image, &mut sums).unwrap();
        }
        let weight = 0.4 * 0.4 + DARK_SQUARE;
        let near = |value: f64, expected: f64| assert!((value / expected - 1.0).abs() < 0.05, "{value}, {expected}");
        near(mean, (1.0 / 12.0 + 0.01) / weight);
        near(reference.squared_mean(&sums, 8), (1.0 / 96.0 + 0.01) / weight);
    }

    #[test]
    fn a_smaller_image_is_shown_as_large_where_that_is_asked_for() {
        let grey = |size: u32| Image::from_pixels(size, size, vec![[40.0, -0.5, 0.1]; (size * size) as usize]).unwrap();
        assert!(Reference::new(grey(8), false).error_of(&grey(4)).is_err());
        let error = Reference::new(grey(8), true).error_of(&grey(4)).unwrap();
        assert!(error.relmse < 1e-10 && error.flip < 1e-6, "{error:?}");
    }

    #[test]
    fn flip_is_small_for_what_is_hardly_seen() {
        let reference = Reference::new(noise(1), false);
        let flip = |image: &Image| reference.error_of(image).unwrap().flip;
        assert_eq!(flip(&noise(1)), 0.0);
        let mut brighter = noise(1);
        brighter.pixels.iter_mut().flatten().for_each(|value| *value *= 1.01);
        assert!(flip(&brighter) < 0.05 && flip(&noise(2)) > 0.2);
    }
}
