//! Input and output of the decoders, and steps that they have in common.

use std::io::Cursor;

use glam::DMat3;
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};

use crate::base::color::Primaries;
use crate::base::input::Budget;
use crate::image::film::{Image, Window, srgb_decode};

/// The transfer function of the whole numbers in a PNG, JPEG or TGA.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Transfer {
    /// That of sRGB.
    Srgb,
    /// None: the numbers are linear.
    Linear,
    /// A power with this exponent.
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

/// The use of an image, which decides how colours with other primaries than those of sRGB are converted.
/// Light is converted as it is. A reflectance is adapted to the white of sRGB (Bradford), so that white
/// stays white. pbrt does the same for images of lights and for textures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Use {
    /// Radiance or intensity.
    Light,
    /// Albedo.
    Reflectance,
}

impl Use {
    /// Returns the conversion to linear sRGB; `None` if the primaries are those of sRGB.
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

/// The contents of an image file.
#[derive(Clone, Debug, PartialEq)]
pub struct Layers {
    /// The colours.
    pub image: Image,
    /// Alpha of each pixel; `None` if the file has no alpha or it is 1 everywhere.
    pub alpha: Option<Vec<f32>>,
    /// Position of the image in a larger one; `None` if the format does not have it.
    pub window: Option<Window>,
}

/// A file's bytes, and how to decode them.
pub(super) struct Source<'a> {
    pub bytes: &'a [u8],
    pub transfer: Transfer,
    pub of: Use,
    pub budget: &'a Budget,
}

pub(super) fn opaque(image: Image) -> Layers {
    Layers { image, alpha: None, window: None }
}

/// Returns an image with its alpha, unless that is 1 everywhere.
pub(super) fn with_alpha(image: Image, alpha: Vec<f32>) -> Layers {
    let alpha = Some(alpha).filter(|alpha| alpha.iter().any(|alpha| *alpha != 1.0));
    Layers { image, alpha, window: None }
}

/// Multiplies all colours by a matrix.
pub(super) fn convert(image: &mut Image, matrix: DMat3) {
    for pixel in &mut image.pixels {
        *pixel = (matrix * glam::DVec3::from(pixel.map(f64::from))).as_vec3().to_array();
    }
}

impl Source<'_> {
    /// Returns the size of an image. An error says that it is not plausible, or that decoding it, at
    /// `bytes_per_pixel` bytes for a pixel, would exceed the budget.
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
/// Bytes of a pixel with alpha: four floats.
pub(super) const RGBA_BYTES: u64 = 16;

pub(super) fn decode_with_image_crate(
    bytes: &[u8],
    format: ImageFormat,
    source: &Source,
) -> Result<DynamicImage, String> {
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    // `check_size` keeps to the budget, which the crate's own limits do not know.
    reader.limits(Limits::no_limits());
    let decoder = reader.into_decoder().map_err(|error| error.to_string())?;
    let (width, height) = decoder.dimensions();
    // For the decoder's output, the same with alpha, and floats.
    let color = decoder.color_type();
    let with_alpha = 4 * u64::from(color.bytes_per_pixel() / color.channel_count());
    let bytes_per_pixel = u64::from(color.bytes_per_pixel()) + with_alpha + RGBA_BYTES;
    source.check_size(width.into(), height.into(), bytes_per_pixel)?;
    DynamicImage::from_decoder(decoder).map_err(|error| error.to_string())
}
