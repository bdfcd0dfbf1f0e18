//! Images of linear RGB, row by row, as renders make them and files hold them.

use glam::{DMat3, DVec3};

/// An image of linear RGB in the sRGB primaries. Its values are radiance in W/(m² sr) if a render made it.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// `width * height` pixels, row-major, the top row first.
    pub pixels: Vec<[f32; 3]>,
}

/// The coordinate system of an image's layers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CoordinateSystem {
    /// Camera space: x right, y up, z forward; lengths in the camera's units.
    #[default]
    Camera,
    /// World space.
    World,
}

/// The position of an image in a larger one, of which it is a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// Column and row of its first pixel, from the upper left corner of the larger image, outside of
    /// which it may lie.
    pub first: [i32; 2],
    /// Width and height of the larger image, in pixels.
    pub full: [u32; 2],
}

impl Window {
    /// Returns the window of an image that is the whole of its own.
    #[must_use]
    pub fn whole(resolution: [u32; 2]) -> Self {
        Self { first: [0; 2], full: resolution }
    }
}

/// Returns the pixels that two parts of one image have in common, as two images of equal size. `None` if
/// they have the same window, or are not parts of one image.
///
/// # Errors
/// They have no pixel in common.
pub fn common_part(a: (&Image, Window), b: (&Image, Window)) -> Result<Option<[Image; 2]>, Apart> {
    let [from, to] = [a, b].map(|(image, window)| {
        let [x, y] = window.first.map(i64::from);
        [[x, x + i64::from(image.width)], [y, y + i64::from(image.height)]]
    });
    if a.1.full != b.1.full || from == to {
        return Ok(None);
    }
    let common = [0, 1].map(|axis| [from[axis][0].max(to[axis][0]), from[axis][1].min(to[axis][1])]);
    if common.iter().any(|[low, high]| low >= high) {
        return Err(Apart);
    }
    // Inside both images, whose sides fit into 32 bits.
    let size = common.map(|[low, high]| (high - low) as u32);
    let part = |image: &Image, place: [[i64; 2]; 2]| {
        image.part([0, 1].map(|axis| (common[axis][0] - place[axis][0]) as u32), size)
    };
    Ok(Some([part(a.0, from), part(b.0, to)]))
}

/// Two parts of one image have no pixel in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the images are parts of one image that have no pixel in common")]
pub struct Apart;

/// The number of pixels does not fit the size that was stated, or the image is empty.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("an image of {width}x{height} cannot have {pixels} pixels")]
pub struct ShapeError {
    /// The stated width in pixels.
    pub width: u32,
    /// The stated height in pixels.
    pub height: u32,
    /// The number of pixels given.
    pub pixels: usize,
}

impl Image {
    /// Returns a black image.
    #[must_use]
    pub fn new(width: u32, height: u32) -> Self {
        let pixels = vec![[0.0; 3]; width as usize * height as usize];
        Self { width, height, pixels }
    }

    /// Returns an image of the given pixels: row-major, the top row first.
    ///
    /// # Errors
    /// When there are not exactly `width * height` pixels, or none at all.
    pub fn from_pixels(width: u32, height: u32, pixels: Vec<[f32; 3]>) -> Result<Self, ShapeError> {
        let image = Self { width, height, pixels };
        image.check_shape()?;
        Ok(image)
    }

    /// Returns the part that begins at pixel (x, y) and has this size. It must lie inside the image.
    fn part(&self, [x, y]: [u32; 2], [width, height]: [u32; 2]) -> Self {
        let rows = self.pixels.chunks_exact(self.width as usize).skip(y as usize).take(height as usize);
        let pixels = rows.flat_map(|row| &row[x as usize..(x + width) as usize]).copied().collect();
        Self { width, height, pixels }
    }

    /// Checks that the number of pixels is still `width * height`: the fields are public.
    ///
    /// # Errors
    /// When there are not exactly `width * height` pixels, or none at all.
    pub fn check_shape(&self) -> Result<(), ShapeError> {
        let expected = u64::from(self.width) * u64::from(self.height);
        if expected == 0 || expected != self.pixels.len() as u64 {
            return Err(ShapeError { width: self.width, height: self.height, pixels: self.pixels.len() });
        }
        Ok(())
    }
}

/// Returns the image as a screen shows it: colours outside of the gamut by [`into_gamut`], then 8 bits in the sRGB
/// transfer function, clamped to 0 to 1, with NaN as black; row-major, three bytes a pixel: red, green, blue.
#[must_use]
pub fn picture(image: &Image) -> Vec<u8> {
    let quantise = |linear: f32| (srgb_encode(linear.clamp(0.0, 1.0)) * 255.0).round() as u8;
    image.pixels.iter().flat_map(|pixel| into_gamut(*pixel).map(quantise)).collect()
}

/// Returns a colour of linear RGB as a screen can show it: without negative channels, which are those of colours outside
/// of sRGB's gamut. A colour inside stays as it is, however bright. One outside goes to the border of the gamut at the
/// same luminance, and becomes black if the luminance is not above 0. A channel that is no number is 0. The map is
/// continuous, and exposure may come before or after it.
///
/// It is the mean of two maps with these properties. The first moves the colour towards the grey of the same luminance
/// until the least channel is 0. Alone, it would make deep red pink, and draw a line into a rainbow wherever its hue is
/// that of a primary. The second makes negative channels 0 and scales the colour back to its luminance. Alone, it would
/// make all greens of a rainbow the same. The window has the same map, in `shaders/passes/tone_map.comp`.
#[must_use]
pub fn into_gamut(color: [f32; 3]) -> [f32; 3] {
    // False for NaN.
    if color.iter().all(|channel| *channel >= 0.0) {
        return color;
    }
    let finite = |channel: f32| if channel.is_nan() { 0.0 } else { f64::from(channel.clamp(f32::MIN, f32::MAX)) };
    let (color, weights) = (DVec3::from(color.map(finite)), DVec3::from(LUMINANCE));
    let (luminance, least) = (color.dot(weights), color.min_element().min(0.0));
    if luminance <= 0.0 {
        return [0.0; 3];
    }
    // Both have a luminance of 1.
    let desaturated = (color - least) / (luminance - least);
    let cut = color.max(DVec3::ZERO) / color.max(DVec3::ZERO).dot(weights);
    (0.5 * luminance * (desaturated + cut)).as_vec3().to_array()
}

/// Weights of red, green and blue in the relative luminance of linear RGB in the sRGB primaries
/// (ITU-R BT.709).
pub const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// Returns the weights of red, green and blue, as they are before the white balance, in the relative luminance
/// after it. Without a white balance they are [`LUMINANCE`].
#[must_use]
pub fn balanced_luminance(white_balance: Option<DMat3>) -> [f64; 3] {
    white_balance.map_or(LUMINANCE, |matrix| (matrix.transpose() * DVec3::from(LUMINANCE)).to_array())
}

/// Returns the relative luminance of linear RGB in the sRGB primaries.
#[must_use]
pub fn luminance([r, g, b]: [f32; 3]) -> f32 {
    let [red, green, blue] = LUMINANCE.map(|weight| weight as f32);
    red * r + green * g + blue * b
}

/// The sRGB transfer function: linear 0 to 1, to encoded 0 to 1 (IEC 61966-2-1).
#[must_use]
pub fn srgb_encode(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// The inverse of [`srgb_encode`]: encoded 0 to 1, to linear 0 to 1.
#[must_use]
pub fn srgb_decode(encoded: f32) -> f32 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_checked_image_has_as_many_pixels_as_its_size_says() {
        assert!(Image::from_pixels(2, 3, vec![[1.0; 3]; 6]).is_ok());
        assert!(Image::from_pixels(2, 3, vec![[1.0; 3]; 5]).is_err());
        assert!(Image::from_pixels(0, 3, vec![]).is_err());
        assert_eq!(Image::new(2, 3), Image::from_pixels(2, 3, vec![[0.0; 3]; 6]).unwrap());
    }

    #[test]
    fn parts_have_in_common_what_both_show() {
        let image = |width: u32, height: u32, first: [i32; 2]| {
            let value = |i: u32| [(i % width) as f32 + first[0] as f32, (i / width) as f32 + first[1] as f32, 0.0];
            let image = Image::from_pixels(width, height, (0..width * height).map(value).collect()).unwrap();
            (image, Window { first, full: [8, 6] })
        };
        let common = |a: &(Image, Window), b: &(Image, Window)| common_part((&a.0, a.1), (&b.0, b.1));
        let whole = image(8, 6, [0, 0]);
        for (a, b, size, first) in [
            (&whole, &image(3, 2, [4, 1]), [3, 2], [4.0, 1.0, 0.0]),
            (&image(4, 4, [1, 1]), &image(4, 4, [3, 0]), [2, 3], [3.0, 1.0, 0.0]),
            (&image(4, 4, [-1, 2]), &whole, [3, 4], [0.0, 2.0, 0.0]),
        ] {
            let [x, y] = common(a, b).unwrap().unwrap();
            assert_eq!(([x.width, x.height], x.pixels[0]), (size, first));
            assert_eq!(x, y);
        }
        assert_eq!(common(&whole, &whole), Ok(None));
        assert_eq!(common(&image(2, 2, [0, 0]), &image(2, 2, [2, 0])), Err(Apart));
        let other = (Image::new(8, 6), Window::whole([9, 6]));
        assert_eq!(common(&whole, &other), Ok(None));
    }

    /// Inside of the gamut, at its border, and outside.
    fn colors(channels: &[f32]) -> Vec<[f32; 3]> {
        let red = |r: f32| channels.iter().flat_map(move |g| channels.iter().map(move |b| [r, *g, *b]));
        channels.iter().copied().flat_map(red).collect()
    }

    #[test]
    fn colors_of_the_gamut_stay_as_they_are() {
        let inside = colors(&[0.0, f32::MIN_POSITIVE, 1e-3, 0.1, 0.7, 1.0, 9.0, f32::MAX, f32::INFINITY]);
        for color in &inside {
            assert_eq!(into_gamut(*color), *color);
        }
        let clamped = |channel: f32| (srgb_encode(channel.clamp(0.0, 1.0)) * 255.0).round() as u8;
        let bytes: Vec<u8> = inside.iter().flatten().map(|channel| clamped(*channel)).collect();
        assert_eq!(picture(&Image::from_pixels(27, 27, inside).unwrap()), bytes);
    }

    /// The roundings of three channels to f32 are 2^-24 of the luminance at most, those of f64 2^-50 of the terms.
    #[test]
    fn colors_outside_keep_their_luminance() {
        let weighted = |color: [f32; 3]| DVec3::from(color.map(f64::from)) * DVec3::from(LUMINANCE);
        let outside = colors(&[-1e20, -3.0, -0.1, -1e-3, 0.0, 1e-6, 0.02, 0.7, 8.0, 1e20]);
        for color in outside.into_iter().filter(|color| color.iter().any(|channel| *channel < 0.0)) {
            let shown = into_gamut(color);
            let (terms, luminance) = (weighted(color).abs().element_sum(), weighted(color).element_sum());
            let error = (weighted(shown).element_sum() - luminance.max(0.0)).abs();
            let tolerance = luminance.max(0.0) * (-24_f64).exp2() + terms * (-50_f64).exp2();
            assert!(error <= tolerance, "{color:?} {shown:?}");
            assert!(shown.iter().all(|channel| *channel >= 0.0) && shown.contains(&0.0), "{color:?} {shown:?}");
        }
    }

    /// Both maps have slopes of at most 1 over the least weight, so that a step of a channel changes no channel by more
    /// than 1 / 0.0722 + 1 times as much.
    #[test]
    fn the_border_of_the_gamut_is_not_seen() {
        const STEP: f32 = 1e-4;
        let mut places = colors(&[-1.0, -0.3, -STEP, 0.0, STEP, 0.2, 1.0]);
        // Where the luminance is 0, too.
        let [red, green, blue] = LUMINANCE.map(|weight| weight as f32);
        let dark = |[_, g, b]: [f32; 3]| [-(green * g + blue * b) / red, g, b];
        places.extend(colors(&[-1.0, 0.0, 0.4, 1.0]).into_iter().map(dark));
        for place in places {
            for axis in 0..3 {
                for step in [-STEP, STEP] {
                    let mut other = place;
                    other[axis] += step;
                    let [before, after] = [place, other].map(into_gamut);
                    let change = [0, 1, 2].map(|i| (after[i] - before[i]).abs());
                    assert!(change.iter().all(|change| *change < 15.0 * STEP), "{place:?} {other:?}: {change:?}");
                }
            }
        }
    }

    #[test]
    fn no_color_is_too_strange_for_a_screen() {
        let strange = [f32::NAN, f32::NEG_INFINITY, f32::MIN, -1.0, -0.0, f32::from_bits(1), f32::MAX, f32::INFINITY];
        for color in colors(&strange) {
            let shown = into_gamut(color);
            assert!(shown.iter().all(|channel| *channel >= 0.0), "{color:?} {shown:?}");
        }
        assert_eq!(into_gamut([f32::NAN, 0.5, 0.25]), [0.0, 0.5, 0.25]);
        assert_eq!(into_gamut([f32::NAN; 3]), [0.0; 3]);
        assert_eq!(into_gamut([f32::NEG_INFINITY, 1.0, 1.0]), [0.0; 3]);
        assert_eq!(into_gamut([-1.0; 3]), [0.0; 3]);
        let image = Image::from_pixels(2, 1, vec![[f32::INFINITY, -1.0, 1.0], [f32::NAN, -1.0, 2.0]]).unwrap();
        assert_eq!(picture(&image), [255, 0, 255, 0, 0, 0]);
    }

    #[test]
    fn luminance_weighs_the_primaries() {
        assert!((luminance([1.0; 3]) - 1.0).abs() < 1e-6);
        assert_eq!(luminance([0.0, 1.0, 0.0]), 0.7152);
    }

    #[test]
    fn luminance_is_that_after_the_white_balance() {
        assert_eq!(balanced_luminance(None), LUMINANCE);
        let matrix = DMat3::from_cols_array(&[2.0, 0.0, 0.5, 0.0, 3.0, 0.0, 1.0, 0.0, 4.0]);
        let [red, green, blue] = balanced_luminance(Some(matrix));
        let expected = [2.0 * 0.2126 + 0.5 * 0.0722, 3.0 * 0.7152, 0.2126 + 4.0 * 0.0722];
        assert!(DVec3::new(red, green, blue).distance(DVec3::from(expected)) < 1e-12, "{red} {green} {blue}");
    }

    #[test]
    fn the_srgb_curve_has_its_published_values_and_inverts() {
        assert!((srgb_encode(0.5) - 0.735_357).abs() < 1e-5);
        assert!((srgb_decode(0.5) - 0.214_041).abs() < 1e-5);
        for step in 0..=1000u16 {
            let encoded = f32::from(step) / 1000.0;
            assert!((srgb_encode(srgb_decode(encoded)) - encoded).abs() < 1e-5);
        }
    }
}
