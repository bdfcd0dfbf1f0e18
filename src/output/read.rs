//! Image files to images. A file is foreign: whatever it holds ends in an image or
//! in an error, and never takes much more memory than the image it claims to be.

use std::fs;
use std::io::Cursor;
use std::path::Path;

use exr::meta::{MetaData, header::Header};
use exr::prelude::{ReadChannels, ReadLayers, ReadSpecificChannel, Vec2};
use image::{DynamicImage, ImageFormat, ImageReader};

use super::{ImageError, extension};
use crate::film::{Image, srgb_decode};

/// The extensions that [`read`] accepts.
pub const READABLE_EXTENSIONS: &str = ".exr, .hdr, .jpg, .pfm, .png and .tga";

/// More pixels than this are taken for a damaged or hostile header.
const MAX_PIXELS: u64 = 1 << 27;

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

/// All that is read of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Layers {
    /// Its colour.
    pub image: Image,
    /// Alpha of each pixel, where the file has it and it is not 1 everywhere.
    pub alpha: Option<Vec<f32>>,
}

/// Bytes of one format to an image, or what is wrong with them.
type Decode = fn(&[u8], Transfer) -> Result<Layers, String>;

/// Reads an image as linear RGB.
///
/// * EXR: the first part with the channels R, G and B, else the first with Y
///   (which becomes grey), of any sample type. The image is the data window,
///   wherever that lies; the primaries are taken to be sRGB's.
/// * PNG, JPEG, TGA: 8 or 16 bits, grey or colour, decoded from the sRGB transfer
///   function. Alpha is left out.
/// * PFM: colour or grey, both byte orders, times the scale's magnitude.
/// * HDR: Radiance RGBE.
///
/// # Errors
/// When the extension is unknown, the file cannot be read, or it does not hold an
/// image of the format that its extension names.
pub fn read(path: &Path) -> Result<Image, ImageError> {
    read_layers(path, Transfer::Srgb).map(|layers| layers.image)
}

/// As [`read`], with alpha, and with a transfer function of whole numbers, which alpha has, too.
///
/// # Errors
/// As [`read`].
pub fn read_layers(path: &Path, transfer: Transfer) -> Result<Layers, ImageError> {
    let (decode, expected): (Decode, _) = match extension(path).as_str() {
        "exr" => (|bytes, _| decode_exr(bytes), "an OpenEXR image with the channels R, G, B or Y"),
        "png" => (|bytes, transfer| decode_integers(bytes, ImageFormat::Png, transfer), "a PNG image"),
        "jpg" | "jpeg" => (|bytes, transfer| decode_integers(bytes, ImageFormat::Jpeg, transfer), "a JPEG image"),
        "tga" => (|bytes, transfer| decode_integers(bytes, ImageFormat::Tga, transfer), "a TGA image"),
        "pfm" => (|bytes, _| decode_pfm(bytes).map(opaque), "a PFM image"),
        "hdr" => (|bytes, _| decode_hdr(bytes).map(opaque), "a Radiance HDR image"),
        _ => {
            return Err(ImageError::Extension { path: path.to_owned(), supported: READABLE_EXTENSIONS });
        }
    };
    let bytes = fs::read(path).map_err(|reason| ImageError::Read { path: path.to_owned(), reason })?;
    decode(&bytes, transfer).map_err(|reason| ImageError::Decode { path: path.to_owned(), expected, reason })
}

fn opaque(image: Image) -> Layers {
    Layers { image, alpha: None }
}

/// Alpha that is 1 everywhere says nothing.
fn with_alpha(image: Image, alpha: Vec<f32>) -> Layers {
    let alpha = Some(alpha).filter(|alpha| alpha.iter().any(|alpha| *alpha != 1.0));
    Layers { image, alpha }
}

fn check_size(width: u64, height: u64) -> Result<(u32, u32), String> {
    let size = || Some((u32::try_from(width).ok()?, u32::try_from(height).ok()?));
    match (width.checked_mul(height), size()) {
        (Some(1..=MAX_PIXELS), Some(size)) => Ok(size),
        _ => Err(format!("a size of {width}x{height} is not plausible")),
    }
}

fn decode_exr(bytes: &[u8]) -> Result<Layers, String> {
    let headers = MetaData::read_from_buffered(bytes, false).map_err(|error| error.to_string())?.headers;
    // Before the reader allocates what the header asks for.
    for header in &headers {
        check_size(header.layer_size.0 as u64, header.layer_size.1 as u64)?;
    }
    let has = |wanted: &[&str]| headers.iter().any(|header| has_channels(header, wanted));
    if has(&["R", "G", "B"]) {
        catch_panic(|| decode_exr_rgb(bytes))
    } else if has(&["Y"]) {
        catch_panic(|| decode_exr_luminance(bytes).map(opaque))
    } else {
        let channels: Vec<String> =
            headers.iter().flat_map(|header| &header.channels.list).map(|channel| channel.name.to_string()).collect();
        Err(format!("its channels are {}", channels.join(", ")))
    }
}

/// The `exr` crate panics on some damaged B44 blocks (1.74). It must then decode on
/// this thread: a panic on one of its own would abort the process.
fn catch_panic(decode: impl FnOnce() -> Result<Layers, String>) -> Result<Layers, String> {
    std::panic::catch_unwind(std::panic::AssertUnwindSafe(decode))
        .unwrap_or_else(|_| Err("its pixel data is damaged".to_owned()))
}

fn has_channels(header: &Header, wanted: &[&str]) -> bool {
    let has = |name: &&str| {
        let mut channels = header.channels.list.iter();
        channels.any(|channel| channel.name.as_slice() == name.as_bytes())
    };
    !header.deep && wanted.iter().all(has)
}

fn decode_exr_rgb(bytes: &[u8]) -> Result<Layers, String> {
    exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .specific_channels()
        .required("R")
        .required("G")
        .required("B")
        .optional("A", 1.0f32)
        .collect_pixels(
            |size, _| (black(size), vec![1.0; size.area()]),
            |(image, alpha): &mut (Image, Vec<f32>), at, (r, g, b, a): (f32, f32, f32, f32)| {
                set(image, at, [r, g, b]);
                if let Some(alpha) = alpha.get_mut(at.1 * image.width as usize + at.0) {
                    *alpha = a;
                }
            },
        )
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map(|file| file.layer_data.channel_data.pixels)
        .map(|(image, alpha)| with_alpha(image, alpha))
        .map_err(|error| error.to_string())
}

fn decode_exr_luminance(bytes: &[u8]) -> Result<Image, String> {
    exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .specific_channels()
        .required("Y")
        .collect_pixels(|size, _| black(size), |image: &mut Image, at, (y,): (f32,)| set(image, at, [y; 3]))
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map(|file| file.layer_data.channel_data.pixels)
        .map_err(|error| error.to_string())
}

fn black(size: Vec2<usize>) -> Image {
    // `decode_exr` has checked that both fit.
    Image::new(size.0 as u32, size.1 as u32)
}

fn set(image: &mut Image, at: Vec2<usize>, value: [f32; 3]) {
    let index = at.1 * image.width as usize + at.0;
    if let Some(pixel) = image.pixels.get_mut(index) {
        *pixel = value;
    }
}

/// Decodes with the image crate's default limit on memory, 512 MiB.
fn decode_with_image_crate(bytes: &[u8], format: ImageFormat) -> Result<DynamicImage, String> {
    ImageReader::with_format(Cursor::new(bytes), format).decode().map_err(|error| error.to_string())
}

fn decode_integers(bytes: &[u8], format: ImageFormat, transfer: Transfer) -> Result<Layers, String> {
    let decoded = decode_with_image_crate(bytes, format)?;
    let (width, height) = (decoded.width(), decoded.height());
    let color = decoded.color();
    let pixels: Vec<[f32; 4]> = if color.bytes_per_pixel() == color.channel_count() {
        let table: Vec<f32> = (0..=255u8).map(|v| transfer.decode(f32::from(v) / 255.0)).collect();
        let decode = |value| table[usize::from(value)];
        decoded.into_rgba8().pixels().map(|pixel| pixel.0.map(decode)).collect()
    } else {
        let decode = |value: u16| transfer.decode(f32::from(value) / 65535.0);
        decoded.into_rgba16().pixels().map(|pixel| pixel.0.map(decode)).collect()
    };
    let colors = pixels.iter().map(|[r, g, b, _]| [*r, *g, *b]).collect();
    let image = Image::from_pixels(width, height, colors).map_err(|error| error.to_string())?;
    // Of grey with alpha, pbrt reads the grey alone.
    if color.has_color() && color.has_alpha() {
        return Ok(with_alpha(image, pixels.iter().map(|pixel| pixel[3]).collect()));
    }
    Ok(opaque(image))
}

fn decode_hdr(bytes: &[u8]) -> Result<Image, String> {
    let decoded = decode_with_image_crate(bytes, ImageFormat::Hdr)?.into_rgb32f();
    let pixels = decoded.pixels().map(|pixel| pixel.0).collect();
    Image::from_pixels(decoded.width(), decoded.height(), pixels).map_err(|error| error.to_string())
}

/// PFM: `PF` or `Pf`, width, height and scale as text, each ended by one white
/// space; then floats, the bottom row first. A negative scale means little-endian.
fn decode_pfm(bytes: &[u8]) -> Result<Image, String> {
    let mut rest = bytes;
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
    let (width, height) = check_size(width, height)?;

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
mod tests {
    use exr::prelude::*;
    use proptest::prelude::{ProptestConfig, any, prop_assert, proptest};

    use super::*;

    /// The channels, three pixels wide and two high, at a data window that lies
    /// partly outside the display window.
    fn exr_file(channels: Vec<(&str, FlatSamples)>) -> Vec<u8> {
        let list = channels.into_iter().map(|(name, samples)| AnyChannel::new(name, samples));
        let attributes = LayerAttributes { layer_position: Vec2(-1, 5), ..LayerAttributes::default() };
        let channels = AnyChannels::sort(list.collect());
        let layer = Layer::new((3, 2), attributes, Encoding::FAST_LOSSLESS, channels);
        let mut image = exr::prelude::Image::from_layer(layer);
        image.attributes.display_window = IntegerBounds::new((0, 0), (64, 64));
        let mut file = Cursor::new(Vec::new());
        image.write().to_buffered(&mut file).unwrap();
        file.into_inner()
    }

    fn halves(first: f32) -> FlatSamples {
        let values = (0..6u8).map(|i| f16::from_f32(first + f32::from(i)));
        FlatSamples::F16(values.collect())
    }

    #[test]
    fn a_half_float_exr_is_its_data_window() {
        let file = exr_file(vec![("A", halves(99.0)), ("B", halves(20.0)), ("G", halves(10.0)), ("R", halves(0.5))]);
        let image = decode_exr(&file).unwrap().image;
        assert_eq!((image.width, image.height), (3, 2));
        assert_eq!(image.pixels[0], [0.5, 10.0, 20.0]);
        assert_eq!(image.pixels[5], [5.5, 15.0, 25.0]);
    }

    #[test]
    fn luminance_alone_is_grey_and_other_channels_are_an_error() {
        let image = decode_exr(&exr_file(vec![("Y", halves(1.0))])).unwrap().image;
        assert_eq!(image.pixels[3], [4.0; 3]);
        let error = decode_exr(&exr_file(vec![("A", halves(1.0)), ("Z", halves(1.0))]));
        assert_eq!(error.unwrap_err(), "its channels are A, Z");
    }

    #[test]
    fn a_truncated_exr_is_an_error() {
        let file = exr_file(vec![("Y", halves(1.0))]);
        for length in 0..file.len() {
            assert!(decode_exr(&file[..length]).is_err(), "{length} bytes");
        }
    }

    #[test]
    fn png_is_decoded_at_eight_and_sixteen_bits() {
        let encoded = |image: DynamicImage| {
            let mut file = Cursor::new(Vec::new());
            image.write_to(&mut file, ImageFormat::Png).unwrap();
            decode_integers(file.get_ref(), ImageFormat::Png, Transfer::Srgb).unwrap().image.pixels[0]
        };
        let grey = image::GrayAlphaImage::from_pixel(1, 1, image::LumaA([188, 10]));
        assert_eq!(encoded(grey.into()), [srgb_decode(188.0 / 255.0); 3]);
        let deep = image::ImageBuffer::from_pixel(1, 1, image::Rgb([0u16, 30_001, 65_535]));
        let expected = [0.0, srgb_decode(30_001.0 / 65_535.0), 1.0];
        assert_eq!(encoded(deep.into()), expected);
    }

    #[test]
    fn alpha_is_read_where_it_says_something() {
        let layers_of = |image: DynamicImage, format, transfer| {
            let mut file = Cursor::new(Vec::new());
            image.write_to(&mut file, format).unwrap();
            decode_integers(file.get_ref(), format, transfer).unwrap()
        };
        let half = image::RgbaImage::from_pixel(1, 1, image::Rgba([255, 0, 51, 102]));
        let layers = layers_of(half.clone().into(), ImageFormat::Png, Transfer::Linear);
        assert_eq!((layers.image.pixels[0], layers.alpha), ([1.0, 0.0, 0.2], Some(vec![0.4])));
        let layers = layers_of(half.into(), ImageFormat::Tga, Transfer::Gamma(2.0));
        assert!((layers.image.pixels[0][2] - 0.04).abs() < 1e-6 && (layers.alpha.unwrap()[0] - 0.16).abs() < 1e-6);
        let full = image::RgbaImage::from_pixel(1, 1, image::Rgba([255, 0, 51, 255]));
        assert_eq!(layers_of(full.into(), ImageFormat::Png, Transfer::Srgb).alpha, None);
        let file = exr_file(vec![("A", halves(0.5)), ("B", halves(20.0)), ("G", halves(10.0)), ("R", halves(0.5))]);
        assert_eq!(decode_exr(&file).unwrap().alpha.unwrap()[1], 1.5);
    }

    #[test]
    fn jpeg_is_decoded_as_srgb() {
        let mut file = Cursor::new(Vec::new());
        let grey = image::RgbImage::from_pixel(16, 8, image::Rgb([188, 188, 188]));
        DynamicImage::from(grey).write_to(&mut file, ImageFormat::Jpeg).unwrap();
        let image = decode_integers(file.get_ref(), ImageFormat::Jpeg, Transfer::Srgb).unwrap().image;
        assert_eq!((image.width, image.height), (16, 8));
        assert!((image.pixels[77][1] - 0.5).abs() < 0.01, "{:?}", image.pixels[77]);
    }

    #[test]
    fn hdr_is_linear() {
        let mut file = Vec::new();
        let pixels = [image::Rgb([0.5f32, 1.0, 8.0]); 2];
        let encoder = image::codecs::hdr::HdrEncoder::new(&mut file);
        encoder.encode(&pixels, 2, 1).unwrap();
        let pixel = decode_hdr(&file).unwrap().pixels[1];
        assert!((pixel[0] - 0.5).abs() < 0.05 && (pixel[2] - 8.0).abs() < 0.05, "{pixel:?}");
    }

    fn pfm(header: &str, values: &[f32], little: bool) -> Vec<u8> {
        let raw = |value: &f32| {
            if little { value.to_le_bytes() } else { value.to_be_bytes() }
        };
        let data = values.iter().flat_map(raw);
        header.bytes().chain(data).collect()
    }

    #[test]
    fn pfm_rows_run_upwards_in_both_byte_orders() {
        let grey = pfm("Pf\n2 2\n-1.0\n", &[1.0, 2.0, 3.0, 4.0], true);
        let pixels = decode_pfm(&grey).unwrap().pixels;
        assert_eq!(pixels, [[3.0; 3], [4.0; 3], [1.0; 3], [2.0; 3]]);
        let colour = pfm("PF 1 1 2\n", &[1.0, 2.0, -3.0], false);
        assert_eq!(decode_pfm(&colour).unwrap().pixels, [[2.0, 4.0, -6.0]]);
    }

    #[test]
    fn a_pfm_that_promises_more_than_it_holds_is_an_error() {
        for header in [
            "",
            "P6\n1 1\n-1\n",
            "Pf\n1 1\n",
            "Pf\n1 1\n0\n",
            "Pf\n1 1\nnan\n",
            "Pf\n0 0\n1\n",
            "Pf\n-1 1\n1\n",
            "Pf\n1 2\n1\n",
            "PF\n1 1\n1\n",
            "PF\n4294967295 4294967295\n1\n",
            "PF\n18446744073709551615 18446744073709551615\n1\n",
            "PF\n32768 32768\n1\n",
        ] {
            assert!(decode_pfm(&pfm(header, &[1.0], true)).is_err(), "{header:?}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(512))]

        #[test]
        fn any_bytes_end_in_an_image_or_an_error(
            header in r"P[Ff]\n[0-9]{1,3} [0-9]{1,3}\n-?[0-9.e]{1,4}\n",
            data in proptest::collection::vec(any::<u8>(), 0..200),
        ) {
            let file: Vec<u8> = header.bytes().chain(data.iter().copied()).collect();
            if let Ok(image) = decode_pfm(&file) {
                prop_assert!(image.check_shape().is_ok());
                prop_assert!(image.pixels.len() * 4 <= data.len());
            }
            let _ = decode_pfm(&data);
            let _ = decode_exr(&data);
        }

        #[test]
        fn a_damaged_exr_never_panics(at in 0..400usize, value in any::<u8>()) {
            let mut file = exr_file(vec![("Y", halves(1.0))]);
            let at = at % file.len();
            file[at] = value;
            let _ = decode_exr(&file);
        }
    }
}
