//! Tests of image files: their content, and the replacement of existing files.

use std::fs;

use exr::meta::attribute::AttributeValue;
use exr::prelude::Text;

use super::*;
use crate::base::input::Budget;
use crate::image::film::{luminance, srgb_decode, srgb_encode};

fn extreme_image() -> Image {
    let pixels = vec![
        [0.0, -0.0, f32::MIN_POSITIVE],
        [1e-40, f32::MAX, -3.5],
        [f32::INFINITY, f32::NEG_INFINITY, f32::from_bits(0x7fc0_1234)],
        [0.25, 0.5, 0.75],
        [1.0, 2.0, 3.0],
        [0.1, 0.2, 0.3],
    ];
    Image::from_pixels(3, 2, pixels).unwrap()
}

fn bits(image: &Image) -> Vec<[u32; 3]> {
    image.pixels.iter().map(|p| p.map(f32::to_bits)).collect()
}

fn pairs(list: &[(&str, &str)]) -> Vec<(String, Attribute)> {
    list.iter().map(|&(key, value)| (key.to_owned(), Attribute::of_text(value))).collect()
}

#[test]
fn exr_keeps_every_bit_and_the_metadata() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("x.EXR");
    let image = extreme_image();
    let mut metadata = pairs(&[("scene", "Kelch ü 杯"), ("seed", "4294967295"), ("count", "-7"), ("alpha", "0.5")]);
    let matrix = [[1.0, 2.0, 3.0, 4.0], [5.0, 6.0, 7.0, 8.0], [9.0, 10.0, 11.0, 12.0], [0.0, 0.0, 0.0, 1.0]];
    metadata.push(("worldToCamera".to_owned(), Attribute::Matrix(matrix)));
    metadata.push(("renderTimeSeconds".to_owned(), Attribute::Float(1.5)));
    write(&path, &image, &metadata).unwrap();
    let back = read(&path).unwrap();
    assert_eq!((back.width, back.height), (3, 2));
    assert_eq!(bits(&back), bits(&image));

    let headers = exr::meta::MetaData::read_from_file(&path, true).unwrap().headers;
    let stored = |key: &str| headers[0].own_attributes.other[&Text::from(key)].clone();
    // The format has no unsigned integers, and none of more than 32 bits.
    assert_eq!(stored("seed"), AttributeValue::F64(4_294_967_295.0));
    assert_eq!((stored("count"), stored("alpha")), (AttributeValue::I32(-7), AttributeValue::F64(0.5)));
    assert_eq!(stored("renderTimeSeconds"), AttributeValue::F32(1.5));
    assert_eq!(headers[0].own_attributes.world_to_camera.unwrap()[..8], [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]);
    let chromaticities = headers[0].shared_attributes.chromaticities.unwrap();
    assert_eq!((chromaticities.red, chromaticities.white), (Vec2(0.64, 0.33), Vec2(0.3127, 0.3290)));
    let scene = Text::from_slice_unchecked("Kelch ü 杯".as_bytes());
    assert_eq!(stored("scene"), AttributeValue::Text(scene));
}

#[test]
fn the_same_image_gives_the_same_bytes() {
    let keys: Vec<_> = (0..12).map(|i| (format!("key{i}"), Attribute::Integer(i))).collect();
    let first = encode_exr(&extreme_image(), &Window::whole([3, 2]), &[], &keys).unwrap();
    for _ in 0..8 {
        assert!(encode_exr(&extreme_image(), &Window::whole([3, 2]), &[], &keys).unwrap() == first);
    }
}

#[test]
fn an_exr_of_a_part_says_which_part() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("x.exr");
    let window = Window { first: [5, 7], full: [64, 48] };
    write_part(&path, &extreme_image(), &window, &[], &[]).unwrap();
    let header = exr::meta::MetaData::read_from_file(&path, true).unwrap().headers.remove(0);
    assert_eq!(header.own_attributes.layer_position, Vec2(5, 7));
    assert_eq!(header.layer_size, Vec2(3, 2));
    assert_eq!(header.shared_attributes.display_window, IntegerBounds::new((0, 0), (64, 48)));
    let back = read_layers(&path, Transfer::Srgb, Use::Light, &Budget::default()).unwrap();
    assert_eq!((bits(&back.image), back.window), (bits(&extreme_image()), Some(window)));
}

#[test]
fn metadata_that_would_break_the_header_is_refused() {
    let long = "k".repeat(256);
    for keys in [&[""][..], &["a\0b"], &[&long], &["a", "a"], &["compression"]] {
        let metadata: Vec<_> = keys.iter().map(|&key| (key, "v")).collect();
        assert!(encode_exr(&extreme_image(), &Window::whole([3, 2]), &[], &pairs(&metadata)).is_err(), "{keys:?}");
    }
}

#[test]
fn png_keeps_what_eight_bits_of_srgb_can() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("x.png");
    let ramp = (0..=500u16).map(|i| [f32::from(i) / 500.0; 3]).collect();
    let image = Image::from_pixels(501, 1, ramp).unwrap();
    write(&path, &image, &[]).unwrap();
    for (back, original) in read(&path).unwrap().pixels.iter().zip(&image.pixels) {
        let error = srgb_encode(back[1]) - srgb_encode(original[1]);
        assert!(error.abs() <= 0.5 / 255.0 + 1e-6, "{back:?} {original:?}");
    }
}

#[test]
fn png_clamps_maps_to_the_gamut_and_shows_nan_as_black() {
    let outside = [0.5, -0.1, 0.2];
    let pixels = vec![[f32::NAN, f32::INFINITY, 0.0], [7.0, 1.0, 0.0], [-1.0; 3], outside];
    let image = Image::from_pixels(4, 1, pixels).unwrap();
    let file = encode_png(&image).unwrap();
    let back = image::load_from_memory(&file).unwrap().into_rgb8();
    let [first @ .., red, green, blue] = &back.as_raw()[..] else { panic!("four pixels") };
    assert_eq!(first, [0, 255, 0, 255, 255, 0, 0, 0, 0]);
    let shown = [*red, *green, *blue].map(|byte| srgb_decode(f32::from(byte) / 255.0));
    // Half a byte of a channel is 0.003 at most.
    assert!(*green == 0 && (luminance(shown) - luminance(outside)).abs() < 0.003, "{red} {green} {blue}");
}

#[test]
fn an_image_of_the_wrong_shape_is_an_error() {
    let mut image = extreme_image();
    image.pixels.pop();
    let directory = tempfile::tempdir().unwrap();
    for name in ["x.exr", "x.png"] {
        let result = write(&directory.path().join(name), &image, &[]);
        assert!(matches!(result, Err(ImageError::Encode { .. })), "{result:?}");
    }
}

#[test]
fn writing_replaces_a_file_and_leaves_nothing_else() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("x.exr");
    write(&path, &Image::new(1, 1), &[]).unwrap();
    check_writable(&path).unwrap();
    write(&path, &extreme_image(), &[]).unwrap();
    assert_eq!(read(&path).unwrap().width, 3);
    assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 1);
}

#[test]
fn an_output_that_cannot_be_written_is_refused_before_the_render() {
    let directory = tempfile::tempdir().unwrap();
    let blocked = directory.path().join("blocked.exr");
    fs::create_dir(&blocked).unwrap();
    let read_only = directory.path().join("kept.png");
    write(&read_only, &Image::new(1, 1), &[]).unwrap();
    let mut permissions = fs::metadata(&read_only).unwrap().permissions();
    permissions.set_readonly(true);
    fs::set_permissions(&read_only, permissions).unwrap();

    let missing = directory.path().join("missing/x.exr");
    for path in [missing, blocked, read_only] {
        let error = check_writable(&path).unwrap_err();
        assert!(matches!(error, ImageError::Write { .. }), "{error}");
    }
    let error = check_writable(&directory.path().join("x.tiff")).unwrap_err();
    assert!(error.to_string().ends_with("supported are .exr and .png"));
    check_writable(&directory.path().join("new.png")).unwrap();
    assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 2);
}
