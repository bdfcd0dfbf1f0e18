//! tone_map: the pixels of a window.

use goblet::image::film::{Image, LUMINANCE, into_gamut, picture, srgb_encode};
use goblet::kernels::{CURVE_ACES, CURVE_AGX, CURVE_LINEAR, CURVE_SRGB, Specialization, ToneMap, ToneMapPush};

use crate::support;

/// The window's pixels for an image of these colours, as bytes from the lowest.
fn show(image: [u32; 2], colors: &[[f32; 3]], change: impl FnOnce(&mut ToneMapPush)) -> Vec<[u8; 4]> {
    let device = support::device();
    let mut push = ToneMapPush {
        luminance: LUMINANCE.map(|weight| weight as f32),
        exposure: 1.0,
        window: image,
        image,
        origin: [0.0; 2],
        per_pixel: [1.0; 2],
        curve: CURVE_SRGB,
        bgra: 0,
        nearest: 0,
        pad0: 0,
    };
    change(&mut push);
    let colors: Vec<[f32; 4]> = colors.iter().map(|[r, g, b]| [*r, *g, *b, 0.0]).collect();
    let shown = device.upload_texels("shown", &colors).expect("texels");
    let count = push.window.map(u64::from).iter().product();
    let pixels = device.buffer("pixels", count).expect("a buffer");
    let kernel = ToneMap { shown: &shown, pixels: &pixels };
    let pass = device.pass(&kernel, &Specialization::DECLARED, 64).expect("a pass");
    let mut frame = device.frame().expect("a frame");
    frame.dispatch(&pass, push, count);
    frame.run().expect("a run");
    let words = device.read(&pixels).expect("the pixels");
    support::assert_silent(&device);
    words.into_iter().map(u32::to_le_bytes).collect()
}

/// From black to far beyond white.
fn ramp() -> Vec<[f32; 3]> {
    let value = |i: u16| (f32::from(i) / 150.0 - 8.0).exp2();
    (0..2000).map(|i| [value(i), value(i / 2), value(1999 - i)]).collect()
}

/// Fails unless all bytes are within one of what an f64 twin says.
fn assert_curve(curve: u32, exposure: f32, twin: impl Fn([f64; 3]) -> [f64; 3]) {
    let colors = ramp();
    let bytes = show([50, 40], &colors, |push| (push.curve, push.exposure) = (curve, exposure));
    let mut differing = 0;
    for (color, bytes) in colors.iter().zip(bytes) {
        let expected = twin(color.map(|value| f64::from(value * exposure)));
        for channel in 0..3 {
            let exact = expected[channel].clamp(0.0, 1.0) * 255.0;
            assert!((f64::from(bytes[channel]) - exact).abs() < 0.51, "{curve}: {color:?} is {bytes:?}, not {exact}");
            differing += u32::from(f64::from(bytes[channel]) != exact.round());
        }
        assert_eq!(bytes[3], 255);
    }
    assert!(differing < 30, "{differing} bytes of 6000 are rounded the other way");
}

#[test]
fn srgb_is_that_of_a_png() {
    let encode = |value: f64| f64::from(srgb_encode(value.min(1.0) as f32));
    assert_curve(CURVE_SRGB, 1.0, |color| color.map(encode));
    assert_curve(CURVE_SRGB, 0.25, |color| color.map(encode));
    assert_curve(CURVE_LINEAR, 1.0, |color| color);
}

#[test]
fn film_curves_are_as_published() {
    let aces =
        |v: f64| f64::from(srgb_encode(((v * (2.51 * v + 0.03) / (v * (2.43 * v + 0.59) + 0.14)) as f32).min(1.0)));
    assert_curve(CURVE_ACES, 1.0, |color| color.map(aces));
    let rows = |m: [[f64; 3]; 3], v: [f64; 3]| m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2]);
    let inset = [
        [0.842479062253094, 0.0784335999999992, 0.0792237451477643],
        [0.0423282422610123, 0.878468636469772, 0.0791661274605434],
        [0.0423756549057051, 0.0784336, 0.879142973793104],
    ];
    let outset = [
        [1.19687900512017, -0.0980208811401368, -0.0990297440797205],
        [-0.0528968517574562, 1.15190312990417, -0.0989611768448433],
        [-0.0529716355144438, -0.0980434501171241, 1.15107367264116],
    ];
    let sigmoid = |value: f64| {
        let x = (value.max(1e-10).log2().clamp(-12.47393, 4.026069) + 12.47393) / (12.47393 + 4.026069);
        let powers = [-0.00232, 0.1191, 0.4298, -6.868, 31.96, -40.14, 15.5];
        powers.iter().rev().fold(0.0, |sum, power| sum * x + power)
    };
    assert_curve(CURVE_AGX, 1.0, |color| rows(outset, rows(inset, color).map(sigmoid)));
}

/// Both hold for every curve of this kind, whatever its numbers are.
#[test]
fn agx_keeps_grey_grey_and_fades_bright_colours() {
    let grey: Vec<[f32; 3]> = (0..32).map(|i| [f32::from(i as u8).exp2() * 1e-3; 3]).collect();
    let bytes = show([32, 1], &grey, |push| push.curve = CURVE_AGX);
    assert!(bytes.is_sorted(), "brighter is brighter");
    assert!(bytes.iter().all(|[r, g, b, _]| r.abs_diff(*g) <= 1 && g.abs_diff(*b) <= 1), "{bytes:?}");
    let [red] = show([1, 1], &[[500.0, 0.5, 0.5]], |push| push.curve = CURVE_AGX)[..] else { panic!("a pixel") };
    assert!(red[1] > 100, "{red:?}");
}

/// Colours outside of the gamut of sRGB: one or two channels are negative, by much or by little.
fn outside() -> Vec<[f32; 3]> {
    let below = |i: u16| -(f32::from(i % 83) / 8.0 - 9.0).exp2();
    let signed = |i: u16, [r, g, b]: [f32; 3]| match i % 6 {
        0 => [below(i), g, b],
        1 => [r, below(i), b],
        2 => [r, g, below(i)],
        3 => [below(i), g, below(i + 1)],
        4 => [below(i), below(i + 1), b],
        _ => [r, below(i), below(i + 1)],
    };
    (0..).zip(ramp()).map(|(i, color)| signed(i, color)).collect()
}

/// Bytes differ by the roundings of f32 alone: a luminance of channels up to 8 in size has an error of 1e-6, which at
/// most 14 times as much of a channel follows, and black has a slope of 12.92: 0.05 of a byte.
#[test]
fn colors_outside_of_the_gamut_are_those_of_a_png() {
    let colors = outside();
    let expected = picture(&Image::from_pixels(50, 40, colors.clone()).expect("an image"));
    let bytes = show([50, 40], &colors, |_| ());
    let pairs = || bytes.iter().flat_map(|bytes| &bytes[..3]).zip(&expected);
    assert!(pairs().all(|(found, expected)| found.abs_diff(*expected) <= 1));
    let differing = pairs().filter(|(found, expected)| found != expected).count();
    assert!(differing < 30, "{differing} bytes of 6000 are rounded the other way");
    let lit = expected.as_chunks::<3>().0.iter().filter(|bytes| **bytes != [0; 3]).count();
    assert!((1000..2000).contains(&lit), "{lit} of the colours have a luminance");
}

/// The exposure comes after the map, and so does the curve.
#[test]
fn every_curve_shows_colors_of_the_gamut() {
    let colors = outside();
    let mapped: Vec<_> = colors.iter().map(|color| into_gamut(*color)).collect();
    for curve in [CURVE_LINEAR, CURVE_SRGB, CURVE_ACES, CURVE_AGX] {
        let [found, expected] =
            [&colors, &mapped].map(|colors| show([50, 40], colors, |push| (push.curve, push.exposure) = (curve, 0.5)));
        let pairs = found.iter().flatten().zip(expected.iter().flatten());
        assert!(pairs.into_iter().all(|(found, expected)| found.abs_diff(*expected) <= 1), "{curve}");
    }
}

/// In the middle between them there is a colour of the gamut.
#[test]
fn colors_are_interpolated_before_they_are_mapped() {
    let colors = [[1.0, -0.25, 0.0], [-0.25, 1.0, 0.5]];
    let bytes = show([2, 1], &colors, |push| {
        (push.window, push.per_pixel, push.curve) = ([4, 1], [0.5, 1.0], CURVE_LINEAR);
    });
    for (bytes, share) in bytes.iter().zip([0.0, 0.25, 0.75, 1.0]) {
        let mean = [0, 1, 2].map(|channel| colors[0][channel] * (1.0 - share) + colors[1][channel] * share);
        let exact = into_gamut(mean).map(|value| value * 255.0);
        let near = exact.iter().zip(bytes).all(|(exact, byte)| (exact - f32::from(*byte)).abs() < 0.51);
        assert!(near, "{share}: {bytes:?} {exact:?}");
    }
}

#[test]
fn strange_colors_are_those_of_a_png() {
    let strange = [f32::NAN, f32::NEG_INFINITY, -1.0, 0.0, 0.25, f32::INFINITY];
    let colors: Vec<_> = (0..216).map(|i| [strange[i / 36], strange[i / 6 % 6], strange[i % 6]]).collect();
    let expected = picture(&Image::from_pixels(36, 6, colors.clone()).expect("an image"));
    let bytes = show([36, 6], &colors, |_| ());
    for ((color, found), expected) in colors.iter().zip(&bytes).zip(expected.as_chunks::<3>().0) {
        assert_eq!(found[..3], *expected, "{color:?}");
    }
}

#[test]
fn what_is_no_number_is_black_and_stays_where_it_is() {
    let colors = [[f32::NAN, 0.5, 1.0], [f32::INFINITY, -1.0, 1.0], [0.0, 1.0, 0.0]];
    for curve in [CURVE_LINEAR, CURVE_SRGB, CURVE_ACES, CURVE_AGX] {
        let bytes = show([3, 1], &colors, |push| push.curve = curve);
        assert!(bytes[1][0] > 200, "{curve}: {bytes:?}");
        if curve == CURVE_LINEAR {
            assert_eq!(bytes, [[0, 128, 255, 255], [255, 0, 255, 255], [0, 255, 0, 255]]);
        }
    }
}

#[test]
fn an_image_of_another_size_is_interpolated_in_the_middle() {
    let colors = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]];
    let bytes = show([2, 1], &colors, |push| {
        (push.window, push.origin, push.per_pixel) = ([10, 4], [1.0, 0.0], [0.25; 2]);
        (push.curve, push.bgra) = (CURVE_LINEAR, 1);
    });
    let red: Vec<u8> = bytes[..10].iter().map(|bytes| bytes[2]).collect();
    assert_eq!(red[1..9], [0, 0, 32, 96, 159, 223, 255, 255]);
    assert!([0, 9].into_iter().all(|x| bytes[x] == [5, 5, 5, 255]), "around it: {bytes:?}");
    assert_eq!(bytes[..10], bytes[30..40]);
}

/// Each pixel is a square of its own colour, wherever the image begins.
#[test]
fn enlarged_pixels_are_squares() {
    let colors = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let bytes = show([2, 2], &colors, |push| {
        (push.window, push.origin, push.per_pixel) = ([10, 9], [1.0, -2.0], [0.25; 2]);
        (push.curve, push.nearest) = (CURVE_LINEAR, 1);
    });
    for (index, found) in bytes.iter().enumerate() {
        let (x, y) = (index as i32 % 10 - 1, index as i32 / 10 + 2);
        let is_inside = (0..8).contains(&x) && (0..8).contains(&y);
        let color = colors[if is_inside { (y / 4 * 2 + x / 4) as usize } else { 0 }].map(|value| value as u8 * 255);
        let expected = if is_inside { color } else { [5; 3] };
        assert_eq!(found[..3], expected, "{x} {y}");
    }
}
