use ::exr::meta::attribute::Chromaticities;
use ::exr::prelude::*;
use proptest::prelude::{ProptestConfig, any, prop_assert, proptest};

use std::io::Cursor;

use image::DynamicImage;

use super::*;
use crate::image::film::{Window, srgb_decode};

/// The channels, three pixels wide and two high, at a data window that lies
/// partly outside the display window.
fn exr_file(channels: Vec<(&str, FlatSamples)>) -> Vec<u8> {
    exr_file_with(channels, None)
}

fn exr_file_with(channels: Vec<(&str, FlatSamples)>, chromaticities: Option<Chromaticities>) -> Vec<u8> {
    let list = channels.into_iter().map(|(name, samples)| AnyChannel::new(name, samples));
    let attributes = LayerAttributes { layer_position: Vec2(-1, 5), ..LayerAttributes::default() };
    let channels = AnyChannels::sort(list.collect());
    let layer = Layer::new((3, 2), attributes, Encoding::FAST_LOSSLESS, channels);
    let mut image = ::exr::prelude::Image::from_layer(layer);
    image.attributes.display_window = IntegerBounds::new((0, 0), (64, 64));
    image.attributes.chromaticities = chromaticities;
    let mut file = Cursor::new(Vec::new());
    image.write().to_buffered(&mut file).unwrap();
    file.into_inner()
}

fn halves(first: f32) -> FlatSamples {
    let values = (0..6u8).map(|i| f16::from_f32(first + f32::from(i)));
    FlatSamples::F16(values.collect())
}

type Decoded<T> = std::result::Result<T, String>;

/// What a decoder makes of a file with the default budget.
fn with<T>(decode: impl Fn(&Source) -> Decoded<T>, bytes: &[u8], transfer: Transfer, of: Use) -> Decoded<T> {
    decode(&Source { bytes, transfer, of, budget: &Budget::default() })
}

fn decode_exr_as(file: &[u8], of: Use) -> Decoded<super::Layers> {
    with(super::exr::decode, file, Transfer::Srgb, of)
}

fn decode_exr(file: &[u8]) -> Decoded<super::Layers> {
    decode_exr_as(file, Use::Light)
}

fn decode_hdr(file: &[u8]) -> Decoded<super::Image> {
    with(super::hdr::decode, file, Transfer::Srgb, Use::Light)
}

fn decode_pfm(file: &[u8]) -> Decoded<super::Image> {
    with(super::decode_pfm, file, Transfer::Srgb, Use::Light)
}

fn decode_integers(file: &[u8], format: ImageFormat, transfer: Transfer) -> Decoded<super::Layers> {
    with(|source| super::decode_integers(source, format), file, transfer, Use::Light)
}

fn assert_near(pixel: [f32; 3], expected: [f32; 3]) {
    let is_near = pixel.iter().zip(expected).all(|(a, b)| (a - b).abs() < 2e-3);
    assert!(is_near, "{pixel:?}, not {expected:?}");
}

/// Three channels of one value each.
fn colour(names: [&'static str; 3], values: [f32; 3]) -> Vec<(&'static str, FlatSamples)> {
    let mut channels: Vec<_> = names.into_iter().zip(values).map(|(n, v)| (n, FlatSamples::F32(vec![v; 6]))).collect();
    channels.sort_by_key(|(name, _)| *name);
    channels
}

/// By the matrix of IEC 61966-2-1.
#[test]
fn xyz_is_converted_as_it_is() {
    for of in [Use::Light, Use::Reflectance] {
        let file = exr_file(colour(["X", "Y", "Z"], [0.6, 0.3, 0.1]));
        let pixel = decode_exr_as(&file, of).unwrap().image.pixels[0];
        assert_near(pixel, [1.4333, -0.0145, 0.0779]);
        let white = exr_file(colour(["X", "Y", "Z"], [0.9505, 1.0, 1.089]));
        assert_near(decode_exr_as(&white, of).unwrap().image.pixels[5], [1.0; 3]);
    }
}

fn aces() -> Chromaticities {
    let [red, green, blue] = [Vec2(0.7347, 0.2653), Vec2(0.0, 1.0), Vec2(0.0001, -0.077)];
    Chromaticities { red, green, blue, white: Vec2(0.32168, 0.33767) }
}

/// The matrix of AP0 to Rec. 709 with Bradford's adaptation is that of the Academy's CTL.
#[test]
fn chromaticities_count() {
    let names = ["R", "G", "B"];
    let decode = |value: [f32; 3], chromaticities, of| {
        decode_exr_as(&exr_file_with(colour(names, value), Some(chromaticities)), of).unwrap().image.pixels[0]
    };
    let academy = [[2.5217, -0.2765, -0.0152], [-1.1341, 1.3727, -0.1530], [-0.3876, -0.0963, 1.1683]];
    for (unit, expected) in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].into_iter().zip(academy) {
        assert_near(decode(unit, aces(), Use::Reflectance), expected);
    }
    assert_near(decode([1.0; 3], aces(), Use::Reflectance), [1.0; 3]);
    // The same light is a little warmer than D65.
    let light = decode([1.0; 3], aces(), Use::Light);
    assert!(light[0] > 1.03 && light[2] < 0.95, "{light:?}");
    // What is sRGB already keeps its bits.
    let srgb = Chromaticities {
        red: Vec2(0.64, 0.33),
        green: Vec2(0.3, 0.6),
        blue: Vec2(0.15, 0.06),
        white: Vec2(0.3127, 0.329),
    };
    assert_eq!(decode([0.1, 0.2, 0.3], srgb, Use::Light), [0.1, 0.2, 0.3]);
    let none = Chromaticities { green: Vec2(0.64, 0.33), ..srgb };
    let error = decode_exr_as(&exr_file_with(colour(names, [0.1; 3]), Some(none)), Use::Light).unwrap_err();
    assert!(error.contains("make no colour space"), "{error}");
    // Grey has no primaries.
    let grey = exr_file_with(vec![("Y", halves(0.5))], Some(aces()));
    assert_eq!(decode_exr(&grey).unwrap().image.pixels[0], [0.5; 3]);
}

#[test]
fn other_channels_are_an_image_where_there_is_no_doubt() {
    let grey = |name: &'static str| decode_exr(&exr_file(vec![(name, halves(1.0))])).unwrap().image.pixels[1];
    for name in ["R", "height", "A", "mask.Z"] {
        assert_eq!(grey(name), [2.0; 3], "{name}");
    }
    let mut layers = colour(["beauty.R", "beauty.G", "beauty.B"], [0.1, 0.2, 0.3]);
    assert_eq!(decode_exr(&exr_file(layers.clone())).unwrap().image.pixels[1], [0.1, 0.2, 0.3]);
    layers.extend(colour(["albedo.R", "albedo.G", "albedo.B"], [0.1, 0.2, 0.3]));
    let error = decode_exr(&exr_file(layers)).unwrap_err();
    assert_eq!(error, "its layers are albedo, beauty: which of them is the image is not said");
    let chroma = colour(["Y", "RY", "BY"], [0.1; 3]);
    assert_eq!(decode_exr(&exr_file(chroma)).unwrap_err(), "its channels are luminance and chroma: Y, RY, BY");
}

#[test]
fn an_exr_says_where_it_lies() {
    let layers = decode_exr(&exr_file(vec![("Y", halves(1.0))])).unwrap();
    assert_eq!(layers.window, Some(Window { first: [-1, 5], full: [64, 64] }));
}

/// A Radiance file of one pixel, not compressed.
fn radiance(header: &str, pixel: [u8; 4]) -> Vec<u8> {
    let mut file = header.as_bytes().to_vec();
    file.extend(b"-Y 1 +X 1\n");
    file.extend(pixel);
    file
}

#[test]
fn radiance_files_of_all_kinds_are_read() {
    let decode = |header: &str| decode_hdr(&radiance(header, [153, 77, 26, 128])).map(|image| image.pixels[0]);
    let [r, g, b] = [153.0, 77.0, 26.0].map(|value| value / 256.0);
    for header in [
        "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n",
        "#?RGBE\nFORMAT=32-bit_rle_rgbe\n\n",
        "#?RGBE\n# by hand\nEXPOSURE=2\nFORMAT=32-bit_rle_rgbe\n\n",
        "#?RADIANCE\n\n",
        "#?RADIANCE\nPRIMARIES=0.64 0.33 0.3 0.6 0.15 0.06 0.3127 0.329\n\n",
    ] {
        assert_eq!(decode(header).unwrap(), [r, g, b], "{header:?}");
    }
    // The matrix of IEC 61966-2-1 again.
    let xyz = [
        3.2406 * r - 1.5372 * g - 0.4986 * b,
        -0.9689 * r + 1.8758 * g + 0.0415 * b,
        0.0557 * r - 0.204 * g + 1.057 * b,
    ];
    assert_near(decode("#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n").unwrap(), xyz);
    let wide = decode("#?RGBE\nPRIMARIES=0.708 0.292 0.17 0.797 0.131 0.046 0.3127 0.329\n\n").unwrap();
    assert_near(
        wide,
        [
            1.6605 * r - 0.5876 * g - 0.0728 * b,
            -0.1246 * r + 1.1329 * g - 0.0083 * b,
            -0.0182 * r - 0.1006 * g + 1.1187 * b,
        ],
    );
    for (header, expected) in [
        ("#?LIGHT\n\n", "begins neither with #?RADIANCE nor"),
        ("#?RGBE\nFORMAT=32-bit_rle_yuv\n\n", "its format is \"32-bit_rle_yuv\""),
        ("#?RGBE\nPRIMARIES=1 2\n\n", "not eight numbers"),
        ("#?RGBE\nFORMAT=32-bit_rle_rgbe\n", "its header has no end"),
    ] {
        let error = decode(header).unwrap_err();
        assert!(error.contains(expected), "{error}");
    }
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

#[test]
fn sizes_are_checked_before_pixels_are_decoded() {
    let exr = exr_file(colour(["R", "G", "B"], [0.5; 3]));
    let mut png = Cursor::new(Vec::new());
    image::GrayImage::new(3, 2).write_to(&mut png, ImageFormat::Png).unwrap();
    let mut pfm = b"PF\n3 2\n-1\n".to_vec();
    pfm.resize(pfm.len() + 72, 0);
    let decoders: [(Decode, &[u8]); 3] = [
        (super::exr::decode, &exr),
        (|source| super::decode_integers(source, ImageFormat::Png), png.get_ref()),
        (|source| super::decode_pfm(source).map(opaque), &pfm),
    ];
    for (decode, bytes) in decoders {
        let decode_within =
            |limit| decode(&Source { bytes, transfer: Transfer::Srgb, of: Use::Light, budget: &Budget::new(limit) });
        assert!(decode_within(1000).is_ok());
        let error = decode_within(50).unwrap_err();
        assert!(error.contains("for its 3x") && error.contains("memory"), "{error}");
    }
}
