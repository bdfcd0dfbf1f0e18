//! False colours: palettes in which equal steps of a value look about equally large.
//!
//! Viridis and Magma are those of Matplotlib (van der Walt and Smith 2015, CC0), by the polynomials that Zucker fitted
//! to them (<https://www.shadertoy.com/view/WlfXRN>, CC0). They get brighter from one end to the other, so that they
//! can be told apart without hues too. The diverging palette is made of straight lines in OKLab (Ottosson 2020).

use crate::image::film::srgb_encode;

/// A palette.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Palette {
    /// Dark violet, blue, green, yellow; nowhere black, which is free for "no value".
    Viridis,
    /// Black, violet, orange, light yellow; the palette of maps of FLIP.
    Magma,
    /// Blue, white in the middle, red; both ends are equally dark.
    Diverging,
}

/// The colour of pixels whose value is not finite, encoded sRGB: no palette has it.
pub const NOT_FINITE: [f32; 3] = [0.0, 1.0, 0.0];

/// Coefficients of red, green and blue, from the constant one on.
type Polynomial = [[f64; 3]; 7];

const VIRIDIS: Polynomial = [
    [0.277_727, 0.005_407, 0.334_100],
    [0.105_093, 1.404_614, 1.384_590],
    [-0.330_862, 0.214_848, 0.095_095],
    [-4.634_230, -5.799_101, -19.332_441],
    [6.228_270, 14.179_933, 56.690_553],
    [4.776_385, -13.745_145, -65.353_033],
    [-5.435_456, 4.645_853, 26.312_435],
];

const MAGMA: Polynomial = [
    [-0.002_136, -0.000_750, -0.005_386],
    [0.251_661, 0.677_523, 2.494_027],
    [8.353_717, -3.577_720, 0.314_468],
    [-27.668_733, 14.264_731, -13.649_213],
    [52.176_140, -27.943_606, 12.944_169],
    [-50.768_525, 29.046_583, 4.234_153],
    [18.655_705, -11.489_774, -5.601_962],
];

/// Lightness and chroma in OKLab of the colour between white and an end, and of the end.
const DIVERGING: [[f64; 2]; 2] = [[0.66, 0.15], [0.36, 0.12]];
/// Hues in OKLab of the end for negative and of that for positive values, in degrees.
const HUES: [f64; 2] = [255.0, 27.0];

impl Palette {
    /// Returns the colour at a place of the palette, encoded sRGB: 0 is its beginning, 1 its end. Places outside
    /// have the colour of the nearest end.
    #[must_use]
    pub fn color(self, at: f32) -> [f32; 3] {
        let at = f64::from(at.clamp(0.0, 1.0));
        match self {
            Self::Viridis => polynomial(&VIRIDIS, at),
            Self::Magma => polynomial(&MAGMA, at),
            Self::Diverging => diverging(2.0 * at - 1.0),
        }
    }

    /// As [`Palette::color`], with 8 bits a channel.
    #[must_use]
    pub fn bytes(self, at: f32) -> [u8; 3] {
        bytes(self.color(at))
    }
}

/// Returns encoded colours with 8 bits a channel.
#[must_use]
pub fn bytes(color: [f32; 3]) -> [u8; 3] {
    color.map(|channel| (255.0 * channel).round() as u8)
}

fn polynomial(coefficients: &Polynomial, at: f64) -> [f32; 3] {
    [0, 1, 2].map(|channel| {
        let value = coefficients.iter().rev().fold(0.0, |sum, term| sum * at + term[channel]);
        value.clamp(0.0, 1.0) as f32
    })
}

/// Returns the colour of a value from -1 to 1: white for 0.
fn diverging(value: f64) -> [f32; 3] {
    let [middle, end] = DIVERGING;
    // Lengths of both lines, so that the colours have the same distances on both.
    let first = f64::hypot(1.0 - middle[0], middle[1]);
    let second = f64::hypot(middle[0] - end[0], middle[1] - end[1]);
    let place = value.abs() * (first + second);
    let between = |from: [f64; 2], to: [f64; 2], t: f64| [0, 1].map(|i| from[i] * (1.0 - t) + to[i] * t);
    let [lightness, chroma] = if place < first {
        between([1.0, 0.0], middle, place / first)
    } else {
        between(middle, end, (place - first) / second)
    };
    let (sine, cosine) = HUES[usize::from(value > 0.0)].to_radians().sin_cos();
    from_oklab([lightness, chroma * cosine, chroma * sine])
}

/// Converts from OKLab to encoded sRGB, by the matrices of Ottosson's page (2020, in the public domain).
fn from_oklab([l, a, b]: [f64; 3]) -> [f32; 3] {
    let cones = [
        l + 0.396_337_777_4 * a + 0.215_803_757_3 * b,
        l - 0.105_561_345_8 * a - 0.063_854_172_8 * b,
        l - 0.089_484_177_5 * a - 1.291_485_548_0 * b,
    ];
    let [l, m, s] = cones.map(|cone| cone * cone * cone);
    let linear = [
        4.076_741_662_1 * l - 3.307_711_591_3 * m + 0.230_969_929_2 * s,
        -1.268_438_004_6 * l + 2.609_757_401_1 * m - 0.341_319_396_5 * s,
        -0.004_196_086_3 * l - 0.703_418_614_7 * m + 1.707_614_701_0 * s,
    ];
    linear.map(|channel| srgb_encode(channel.clamp(0.0, 1.0) as f32))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::film::{luminance, srgb_decode};

    fn to_oklab(color: [f32; 3]) -> [f64; 3] {
        let [r, g, b] = color.map(|channel| f64::from(srgb_decode(channel)));
        let l = (0.412_221_470_8 * r + 0.536_332_536_3 * g + 0.051_445_992_9 * b).cbrt();
        let m = (0.211_903_498_2 * r + 0.680_699_545_1 * g + 0.107_396_956_6 * b).cbrt();
        let s = (0.088_302_461_9 * r + 0.281_718_837_6 * g + 0.629_978_700_5 * b).cbrt();
        [
            0.210_454_255_3 * l + 0.793_617_785_0 * m - 0.004_072_046_8 * s,
            1.977_998_495_1 * l - 2.428_592_205_0 * m + 0.450_593_709_9 * s,
            0.025_904_037_1 * l + 0.782_771_766_2 * m - 0.808_675_766_0 * s,
        ]
    }

    fn brightness(palette: Palette, at: f32) -> f32 {
        luminance(palette.color(at).map(srgb_decode))
    }

    #[test]
    fn palettes_get_brighter_along_the_scale() {
        for palette in [Palette::Viridis, Palette::Magma] {
            for step in 1_u8..=100 {
                let [before, after] = [step - 1, step].map(|step| brightness(palette, f32::from(step) / 100.0));
                assert!(after > before, "{palette:?}: {step} %");
            }
        }
        assert!(brightness(Palette::Viridis, 0.0) > 0.0, "black is for no value");
        assert_eq!(Palette::Magma.bytes(0.0), [0; 3]);
    }

    #[test]
    fn palettes_are_those_that_are_published() {
        // Matplotlib's tables at 0, 0.5 and 1. The polynomials are off by less than 0.02.
        for (palette, table) in [
            (Palette::Viridis, [[68, 1, 84], [33, 145, 140], [253, 231, 37]]),
            (Palette::Magma, [[0, 0, 4], [183, 55, 121], [252, 253, 191]]),
        ] {
            for (at, expected) in [0.0, 0.5, 1.0].into_iter().zip(table) {
                let found = palette.bytes(at);
                assert!(found.iter().zip(expected).all(|(a, b)| a.abs_diff(b) <= 5), "{palette:?} {at}: {found:?}");
            }
        }
    }

    /// Steps in OKLab are between 0.75 and 1.4 of their mean: Viridis and Magma were made even in another colour
    /// space, and Magma leaves black by a larger step.
    #[test]
    fn equal_steps_look_about_equal() {
        for palette in [Palette::Viridis, Palette::Magma, Palette::Diverging] {
            let colors: Vec<[f64; 3]> = (1_u8..=16).map(|i| to_oklab(palette.color(f32::from(i) / 16.0))).collect();
            let step = |pair: &[[f64; 3]]| (0..3).map(|i| (pair[0][i] - pair[1][i]).powi(2)).sum::<f64>().sqrt();
            let steps: Vec<f64> = colors.windows(2).map(step).collect();
            let mean = steps.iter().sum::<f64>() / steps.len() as f64;
            assert!(steps.iter().all(|step| (0.75..1.4).contains(&(step / mean))), "{palette:?}: {steps:?}");
        }
    }

    #[test]
    fn the_diverging_palette_is_white_in_the_middle_and_even() {
        assert_eq!(Palette::Diverging.bytes(0.5), [255; 3]);
        let [[r, _, b], [red, _, blue]] = [0.0, 1.0].map(|at| Palette::Diverging.bytes(at));
        assert!(b > 2 * r && red > 2 * blue, "{r} {b}, {red} {blue}");
        for step in 1_u8..=50 {
            let [below, above] = [-1.0, 1.0].map(|sign| 0.5 + sign * f32::from(step) / 100.0);
            let [below, above] = [below, above].map(|at| to_oklab(Palette::Diverging.color(at))[0]);
            // A little of blue's green is outside of what sRGB can show.
            assert!((below - above).abs() < 0.005, "{step}: {below} {above}");
        }
    }
}
