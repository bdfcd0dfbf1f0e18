//! The colour spaces of the `ColorSpace` directive, and their conversion to linear sRGB.

use glam::DVec2;

use crate::base::color::{D65, Primaries, REC709};
use crate::scene::model::Rgb;

/// An RGB colour space, with pbrt's name for it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(in crate::scene) enum ColorSpace {
    /// `srgb`: ITU-R BT.709.
    #[default]
    Srgb,
    /// `dci-p3`, with the white point D65 as in pbrt.
    DciP3,
    /// `rec2020`: ITU-R BT.2020.
    Rec2020,
    /// `aces2065-1`: SMPTE ST 2065-1.
    Aces,
}

/// Chromaticity of the white point of ACES.
const ACES_WHITE: DVec2 = DVec2::new(0.32168, 0.33767);

impl ColorSpace {
    pub const ALL: [(ColorSpace, &'static str); 4] = [
        (ColorSpace::Srgb, "srgb"),
        (ColorSpace::DciP3, "dci-p3"),
        (ColorSpace::Rec2020, "rec2020"),
        (ColorSpace::Aces, "aces2065-1"),
    ];

    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.iter().find(|(_, other)| *other == name).map(|(space, _)| *space)
    }

    fn primaries(self) -> Primaries {
        let [red, green, blue] = match self {
            Self::Srgb => return REC709,
            Self::DciP3 => [[0.680, 0.320], [0.265, 0.690], [0.150, 0.060]],
            Self::Rec2020 => [[0.708, 0.292], [0.170, 0.797], [0.131, 0.046]],
            Self::Aces => [[0.7347, 0.2653], [0.0, 1.0], [0.0001, -0.0770]],
        };
        let white = if self == Self::Aces { ACES_WHITE } else { D65 };
        Primaries { red: red.into(), green: green.into(), blue: blue.into(), white }
    }

    /// Returns the colour of a light in linear sRGB.
    pub fn light_to_srgb(self, rgb: Rgb) -> Rgb {
        if self == Self::Srgb {
            return rgb;
        }
        self.primaries().light_to_srgb() * rgb
    }

    /// Returns the colour of a reflectance in linear sRGB: a reflectance that is white under the white
    /// point of this space is white under D65.
    pub fn reflectance_to_srgb(self, rgb: Rgb) -> Rgb {
        if self == Self::Srgb {
            return rgb;
        }
        self.primaries().reflectance_to_srgb() * rgb
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: Rgb, b: [f64; 3], tolerance: f64) {
        assert!((a - Rgb::from(b)).abs().max_element() < tolerance, "{a} {b:?}");
    }

    #[test]
    fn matrices_are_those_of_the_standards() {
        // IEC 61966-2-1, rounded to four digits there.
        let srgb = ColorSpace::Srgb.primaries().xyz_from_rgb();
        near(srgb.x_axis, [0.4124, 0.2126, 0.0193], 1e-4);
        near(srgb.y_axis, [0.3576, 0.7152, 0.1192], 1e-4);
        near(srgb.z_axis, [0.1805, 0.0722, 0.9505], 1e-4);
        // Luminance weights of BT.2020.
        let wide = ColorSpace::Rec2020.primaries().xyz_from_rgb();
        near(Rgb::new(wide.x_axis.y, wide.y_axis.y, wide.z_axis.y), [0.2627, 0.6780, 0.0593], 1e-4);
        // SMPTE ST 2065-1.
        let aces = ColorSpace::Aces.primaries().xyz_from_rgb();
        near(aces.x_axis, [0.9525523959, 0.3439664498, 0.0], 1e-9);
        near(aces.z_axis, [0.0000936786, -0.0721325464, 1.0088251844], 1e-9);
    }

    #[test]
    fn wide_primaries_are_out_of_gamut_and_whites_are_white() {
        // ITU-R BT.2087, the inverse of its matrix.
        near(ColorSpace::Rec2020.light_to_srgb(Rgb::X), [1.6605, -0.1246, -0.0182], 1e-4);
        for (space, _) in ColorSpace::ALL {
            near(space.reflectance_to_srgb(Rgb::ONE), [1.0; 3], 1e-12);
            let luminance = REC709.xyz_from_rgb() * space.light_to_srgb(Rgb::ONE);
            assert!((luminance.y - 1.0).abs() < 1e-12);
        }
        near(ColorSpace::DciP3.light_to_srgb(Rgb::ONE), [1.0; 3], 1e-12);
        // ACES has a warmer white.
        let warm = ColorSpace::Aces.light_to_srgb(Rgb::ONE);
        assert!(warm.x > 1.03 && warm.z < 0.95, "{warm}");
    }
}
