//! The exposure of pictures: how bright an image of linear radiance is shown, on a screen or in a PNG.

use crate::image::film::{Image, luminance};

/// The luminance that [`Exposure::Auto`] gives to the geometric mean of an image: middle grey, the key of an
/// average picture (Reinhard and others, "Photographic Tone Reproduction for Digital Images", 2002).
pub const KEY: f64 = 0.18;

/// Exposures in stops are accepted from minus this to this. Factors are then finite in f32.
pub const MAX_STOPS: f32 = 100.0;

/// The exposure of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exposure {
    /// Radiance times two to the power of this number: each stop doubles the brightness.
    Stops(f32),
    /// As many stops as make the geometric mean of the luminance [`KEY`].
    Auto,
}

impl Default for Exposure {
    fn default() -> Self {
        Self::Stops(0.0)
    }
}

impl Exposure {
    /// Returns the exposure for an image, in stops.
    #[must_use]
    pub fn stops(self, image: &Image) -> f32 {
        match self {
            Self::Stops(stops) => stops,
            Self::Auto => auto_stops(image),
        }
    }
}

/// Returns the stops of [`Exposure::Auto`], rounded to hundredths, so that they can be given as a number. Pixels
/// that are black or not finite do not count; without any other pixel it is 0.
#[must_use]
pub fn auto_stops(image: &Image) -> f32 {
    let lit = image.pixels.iter().map(|pixel| f64::from(luminance(*pixel)));
    let logs = lit.filter(|luminance| luminance.is_finite() && *luminance > 0.0).map(f64::log2);
    let [sum, count] = logs.fold([0.0, 0.0], |[sum, count], log| [sum + log, count + 1.0]);
    if count == 0.0 {
        return 0.0;
    }
    let stops = KEY.log2() - sum / count;
    (((stops * 100.0).round() / 100.0) as f32).clamp(-MAX_STOPS, MAX_STOPS)
}

/// Returns an image with all radiance times two to the power of `stops`.
#[must_use]
pub fn exposed(image: &Image, stops: f32) -> Image {
    let factor = stops.exp2();
    let pixels = image.pixels.iter().map(|pixel| pixel.map(|channel| channel * factor)).collect();
    Image { width: image.width, height: image.height, pixels }
}

/// Returns the share of pixels of which a picture of the image is white: all channels are 1 or more.
#[must_use]
pub fn white_share(image: &Image) -> f64 {
    let white = image.pixels.iter().filter(|pixel| pixel.iter().all(|channel| *channel >= 1.0)).count();
    white as f64 / image.pixels.len().max(1) as f64
}

/// Writes an exposure with its sign and unit, as in `+1.5 stops`.
#[must_use]
pub fn text(stops: f32) -> String {
    let unit = if stops.abs() == 1.0 { "stop" } else { "stops" };
    if stops == 0.0 { "0 stops".to_owned() } else { format!("{stops:+} {unit}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(pixels: &[[f32; 3]]) -> Image {
        Image::from_pixels(pixels.len() as u32, 1, pixels.to_vec()).unwrap()
    }

    #[test]
    fn auto_makes_the_geometric_mean_middle_grey() {
        // Luminances 0.01 and 100 have the geometric mean 1.
        let image = row(&[[0.01; 3], [100.0; 3]]);
        assert!((auto_stops(&image) - 0.18_f32.log2()).abs() < 0.006);
        for factor in [1e-20_f32, 0.37, 1e15] {
            let scaled = row(&image.pixels.iter().map(|pixel| pixel.map(|it| it * factor)).collect::<Vec<_>>());
            let expected = 0.18_f32.log2() - factor.log2();
            assert!((auto_stops(&scaled) - expected).abs() < 0.006, "{factor}");
        }
    }

    #[test]
    fn black_and_broken_pixels_do_not_count() {
        let grey = row(&[[0.5; 3]]);
        let among = row(&[[0.5; 3], [0.0; 3], [f32::NAN; 3], [f32::INFINITY; 3], [-1.0; 3]]);
        assert_eq!(auto_stops(&among), auto_stops(&grey));
        assert_eq!(auto_stops(&row(&[[0.0; 3]])), 0.0);
    }

    #[test]
    fn a_stop_doubles_and_white_is_counted() {
        let image = row(&[[0.25, 0.5, 1.0], [1.0, 1.0, 1.0], [0.6, 0.7, 0.8], [0.1, 2.0, 2.0]]);
        assert_eq!(exposed(&image, 1.0).pixels[0], [0.5, 1.0, 2.0]);
        assert_eq!(white_share(&image), 0.25);
        assert_eq!(white_share(&exposed(&image, 1.0)), 0.5);
        assert_eq!(Exposure::default().stops(&image), 0.0);
    }
}
