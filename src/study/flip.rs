//! FLIP, the difference that people see (Andersson and others, "FLIP: A Difference Evaluator for Alternating Images",
//! 2020).

use serde::Serialize;

use crate::image::compare::{SizeMismatch, check_sizes};
use crate::image::difference::{Difference, DifferenceMap};
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

/// Returns LDR-FLIP of an image at exposure 0, as PNGs show it, and its map.
///
/// # Errors
/// The sizes differ.
pub fn flip(image: &Image, reference: &Image) -> Result<(Flip, DifferenceMap), SizeMismatch> {
    check_sizes(image, reference)?;
    Ok(flip_of_pictures(image, &picture(image), &picture(reference)))
}

/// As [`flip`], of pictures of the size of `image`.
pub(crate) fn flip_of_pictures(image: &Image, shown: &[u8], reference: &[u8]) -> (Flip, DifferenceMap) {
    let Image { width, height, .. } = *image;
    let flip_image = |picture: &[u8]| nv_flip::FlipImageRgb8::with_data(width, height, picture);
    let map = nv_flip::flip(flip_image(reference), flip_image(shown), nv_flip::DEFAULT_PIXELS_PER_DEGREE);
    let flip = Flip {
        mean: f64::from(nv_flip::FlipPool::from_image(&map).mean()),
        variant: "LDR",
        exposure_stops: 0.0,
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
        let (flip, map) = flip(&grey(0.5), &grey(0.2)).unwrap();
        let mean = map.values.iter().map(|value| f64::from(*value)).sum::<f64>() / 64.0;
        assert!(flip.mean > 0.1 && (flip.mean - mean).abs() < 1e-6, "{flip:?}, {mean}");

        let authors = nv_flip::magma_lut().to_vec();
        for (i, theirs) in authors.chunks_exact(3).enumerate() {
            let ours = Palette::Magma.bytes(i as f32 / 255.0);
            assert!(ours.iter().zip(theirs).all(|(a, b)| a.abs_diff(*b) <= 6), "{i}: {ours:?} {theirs:?}");
        }
    }
}
