//! What decoders have in common: a file's bytes with the way to read them, and what comes out.

use std::io::Cursor;

use glam::DMat3;
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};

use crate::base::color::Primaries;
use crate::base::input::Budget;
use crate::image::film::{Image, Window, srgb_decode};

/// How the whole numbers of a PNG, JPEG or TGA become linear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Transfer {
    /// By the sRGB transfer function.
    Srgb,
    /// They are.
    Linear,
    /// By this exponent.
    Gamma(f32),
}

impl Transfer {
    pub(super) fn decode(self, value: f32) -> f32 {
        match self {
            Self::Srgb => srgb_decode(value),
            Self::Linear => value,
            Self::Gamma(exponent) => value.powf(exponent),
        }
    }
}

/// What the colours of a file with primaries of its own are of: of another white than that of
/// sRGB, light is seen as it is, and a reflectance as it was seen, so that white stays white
/// (Bradford's adaptation). As pbrt's images of lights and its textures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Use {
    /// Radiance or intensity.
    Light,
    /// Albedo.
    Reflectance,
}

impl Use {
    /// To linear sRGB; `None` where colours are that already.
    pub(super) fn to_srgb(self, primaries: &Primaries) -> Result<Option<DMat3>, String> {
        if primaries.are_srgb() {
            return Ok(None);
        }
        if !primaries.are_valid() {
            return Err(format!("its chromaticities {primaries:?} make no colour space"));
        }
        Ok(Some(match self {
            Self::Light => primaries.light_to_srgb(),
            Self::Reflectance => primaries.reflectance_to_srgb(),
        }))
    }
}

/// All that is read of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Layers {
    /// Its colour.
    pub image: Image,
    /// Alpha of each pixel, where the file has it and it is not 1 everywhere.
    pub alpha: Option<Vec<f32>>,
    /// Where the image lies in a larger one, if the format can say so.
    pub window: Option<Window>,
}

/// A file's bytes, and how they become an image.
pub(super) struct Source<'a> {
    pub bytes: &'a [u8],
    pub transfer: Transfer,
    pub of: Use,
    pub budget: &'a Budget,
}

pub(super) fn opaque(image: Image) -> Layers {
    Layers { image, alpha: None, window: None }
}

/// Alpha that is 1 everywhere says nothing.
pub(super) fn with_alpha(image: Image, alpha: Vec<f32>) -> Layers {
    let alpha = Some(alpha).filter(|alpha| alpha.iter().any(|alpha| *alpha != 1.0));
    Layers { image, alpha, window: None }
}

/// Takes all colours through a matrix.
pub(super) fn convert(image: &mut Image, matrix: DMat3) {
    for pixel in &mut image.pixels {
        *pixel = (matrix * glam::DVec3::from(pixel.map(f64::from))).as_vec3().to_array();
    }
}

impl Source<'_> {
    /// The size of an image, if decoding it, which takes so many bytes for a pixel, is within the
    /// budget.
    pub fn check_size(&self, width: u64, height: u64, bytes_per_pixel: u64) -> Result<(u32, u32), String> {
        let size = || Some((u32::try_from(width).ok()?, u32::try_from(height).ok()?));
        let (Some(pixels @ 1..), Some(size)) = (width.checked_mul(height), size()) else {
            return Err(format!("a size of {width}x{height} is not plausible"));
        };
        let bytes = pixels.saturating_mul(bytes_per_pixel);
        self.budget.check(bytes).map_err(|over| format!("for its {width}x{height} pixels, {over}"))?;
        Ok(size)
    }
}

/// Bytes of a pixel: three floats.
pub(super) const RGB_BYTES: u64 = 12;
/// The same with alpha.
pub(super) const RGBA_BYTES: u64 = 16;

pub(super) fn decode_with_image_crate(
    bytes: &[u8],
    format: ImageFormat,
    source: &Source,
) -> Result<DynamicImage, String> {
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    // Those of the crate do not follow the budget; `check_size` does.
    reader.limits(Limits::no_limits());
    let decoder = reader.into_decoder().map_err(|error| error.to_string())?;
    let (width, height) = decoder.dimensions();
    // As the decoder makes it, with alpha, and as floats.
    let color = decoder.color_type();
    let with_alpha = 4 * u64::from(color.bytes_per_pixel() / color.channel_count());
    let bytes_per_pixel = u64::from(color.bytes_per_pixel()) + with_alpha + RGBA_BYTES;
    source.check_size(width.into(), height.into(), bytes_per_pixel)?;
    DynamicImage::from_decoder(decoder).map_err(|error| error.to_string())
}
