//! Reads image files. A file is not trusted: any bytes give an image or an error, and take no more memory
//! than a budget allows.

mod exr;
mod hdr;
mod source;

use std::path::Path;

use image::ImageFormat;
pub use source::{Layers, Transfer, Use};
use source::{RGB_BYTES, Source, decode_with_image_crate, opaque, with_alpha};

use super::{ImageError, extension};
use crate::base::input::{self, Budget};
use crate::image::film::Image;

/// The extensions that [`read`] accepts.
pub const READABLE_EXTENSIONS: &str = ".exr, .hdr, .jpg, .pfm, .png and .tga";

/// Decodes a file of one format. An error says what is wrong with it.
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

/// Reads an image with its alpha. `transfer` is the transfer function of whole numbers, alpha included. The
/// memory of the image is taken from `budget`.
///
/// Of an EXR it reads the first part with the channels R, G and B. Without one it reads X, Y and Z (CIE
/// XYZ), or Y as grey, or R, G and B of the only layer that has them, as in `beauty.R`, or the only
/// channel, of any name, as grey. `chromaticities` apply to R, G and B.
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

/// Returns colour and alpha of each pixel.
fn split_alpha<T: Copy>(
    samples: &[T],
    has_alpha: bool,
    decode: impl Fn(T) -> f32,
) -> (Vec<[f32; 3]>, Option<Vec<f32>>) {
    let pixels = samples.chunks_exact(4);
    let colors = pixels.clone().map(|pixel| [0, 1, 2].map(|channel| decode(pixel[channel]))).collect();
    (colors, has_alpha.then(|| pixels.map(|pixel| decode(pixel[3])).collect()))
}

/// Decodes a PFM: `PF` or `Pf`, width, height and scale as text, each followed by one white space; then
/// floats, the bottom row first. A negative scale means little-endian.
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

/// Takes one word and the white space after it.
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
