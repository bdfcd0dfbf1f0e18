//! Radiance files, `.hdr` (Ward, "Real Pixels", Graphics Gems II, 1991).

use glam::{DMat3, DVec2};
use image::ImageFormat;

use super::source::{Source, Use, convert, decode_with_image_crate};
use crate::base::color::{Primaries, srgb_from_xyz};
use crate::image::film::Image;

/// The bytes with which a file begins.
const MAGICS: [&[u8]; 2] = [b"#?RADIANCE\n", b"#?RGBE\n"];
/// The longest header in bytes.
const LONGEST: usize = 1 << 16;

/// Decodes an image with shared exponents, of RGB or CIE XYZ.
///
/// # Errors
/// The bytes are not a Radiance file; the message says why.
pub(super) fn decode(source: &Source) -> Result<Image, String> {
    let rest = MAGICS.iter().find_map(|magic| source.bytes.strip_prefix(*magic));
    let rest = rest.ok_or("it begins neither with #?RADIANCE nor with #?RGBE")?;
    let end = rest.windows(2).take(LONGEST).position(|two| two == b"\n\n");
    // A header can have no variables.
    let end = if rest.starts_with(b"\n") { 0 } else { end.ok_or("its header has no end")? + 1 };
    let to_srgb = conversion(&String::from_utf8_lossy(&rest[..end]), source.of)?;
    // The decoder accepts one magic and one format.
    let pixels = [b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n", &rest[end..]].concat();
    let decoded = decode_with_image_crate(&pixels, ImageFormat::Hdr, source)?.into_rgb32f();
    let pixels = decoded.pixels().map(|pixel| pixel.0).collect();
    let mut image = Image::from_pixels(decoded.width(), decoded.height(), pixels).map_err(|error| error.to_string())?;
    if let Some(matrix) = to_srgb {
        convert(&mut image, matrix);
    }
    Ok(image)
}

/// Returns the conversion from the colours that the header names to linear sRGB; `None` if they are those
/// of sRGB.
fn conversion(header: &str, of: Use) -> Result<Option<DMat3>, String> {
    let value =
        |name: &str| header.lines().rev().filter_map(|line| line.split_once('=')).find(|(key, _)| key.trim() == name);
    match value("FORMAT").map(|(_, format)| format.trim()) {
        Some("32-bit_rle_xyze") => return Ok(Some(srgb_from_xyz())),
        Some("32-bit_rle_rgbe") | None => {}
        Some(other) => return Err(format!("its format is {other:?}, not 32-bit_rle_rgbe or 32-bit_rle_xyze")),
    }
    let Some((_, primaries)) = value("PRIMARIES") else { return Ok(None) };
    let numbers: Result<Vec<f64>, _> = primaries.split_whitespace().map(str::parse).collect();
    let Ok([rx, ry, gx, gy, bx, by, wx, wy]) =
        numbers.as_deref().map_err(drop).and_then(|n| <[f64; 8]>::try_from(n).map_err(drop))
    else {
        return Err(format!("its primaries are {primaries:?}, not eight numbers"));
    };
    let [red, green, blue, white] = [[rx, ry], [gx, gy], [bx, by], [wx, wy]].map(DVec2::from);
    of.to_srgb(&Primaries { red, green, blue, white })
}
