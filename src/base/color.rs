//! Primaries of RGB colours, and their conversion to linear sRGB.

use glam::{DMat3, DVec2, DVec3};

/// Chromaticity of CIE illuminant D65.
pub(crate) const D65: DVec2 = DVec2::new(0.3127, 0.3290);

/// The primaries of sRGB: ITU-R BT.709.
pub(crate) const REC709: Primaries =
    Primaries { red: DVec2::new(0.64, 0.33), green: DVec2::new(0.30, 0.60), blue: DVec2::new(0.15, 0.06), white: D65 };

/// Chromaticities (CIE 1931 x and y) of the primaries and the white of an RGB colour space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Primaries {
    /// Chromaticity of (1, 0, 0).
    pub red: DVec2,
    /// Chromaticity of (0, 1, 0).
    pub green: DVec2,
    /// Chromaticity of (0, 0, 1).
    pub blue: DVec2,
    /// Chromaticity of (1, 1, 1).
    pub white: DVec2,
}

impl Primaries {
    /// Returns the matrix from RGB to CIE XYZ that gives white a luminance of 1.
    pub fn xyz_from_rgb(&self) -> DMat3 {
        let primaries = DMat3::from_cols(direction(self.red), direction(self.green), direction(self.blue));
        let amounts = primaries.inverse() * xyz(self.white);
        primaries * DMat3::from_diagonal(amounts)
    }

    /// Returns the matrix from RGB to linear sRGB that keeps light as it is: a white other than D65 does not
    /// become white.
    pub fn light_to_srgb(&self) -> DMat3 {
        REC709.xyz_from_rgb().inverse() * self.xyz_from_rgb()
    }

    /// Returns the matrix from RGB to linear sRGB that keeps the look of a reflectance under the white of
    /// each space: white stays white.
    pub fn reflectance_to_srgb(&self) -> DMat3 {
        REC709.xyz_from_rgb().inverse() * adaptation(self.white, D65) * self.xyz_from_rgb()
    }

    /// Returns whether they span a colour space: all matrices are finite.
    pub fn are_valid(&self) -> bool {
        let area = (self.green - self.red).perp_dot(self.blue - self.red);
        let matrices = [self.light_to_srgb(), self.reflectance_to_srgb()];
        area.abs() > 1e-6 && matrices.iter().all(|matrix| matrix.is_finite())
    }

    /// Returns whether they are those of sRGB, but for rounding in a file.
    pub fn are_srgb(&self) -> bool {
        let pairs = [(self.red, REC709.red), (self.green, REC709.green), (self.blue, REC709.blue), (self.white, D65)];
        pairs.iter().all(|(own, standard)| own.abs_diff_eq(*standard, 1e-3))
    }
}

/// Returns the matrix from CIE XYZ to linear sRGB that keeps light as it is.
pub(crate) fn srgb_from_xyz() -> DMat3 {
    REC709.xyz_from_rgb().inverse()
}

/// Returns the matrix on linear sRGB that makes light of the chromaticity `white` grey, at the same luminance:
/// von Kries's scaling of the cone responses of Bradford (Lam 1985).
pub(crate) fn white_balance(white: DVec2) -> DMat3 {
    srgb_from_xyz() * adaptation(white, D65) * REC709.xyz_from_rgb()
}

/// Returns X, Y and Z, divided by their sum.
fn direction(xy: DVec2) -> DVec3 {
    DVec3::new(xy.x, xy.y, 1.0 - xy.x - xy.y)
}

/// Returns X, Y and Z at luminance 1.
fn xyz(xy: DVec2) -> DVec3 {
    direction(xy) / xy.y
}

/// Returns the matrix from XYZ under one white to XYZ of the same look under another (Bradford; Lam 1985).
fn adaptation(from: DVec2, to: DVec2) -> DMat3 {
    let cones = DMat3::from_cols_array(&[0.8951, -0.7502, 0.0389, 0.2664, 1.7135, -0.0685, -0.1614, 0.0367, 1.0296]);
    let gains = (cones * xyz(to)) / (cones * xyz(from));
    cones.inverse() * DMat3::from_diagonal(gains) * cones
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whites_stay_white_where_they_are_seen_alone() {
        let warm = Primaries { white: DVec2::new(0.4476, 0.4074), ..REC709 };
        assert!((warm.reflectance_to_srgb() * DVec3::ONE).distance(DVec3::ONE) < 1e-12);
        // CIE illuminant A as light: red, at the same luminance.
        let light = warm.light_to_srgb() * DVec3::ONE;
        assert!(light.x > 1.7 && light.z < 0.3, "{light}");
        assert!((light.dot(DVec3::new(0.2126, 0.7152, 0.0722)) - 1.0).abs() < 1e-3, "{light}");
        assert!(warm.are_valid() && !warm.are_srgb() && REC709.are_srgb());
    }

    #[test]
    fn points_that_span_no_triangle_make_no_colours() {
        let line = Primaries { blue: DVec2::new(0.47, 0.465), ..REC709 };
        let dark = Primaries { white: DVec2::new(0.3, 0.0), ..REC709 };
        let lost = Primaries { red: DVec2::NAN, ..REC709 };
        for bad in [line, dark, lost] {
            assert!(!bad.are_valid(), "{bad:?}");
        }
    }
}
