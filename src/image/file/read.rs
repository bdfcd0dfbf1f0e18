//! Image files to images. A file is foreign: whatever it holds ends in an image or
//! in an error, and never takes much more memory than the image it claims to be.

mod exr;
mod hdr;

use std::io::Cursor;
use std::path::Path;

use glam::DMat3;
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};

use super::{ImageError, extension};
use crate::base::color::Primaries;
use crate::base::input::{self, Budget};
use crate::image::film::{Image, Window, srgb_decode};

/// The extensions that [`read`] accepts.
pub const READABLE_EXTENSIONS: &str = ".exr, .hdr, .jpg, .pfm, .png and .tga";

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
    fn decode(self, value: f32) -> f32 {
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
    fn to_srgb(self, primaries: &Primaries) -> Result<Option<DMat3>, String> {
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
struct Source<'a> {
    bytes: &'a [u8],
    transfer: Transfer,
    of: Use,
    budget: &'a Budget,
}

/// One format's source to an image, or what is wrong with it.
type Decode = fn(&Source) -> Result<Layers, String>;

/// Reads an image as linear RGB in the primaries of sRGB.
///
/// * EXR: see [`read_layers`]; colours are those of light. The image is the data
///   window, wherever that lies.
/// * PNG, JPEG, TGA: 8 or 16 bits, grey or colour, decoded from the sRGB transfer
///   function. Alpha is left out.
/// * PFM: colour or grey, both byte orders, times the scale's magnitude.
/// * HDR: Radiance RGBE or XYZE; what it says of its primaries counts, and what it
///   says of its exposure does not, as in pbrt.
///
/// # Errors
/// When the extension is unknown, the file cannot be read, or it does not hold an
/// image of the format that its extension names.
pub fn read(path: &Path) -> Result<Image, ImageError> {
    read_layers(path, Transfer::Srgb, Use::Light, &Budget::default()).map(|layers| layers.image)
}

/// As [`read`], with alpha, and with a transfer function of whole numbers, which alpha has, too.
/// What the image holds is taken from a budget.
///
/// Of an EXR it is the first part that has the channels R, G and B, or else X, Y and Z (CIE XYZ,
/// which is converted as it is), or those of the only layer that has R, G and B, as in
/// `beauty.R`, or Y, or a single channel of any name, which becomes grey. Its `chromaticities`
/// are those of R, G and B.
///
/// # Errors
/// As [`read`].
pub fn read_layers(path: &Path, transfer: Transfer, of: Use, budget: &Budget) -> Result<Layers, ImageError> {
    let (decode, expected): (Decode, _) = match extension(path).as_str() {
        "exr" => (exr::decode, "an OpenEXR image with the channels R, G, B, or X, Y, Z, or a single one"),
        "png" => (|source| decode_integers(source, ImageFormat::Png), "a PNG image"),
        "jpg" | "jpeg" => (|source| decode_integers(source, ImageFormat::Jpeg), "a JPEG image"),
        "tga" => (|source| decode_integers(source, ImageFormat::Tga), "a TGA image"),
        "pfm" => (|source| decode_pfm(source).map(opaque), "a PFM image"),
        "hdr" => (|source| hdr::decode(source).map(opaque), "a Radiance HDR image"),
        _ => {
            return Err(ImageError::Extension { path: path.to_owned(), supported: READABLE_EXTENSIONS });
        }
    };
    let bytes = input::read(path, budget).map_err(|reason| ImageError::Read { path: path.to_owned(), reason })?;
    let source = Source { bytes: &bytes, transfer, of, budget };
    let take = |layers: Layers| {
        let held =
            size_of_val(&layers.image.pixels[..]) + layers.alpha.as_ref().map_or(0, |alpha| size_of_val(&alpha[..]));
        budget.take(held as u64).map(|()| layers).map_err(|over| over.to_string())
    };
    decode(&source).and_then(take).map_err(|reason| ImageError::Decode { path: path.to_owned(), expected, reason })
}

fn opaque(image: Image) -> Layers {
    Layers { image, alpha: None, window: None }
}

/// Alpha that is 1 everywhere says nothing.
fn with_alpha(image: Image, alpha: Vec<f32>) -> Layers {
    let alpha = Some(alpha).filter(|alpha| alpha.iter().any(|alpha| *alpha != 1.0));
    Layers { image, alpha, window: None }
}

/// Takes all colours through a matrix.
fn convert(image: &mut Image, matrix: DMat3) {
    for pixel in &mut image.pixels {
        *pixel = (matrix * glam::DVec3::from(pixel.map(f64::from))).as_vec3().to_array();
    }
}

impl Source<'_> {
    /// The size of an image, if decoding it, which takes so many bytes for a pixel, is within the
    /// budget.
    fn check_size(&self, width: u64, height: u64, bytes_per_pixel: u64) -> Result<(u32, u32), String> {
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
const RGB_BYTES: u64 = 12;
/// The same with alpha.
const RGBA_BYTES: u64 = 16;

fn decode_with_image_crate(bytes: &[u8], format: ImageFormat, source: &Source) -> Result<DynamicImage, String> {
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

fn decode_integers(source: &Source, format: ImageFormat) -> Result<Layers, String> {
    let decoded = decode_with_image_crate(source.bytes, format, source)?;
    let (width, height) = (decoded.width(), decoded.height());
    let color = decoded.color();
    // Of grey with alpha, pbrt reads the grey alone.
    let has_alpha = color.has_color() && color.has_alpha();
    let (colors, alpha) = if color.bytes_per_pixel() == color.channel_count() {
        let table: Vec<f32> = (0..=255u8).map(|v| source.transfer.decode(f32::from(v) / 255.0)).collect();
        split_alpha(decoded.into_rgba8().as_raw(), has_alpha, |value| table[usize::from(value)])
    } else {
        let decode = |value: u16| source.transfer.decode(f32::from(value) / 65535.0);
        split_alpha(decoded.into_rgba16().as_raw(), has_alpha, decode)
    };
    let image = Image::from_pixels(width, height, colors).map_err(|error| error.to_string())?;
    Ok(match alpha {
        Some(alpha) => with_alpha(image, alpha),
        None => opaque(image),
    })
}

/// Colour and alpha of pixels.
fn split_alpha<T: Copy>(
    samples: &[T],
    has_alpha: bool,
    decode: impl Fn(T) -> f32,
) -> (Vec<[f32; 3]>, Option<Vec<f32>>) {
    let pixels = samples.chunks_exact(4);
    let colors = pixels.clone().map(|pixel| [0, 1, 2].map(|channel| decode(pixel[channel]))).collect();
    (colors, has_alpha.then(|| pixels.map(|pixel| decode(pixel[3])).collect()))
}

/// PFM: `PF` or `Pf`, width, height and scale as text, each ended by one white
/// space; then floats, the bottom row first. A negative scale means little-endian.
fn decode_pfm(source: &Source) -> Result<Image, String> {
    let mut rest = source.bytes;
    let channels = match pfm_word(&mut rest)? {
        "PF" => 3,
        "Pf" => 1,
        other => {
            return Err(format!("it begins with {other:?}, not with \"PF\" or \"Pf\""));
        }
    };
    let width = pfm_number::<u64>(&mut rest, "width")?;
    let height = pfm_number::<u64>(&mut rest, "height")?;
    let scale = pfm_number::<f32>(&mut rest, "scale")?;
    if !scale.is_finite() || scale == 0.0 {
        return Err(format!("its scale is {scale}"));
    }
    let (width, height) = source.check_size(width, height, RGB_BYTES)?;

    let row_bytes = width as usize * channels * 4;
    let wanted = row_bytes.checked_mul(height as usize);
    let data = wanted
        .and_then(|length| rest.get(..length))
        .ok_or_else(|| format!("only {} bytes of pixels for {width}x{height}", rest.len()))?;
    let sample = |raw: &[u8]| {
        let raw = [raw[0], raw[1], raw[2], raw[3]];
        scale.abs() * if scale < 0.0 { f32::from_le_bytes(raw) } else { f32::from_be_bytes(raw) }
    };
    let pixel = |raw: &[u8]| match channels {
        1 => [sample(raw); 3],
        _ => [sample(raw), sample(&raw[4..]), sample(&raw[8..])],
    };
    let rows_from_top = data.chunks_exact(row_bytes).rev();
    let pixels = rows_from_top.flat_map(|row| row.chunks_exact(channels * 4).map(pixel)).collect();
    Image::from_pixels(width, height, pixels).map_err(|error| error.to_string())
}

/// Takes one word and the single white space that ends it.
fn pfm_word<'a>(rest: &mut &'a [u8]) -> Result<&'a str, String> {
    const LONGEST: usize = 64;
    let start = rest.iter().take_while(|byte| byte.is_ascii_whitespace());
    let trimmed = &rest[start.count()..];
    let end = trimmed.iter().take(LONGEST).position(u8::is_ascii_whitespace).ok_or("its header is incomplete")?;
    *rest = &trimmed[end + 1..];
    std::str::from_utf8(&trimmed[..end]).map_err(|_| "its header is not text".to_owned())
}

fn pfm_number<T: std::str::FromStr>(rest: &mut &[u8], what: &str) -> Result<T, String> {
    let word = pfm_word(rest)?;
    word.parse().map_err(|_| format!("its {what} is {word:?}, not a number"))
}

#[cfg(test)]
mod tests;
