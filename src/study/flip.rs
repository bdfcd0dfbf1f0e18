//! FLIP, the difference that people see (Andersson and others, "FLIP: A Difference Evaluator for Alternating Images",
//! 2020).

use serde::Serialize;

use crate::image::compare::{SizeMismatch, check_sizes};
use crate::image::difference::{Difference, DifferenceMap};
use crate::image::exposure::{auto_stops, exposed};
use crate::image::film::{Image, picture};

/// The mean of FLIP over an image, and the conditions under which the images are looked at.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Flip {
    /// Mean over the pixels: 0 is no difference that is seen, 1 the largest.
    pub mean: f64,
    /// `LDR`: of the images as a screen of 8 bits shows them, at one exposure. HDR-FLIP would take the largest value
    /// over many exposures.
    pub variant: &'static str,
    /// The exposure, in stops.
    pub exposure_stops: f32,
    /// Pixels in a degree of the field of vision: 67 are those of a 4K screen, 0.7 m wide, from 0.7 m away.
    pub pixels_per_degree: f32,
}

/// The exposure of pictures is chosen for a reference that is brighter or darker than middle grey by more stops than
/// these: at exposure 0, it would be white or black for the most part.
const MOST_STOPS: f32 = 3.0;

/// Returns the exposure, in stops, at which images are looked at that are compared with a reference: 0 unless the
/// reference is very bright or very dark.
#[must_use]
pub fn viewing_stops(reference: &Image) -> f32 {
    let stops = auto_stops(reference);
    if stops.abs() > MOST_STOPS { stops } else { 0.0 }
}

/// Returns LDR-FLIP of an image as PNGs show it at an exposure, in stops, and its map.
///
/// # Errors
/// The sizes differ.
pub fn flip(image: &Image, reference: &Image, stops: f32) -> Result<(Flip, DifferenceMap), SizeMismatch> {
    check_sizes(image, reference)?;
    Ok(flip_with(image, &picture(&exposed(reference, stops)), stops))
}

/// As [`flip`], from the picture of a reference of the image's size at this exposure.
pub(crate) fn flip_with(image: &Image, reference: &[u8], stops: f32) -> (Flip, DifferenceMap) {
    let Image { width, height, .. } = *image;
    let flip_image = |picture: &[u8]| nv_flip::FlipImageRgb8::with_data(width, height, picture);
    let shown = picture(&exposed(image, stops));
    let map = nv_flip::flip(flip_image(reference), flip_image(&shown), nv_flip::DEFAULT_PIXELS_PER_DEGREE);
    let flip = Flip {
        mean: f64::from(nv_flip::FlipPool::from_image(&map).mean()),
        variant: "LDR",
        exposure_stops: stops,
        pixels_per_degree: nv_flip::DEFAULT_PIXELS_PER_DEGREE,
    };
    (flip, DifferenceMap { kind: Difference::Flip, width, height, values: map.to_vec() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::false_color::Palette;

    #[test]
    fn the_map_has_the_mean_of_flip_and_the_colors_of_its_authors() {
        let grey = |value: f32| Image::from_pixels(8, 8, vec![[value; 3]; 64]).unwrap();
        let (flip, map) = flip(&grey(0.5), &grey(0.2), 0.0).unwrap();
        let mean = map.values.iter().map(|value| f64::from(*value)).sum::<f64>() / 64.0;
        assert!(flip.mean > 0.1 && (flip.mean - mean).abs() < 1e-6, "{flip:?}, {mean}");

        let authors = nv_flip::magma_lut().to_vec();
        for (i, theirs) in authors.chunks_exact(3).enumerate() {
            let ours = Palette::Magma.bytes(i as f32 / 255.0);
            assert!(ours.iter().zip(theirs).all(|(a, b)| a.abs_diff(*b) <= 6), "{i}: {ours:?} {theirs:?}");
        }
    }

    #[test]
    fn what_is_white_is_seen_at_another_exposure() {
        let grey = |value: f32| Image::from_pixels(8, 8, vec![[value; 3]; 64]).unwrap();
        let [dark, bright] = [flip(&grey(0.5), &grey(0.2), 0.0), flip(&grey(500.0), &grey(200.0), -1000_f32.log2())];
        assert!((dark.unwrap().0.mean - bright.unwrap().0.mean).abs() < 0.01);
        assert_eq!(flip(&grey(500.0), &grey(200.0), 0.0).unwrap().0.mean, 0.0);
        assert_eq!(viewing_stops(&grey(0.5)), 0.0);
        for value in [180.0, 0.00018] {
            assert!((viewing_stops(&grey(value)) - (0.18 / value).log2()).abs() < 0.01);
        }
    }
}
