//! The colour spaces of `ColorSpace`, and the way from each to linear sRGB.

use glam::{DMat3, DVec2, DVec3};

use super::model::Rgb;

/// An RGB colour space, by pbrt's name for it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum ColorSpace {
    /// `srgb`: ITU-R BT.709.
    #[default]
    Srgb,
    /// `dci-p3`, of which pbrt takes the white to be D65.
    DciP3,
    /// `rec2020`: ITU-R BT.2020.
    Rec2020,
    /// `aces2065-1`: SMPTE ST 2065-1.
    Aces,
}

/// Chromaticity of CIE illuminant D65.
const D65: DVec2 = DVec2::new(0.3127, 0.3290);
/// Of the white of ACES.
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

    /// Chromaticities of red, green, blue and white.
    fn chromaticities(self) -> [DVec2; 4] {
        let [red, green, blue] = match self {
            Self::Srgb => [[0.64, 0.33], [0.30, 0.60], [0.15, 0.06]],
            Self::DciP3 => [[0.680, 0.320], [0.265, 0.690], [0.150, 0.060]],
            Self::Rec2020 => [[0.708, 0.292], [0.170, 0.797], [0.131, 0.046]],
            Self::Aces => [[0.7347, 0.2653], [0.0, 1.0], [0.0001, -0.0770]],
        };
        let white = if self == Self::Aces { ACES_WHITE } else { D65 };
        [red.into(), green.into(), blue.into(), white]
    }

    /// To CIE XYZ, so that white has luminance 1.
    fn xyz_from_rgb(self) -> DMat3 {
        let [red, green, blue, white] = self.chromaticities();
        let primaries = DMat3::from_cols(direction(red), direction(green), direction(blue));
        let amounts = primaries.inverse() * xyz(white);
        primaries * DMat3::from_diagonal(amounts)
    }

    /// The same light in linear sRGB.
    pub fn light_to_srgb(self, rgb: Rgb) -> Rgb {
        if self == Self::Srgb {
            return rgb;
        }
        Self::Srgb.xyz_from_rgb().inverse() * (self.xyz_from_rgb() * rgb)
    }

    /// The reflectance in linear sRGB: what looks white under one space's white does so under
    /// the other's.
    pub fn reflectance_to_srgb(self, rgb: Rgb) -> Rgb {
        if self == Self::Srgb {
            return rgb;
        }
        let [.., white] = self.chromaticities();
        Self::Srgb.xyz_from_rgb().inverse() * (adaptation(white, D65) * (self.xyz_from_rgb() * rgb))
    }
}

/// X, Y and Z over their sum.
fn direction(xy: DVec2) -> DVec3 {
    DVec3::new(xy.x, xy.y, 1.0 - xy.x - xy.y)
}

/// At luminance 1.
fn xyz(xy: DVec2) -> DVec3 {
    direction(xy) / xy.y
}

/// Takes XYZ as seen under one white to what looks the same under another (Bradford; Lam 1985).
fn adaptation(from: DVec2, to: DVec2) -> DMat3 {
    let cones = DMat3::from_cols_array(&[0.8951, -0.7502, 0.0389, 0.2664, 1.7135, -0.0685, -0.1614, 0.0367, 1.0296]);
    let gains = (cones * xyz(to)) / (cones * xyz(from));
    cones.inverse() * DMat3::from_diagonal(gains) * cones
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
        let srgb = ColorSpace::Srgb.xyz_from_rgb();
        near(srgb.x_axis, [0.4124, 0.2126, 0.0193], 1e-4);
        near(srgb.y_axis, [0.3576, 0.7152, 0.1192], 1e-4);
        near(srgb.z_axis, [0.1805, 0.0722, 0.9505], 1e-4);
        // Luminance weights of BT.2020.
        let wide = ColorSpace::Rec2020.xyz_from_rgb();
        near(Rgb::new(wide.x_axis.y, wide.y_axis.y, wide.z_axis.y), [0.2627, 0.6780, 0.0593], 1e-4);
        // SMPTE ST 2065-1.
        let aces = ColorSpace::Aces.xyz_from_rgb();
        near(aces.x_axis, [0.9525523959, 0.3439664498, 0.0], 1e-9);
        near(aces.z_axis, [0.0000936786, -0.0721325464, 1.0088251844], 1e-9);
    }

    #[test]
    fn wide_primaries_are_out_of_gamut_and_whites_are_white() {
        // ITU-R BT.2087, the inverse of its matrix.
        near(ColorSpace::Rec2020.light_to_srgb(Rgb::X), [1.6605, -0.1246, -0.0182], 1e-4);
        for (space, _) in ColorSpace::ALL {
            near(space.reflectance_to_srgb(Rgb::ONE), [1.0; 3], 1e-12);
            let luminance = ColorSpace::Srgb.xyz_from_rgb() * space.light_to_srgb(Rgb::ONE);
            assert!((luminance.y - 1.0).abs() < 1e-12);
        }
        near(ColorSpace::DciP3.light_to_srgb(Rgb::ONE), [1.0; 3], 1e-12);
        // Of a warmer white.
        let warm = ColorSpace::Aces.light_to_srgb(Rgb::ONE);
        assert!(warm.x > 1.03 && warm.z < 0.95, "{warm}");
    }
}
