//! The white balance of a film, from a colour temperature, as pbrt reads it.

use glam::DVec2;

use super::{NEW_KELVIN, blackbody, daylight_chromaticity, wavelengths};
use crate::base::color;
use crate::scene::model::{Rgb, WhiteBalance};

/// The lowest colour temperature of daylight, K.
const LOWEST_DAYLIGHT: f64 = 4000.0;

/// Returns the white balance that makes light of a colour temperature in K white.
pub(in crate::scene) fn of_temperature(kelvin: f64) -> WhiteBalance {
    WhiteBalance { kelvin, matrix: color::white_balance(white(kelvin)) }
}

/// Returns the chromaticity of pbrt's illuminant of a temperature in K: daylight from 4000 K, below that a black
/// body. The temperature is nominal, on the scale of the CIE's illuminants: D50 has 5000 K.
fn white(nominal: f64) -> DVec2 {
    let kelvin = nominal * NEW_KELVIN;
    if kelvin >= LOWEST_DAYLIGHT {
        return daylight_chromaticity(kelvin);
    }
    let xyz: Rgb = wavelengths().map(|(nm, xyz)| xyz * blackbody(kelvin, nm)).sum();
    DVec2::new(xyz.x, xyz.y) / xyz.element_sum()
}

#[cfg(test)]
mod tests {
    use glam::{DMat3, DVec3};

    use super::*;

    /// Published matrices between linear sRGB and XYZ (IEC 61966-2-1), in rows.
    const XYZ_FROM_RGB: [[f64; 3]; 3] = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]];
    const RGB_FROM_XYZ: [[f64; 3]; 3] =
        [[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]];
    /// Bradford's matrix and its inverse (Lindbloom, "Chromatic adaptation"), in rows.
    const CONES: [[f64; 3]; 3] = [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]];
    const FROM_CONES: [[f64; 3]; 3] = [
        [0.986_992_9, -0.147_054_3, 0.159_962_7],
        [0.432_305_3, 0.518_360_3, 0.049_291_2],
        [-0.008_528_7, 0.040_042_8, 0.968_486_7],
    ];

    fn apply(rows: [[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
        rows.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
    }

    /// Returns a colour of linear sRGB after the white balance, from the chromaticity of the light.
    fn balanced([x, y]: [f64; 2], rgb: [f64; 3]) -> [f64; 3] {
        let cones = |[x, y]: [f64; 2]| apply(CONES, [x / y, 1.0, (1.0 - x - y) / y]);
        let (from, to) = (cones([x, y]), cones([0.3127, 0.3290]));
        let seen = apply(CONES, apply(XYZ_FROM_RGB, rgb));
        let adapted = [0, 1, 2].map(|cone| seen[cone] * to[cone] / from[cone]);
        apply(RGB_FROM_XYZ, apply(FROM_CONES, adapted))
    }

    /// The white of a black body from 2222 K to 4000 K (Kim and others 2002, US patent 7024034).
    fn planckian(kelvin: f64) -> [f64; 2] {
        let t = 1e3 / kelvin;
        let x = -0.266_123_9 * t.powi(3) - 0.234_358_9 * t.powi(2) + 0.877_695_6 * t + 0.179_910;
        [x, -0.954_947_6 * x.powi(3) - 1.374_185_93 * x.powi(2) + 2.091_370_15 * x - 0.167_488_67]
    }

    fn assert_near(kelvin: f64, found: DVec3, expected: [f64; 3], tolerance: f64) {
        assert!((found - DVec3::from(expected)).abs().max_element() < tolerance, "{kelvin} K: {found} {expected:?}");
    }

    #[test]
    fn matrices_are_those_of_published_formulas() {
        // CIE D50 and D75; black bodies. The formula of the black body's white is good to 0.0005.
        let cases = [
            (5000.0, [0.34567, 0.35850], 0.004),
            (7500.0, [0.29902, 0.31485], 0.004),
            (3000.0, planckian(3000.0 * 1.4388 / 1.4380), 0.012),
            (2500.0, planckian(2500.0 * 1.4388 / 1.4380), 0.03),
        ];
        for (kelvin, white, tolerance) in cases {
            let matrix = of_temperature(kelvin).matrix;
            for rgb in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] {
                assert_near(kelvin, matrix * DVec3::from(rgb), balanced(white, rgb), tolerance);
            }
        }
    }

    /// At the same luminance, so that no image becomes brighter.
    #[test]
    fn the_light_of_the_temperature_becomes_white() {
        for kelvin in [1000.0, 2000.0, 3997.0, 3998.0, 5000.0, 6999.0, 7001.0, 25_000.0, 1e6] {
            let DVec2 { x, y } = white(kelvin);
            let light = color::srgb_from_xyz() * (DVec3::new(x, y, 1.0 - x - y) / y);
            assert_near(kelvin, of_temperature(kelvin).matrix * light, [1.0; 3], 1e-9);
        }
    }

    #[test]
    fn daylight_is_white_already() {
        let WhiteBalance { kelvin, matrix } = of_temperature(6504.0 / NEW_KELVIN);
        let largest = (matrix - DMat3::IDENTITY).to_cols_array().into_iter().map(f64::abs).fold(0.0, f64::max);
        assert!((kelvin - 6500.4).abs() < 0.1 && largest < 2e-3, "{kelvin} {matrix}");
        // Warmer light has less blue, so that the balance adds some; colder light has more.
        for (kelvin, is_warm) in [(5000.0, true), (8000.0, false)] {
            let balanced = of_temperature(kelvin).matrix * DVec3::ONE;
            assert!((balanced.z > balanced.x) == is_warm, "{kelvin} {balanced}");
        }
    }

    /// So that the luminance after the balance is not negative, as the sums of it expect.
    #[test]
    fn no_light_gets_a_negative_luminance() {
        let mut kelvin = 1000.0;
        while kelvin <= 1e6 {
            let weights = crate::image::film::balanced_luminance(Some(of_temperature(kelvin).matrix));
            assert!(weights.iter().all(|weight| (1e-3..10.0).contains(weight)), "{kelvin} {weights:?}");
            kelvin *= 1.01;
        }
    }
}
