//! Measured spectral data: the standard observer, daylight, metals, glasses.
//!
//! The observer and the illuminant are CIE standards. The metals' optical constants are laboratory
//! measurements in general circulation (Hagemann, Palik, Weaver, Querry), resampled. The glasses are the
//! manufacturers' Sellmeier coefficients.

/// Wavelength of the first sample, nm.
pub(in crate::scene) const FIRST: f64 = 380.0;
/// Wavelength of the last sample, nm.
pub(in crate::scene) const LAST: f64 = 780.0;

/// CIE 1931 observer (x, y, z) and illuminant D65, every 10 nm.
pub(in crate::scene) const OBSERVER: [([f64; 3], f64); 41] = [
    ([0.001368, 3.9e-05, 0.00645], 49.9755),
    ([0.004243, 0.00012, 0.02005], 54.6482),
    ([0.01431, 0.000396, 0.06785], 82.7549),
    ([0.04351, 0.00121, 0.2074], 91.486),
    ([0.13438, 0.004, 0.6456], 93.4318),
    ([0.2839, 0.0116, 1.3856], 86.6823),
    ([0.34828, 0.023, 1.74706], 104.865),
    ([0.3362, 0.038, 1.77211], 117.008),
    ([0.2908, 0.06, 1.6692], 117.812),
    ([0.19536, 0.09098, 1.28764], 114.861),
    ([0.09564, 0.13902, 0.81295], 115.923),
    ([0.03201, 0.20802, 0.46518], 108.811),
    ([0.0049, 0.323, 0.272], 109.354),
    ([0.0093, 0.503, 0.1582], 107.802),
    ([0.06327, 0.71, 0.07825], 104.79),
    ([0.1655, 0.862, 0.04216], 107.689),
    ([0.2904, 0.954, 0.0203], 104.405),
    ([0.43345, 0.99495, 0.00875], 104.046),
    ([0.5945, 0.995, 0.0039], 100.0),
    ([0.7621, 0.952, 0.0021], 96.3342),
    ([0.9163, 0.87, 0.00165], 95.788),
    ([1.0263, 0.757, 0.0011], 88.6856),
    ([1.0622, 0.631, 0.0008], 90.0062),
    ([1.0026, 0.503, 0.00034], 89.5991),
    ([0.85445, 0.381, 0.00019], 87.6987),
    ([0.6424, 0.265, 5e-05], 83.2886),
    ([0.4479, 0.175, 2e-05], 83.6992),
    ([0.2835, 0.107, 0.0], 80.0268),
    ([0.1649, 0.061, 0.0], 80.2146),
    ([0.0874, 0.032, 0.0], 82.2778),
    ([0.04677, 0.017, 0.0], 78.2842),
    ([0.0227, 0.00821, 0.0], 69.7213),
    ([0.011359, 0.004102, 0.0], 71.6091),
    ([0.00579, 0.002091, 0.0], 74.349),
    ([0.002899, 0.001047, 0.0], 61.604),
    ([0.00144, 0.00052, 0.0], 69.8856),
    ([0.00069, 0.000249, 0.0], 75.087),
    ([0.000332, 0.00012, 0.0], 63.5927),
    ([0.000166, 6e-05, 0.0], 46.4182),
    ([8.3e-05, 3e-05, 0.0], 66.8054),
    ([4.2e-05, 1.5e-05, 0.0], 63.3828),
];

/// Components of daylight, every 10 nm: the mean and the first two principal deviations from it (CIE 15,
/// from Judd, MacAdam and Wyszecki 1964).
pub(in crate::scene) const DAYLIGHT: [[f64; 3]; 41] = [
    [63.4, 38.5, 3.0],
    [65.8, 35.0, 1.2],
    [94.8, 43.4, -1.1],
    [104.8, 46.3, -0.5],
    [105.9, 43.9, -0.7],
    [96.8, 37.1, -1.2],
    [113.9, 36.7, -2.6],
    [125.6, 35.9, -2.9],
    [125.5, 32.6, -2.8],
    [121.3, 27.9, -2.6],
    [121.3, 24.3, -2.6],
    [113.5, 20.1, -1.8],
    [113.1, 16.2, -1.5],
    [110.8, 13.2, -1.3],
    [106.5, 8.6, -1.2],
    [108.8, 6.1, -1.0],
    [105.3, 4.2, -0.5],
    [104.4, 1.9, -0.3],
    [100.0, 0.0, 0.0],
    [96.0, -1.6, 0.2],
    [95.1, -3.5, 0.5],
    [89.1, -3.5, 2.1],
    [90.5, -5.8, 3.2],
    [90.3, -7.2, 4.1],
    [88.4, -8.6, 4.7],
    [84.0, -9.5, 5.1],
    [85.1, -10.9, 6.7],
    [81.9, -10.7, 7.3],
    [82.6, -12.0, 8.6],
    [84.9, -14.0, 9.8],
    [81.3, -13.6, 10.2],
    [71.9, -12.0, 8.3],
    [74.3, -13.3, 9.6],
    [76.4, -12.9, 8.5],
    [63.3, -10.6, 7.0],
    [71.7, -11.6, 7.6],
    [77.0, -12.2, 8.0],
    [65.2, -10.2, 6.7],
    [47.7, -7.8, 5.2],
    [68.6, -11.2, 7.4],
    [65.0, -10.4, 6.8],
];

/// Number of samples of a metal, every 20 nm.
pub(in crate::scene) const SAMPLES: usize = 21;

/// Optical constants of a metal from [`FIRST`] to [`LAST`].
#[derive(Debug)]
pub(in crate::scene) struct Metal {
    /// pbrt's name for it, without `metal-` and `-eta` or `-k`.
    pub name: &'static str,
    /// Real part of the index of refraction.
    pub eta: [f64; SAMPLES],
    /// Absorption coefficient.
    pub k: [f64; SAMPLES],
}

pub(in crate::scene) const METALS: [Metal; 7] = [
    Metal {
        name: "Ag",
        eta: [
            0.199, 0.173, 0.167, 0.158, 0.143, 0.131, 0.130, 0.130, 0.129, 0.121, 0.120, 0.124, 0.131, 0.137, 0.140,
            0.140, 0.142, 0.146, 0.147, 0.145, 0.143,
        ],
        k: [
            1.718, 1.951, 2.183, 2.375, 2.567, 2.746, 2.918, 3.098, 3.258, 3.421, 3.580, 3.731, 3.881, 4.045, 4.210,
            4.371, 4.523, 4.671, 4.821, 4.975, 5.131,
        ],
    },
    Metal {
        name: "Al",
        eta: [
            0.442, 0.490, 0.539, 0.591, 0.646, 0.705, 0.769, 0.839, 0.916, 1.004, 1.097, 1.197, 1.300, 1.415, 1.536,
            1.674, 1.837, 2.037, 2.270, 2.490, 2.665,
        ],
        k: [
            4.615, 4.861, 5.105, 5.348, 5.590, 5.839, 6.078, 6.323, 6.562, 6.807, 7.036, 7.257, 7.481, 7.693, 7.900,
            8.115, 8.312, 8.490, 8.594, 8.613, 8.569,
        ],
    },
    Metal {
        name: "Au",
        eta: [
            1.688, 1.658, 1.628, 1.574, 1.419, 1.190, 0.851, 0.572, 0.398, 0.317, 0.260, 0.220, 0.194, 0.175, 0.164,
            0.160, 0.160, 0.163, 0.167, 0.172, 0.177,
        ],
        k: [
            1.918, 1.956, 1.952, 1.911, 1.843, 1.796, 1.887, 2.184, 2.555, 2.837, 2.948, 3.000, 3.060, 3.090, 3.275,
            3.633, 3.964, 4.237, 4.479, 4.701, 4.914,
        ],
    },
    Metal {
        name: "Cu",
        eta: [
            1.206, 1.175, 1.178, 1.171, 1.160, 1.148, 1.134, 1.111, 1.033, 0.861, 0.603, 0.390, 0.272, 0.227, 0.212,
            0.211, 0.215, 0.220, 0.230, 0.241, 0.251,
        ],
        k: [
            2.094, 2.130, 2.248, 2.349, 2.436, 2.515, 2.574, 2.602, 2.582, 2.593, 2.710, 2.943, 3.241, 3.511, 3.752,
            3.962, 4.158, 4.345, 4.522, 4.692, 4.861,
        ],
    },
    Metal {
        name: "CuZn",
        eta: [
            1.448, 1.445, 1.305, 1.164, 1.012, 0.849, 0.686, 0.622, 0.559, 0.512, 0.481, 0.450, 0.448, 0.445, 0.444,
            0.445, 0.446, 0.451, 0.457, 0.462, 0.468,
        ],
        k: [
            1.792, 1.805, 1.815, 1.824, 1.913, 2.082, 2.250, 2.456, 2.662, 2.863, 3.058, 3.253, 3.430, 3.607, 3.777,
            3.942, 4.106, 4.263, 4.420, 4.576, 4.733,
        ],
    },
    Metal {
        name: "MgO",
        eta: [
            1.767, 1.762, 1.758, 1.754, 1.751, 1.748, 1.745, 1.743, 1.741, 1.740, 1.738, 1.737, 1.735, 1.734, 1.733,
            1.732, 1.731, 1.731, 1.730, 1.729, 1.729,
        ],
        k: [0.0; SAMPLES],
    },
    Metal {
        name: "TiO2",
        eta: [
            3.599, 3.399, 3.290, 3.200, 3.130, 3.080, 3.030, 3.000, 2.970, 2.940, 2.920, 2.900, 2.880, 2.870, 2.850,
            2.840, 2.830, 2.820, 2.810, 2.810, 2.800,
        ],
        k: [0.0; SAMPLES],
    },
];

/// A glass: n² = 1 + Σ b λ² / (λ² - c), λ in µm.
#[derive(Debug, PartialEq)]
pub(in crate::scene) struct Glass {
    /// pbrt's name for it.
    pub name: &'static str,
    pub b: [f64; 3],
    /// Coefficients in µm².
    pub c: [f64; 3],
}

/// The glasses of pbrt. Its F5, F10 and F11 are the manufacturers' SF5, SF10 and SF11.
pub(in crate::scene) const GLASSES: [Glass; 7] = [
    Glass { name: "glass-BK7", b: [1.03961212, 0.231792344, 1.01046945], c: [0.00600069867, 0.0200179144, 103.560653] },
    Glass {
        name: "glass-BAF10",
        b: [1.5851495, 0.143559385, 1.08521269],
        c: [0.00926681282, 0.0424489805, 105.613573],
    },
    Glass {
        name: "glass-FK51A",
        b: [0.971247817, 0.216901417, 0.904651666],
        c: [0.00472301995, 0.0153575612, 168.68133],
    },
    Glass {
        name: "glass-LASF9",
        b: [2.00029547, 0.298926886, 1.80691843],
        c: [0.0121426017, 0.0538736236, 156.530829],
    },
    Glass { name: "glass-F5", b: [1.52481889, 0.187085527, 1.42729015], c: [0.011254756, 0.0588995392, 129.141675] },
    Glass { name: "glass-F10", b: [1.62153902, 0.256287842, 1.64447552], c: [0.0122241457, 0.0595736775, 147.468793] },
    Glass { name: "glass-F11", b: [1.73759695, 0.313747346, 1.89878101], c: [0.013188707, 0.0623068142, 155.23629] },
];

#[cfg(test)]
mod tests {
    use super::OBSERVER;
    use crate::image::film::{into_gamut, srgb_encode};
    use crate::scene::Rgb;
    use crate::scene::spectrum::{interpolated, rgb_from_xyz};

    /// Returns a wavelength of a spectrum of equal energy as a screen shows it, with this share of white: linear RGB.
    fn shown(nm: f64, white: f64) -> [f32; 3] {
        let rgb = rgb_from_xyz(interpolated(nm, |i| Rgb::from(OBSERVER[i].0)));
        into_gamut((rgb + white * rgb.max_element()).as_vec3().to_array())
    }

    /// Returns the hue on the hexagon of red, green and blue, in degrees from red to yellow.
    fn hue([r, g, b]: [f32; 3]) -> f32 {
        let most = r.max(g).max(b);
        let range = most - r.min(g).min(b);
        let sixth = if most == r { (g - b) / range } else { 0.0 };
        let sixth = if most == g { 2.0 + (b - r) / range } else { sixth };
        60.0 * if most == b { 4.0 + (r - g) / range } else { sixth }
    }

    /// From violet over blue, green and yellow to red. Hues change by 0.09 degrees and more where the eye tells
    /// wavelengths apart, from 430 to 650 nm; with negative channels cut off, ranges of wavelengths have one hue.
    #[test]
    fn no_two_wavelengths_look_alike_on_a_screen() {
        for white in [0.0, 0.02, 0.1, 0.5] {
            for nm in (430..650).step_by(5) {
                let [before, after] = [nm, nm + 5].map(|nm| hue(shown(f64::from(nm), white)));
                let step = (before - after).rem_euclid(360.0);
                assert!((0.05..40.0).contains(&step), "{white} {nm}: {before} {after}");
            }
        }
    }

    /// The slope of a channel, in bytes for 2 nm, changes by 24 at most. By mapping towards grey alone it would be
    /// 36, at pure green, and by cutting negative channels off 56.
    #[test]
    fn a_rainbow_has_no_edges_on_a_screen() {
        let bytes = |nm: u32| shown(f64::from(nm), 0.0).map(|channel| 255.0 * srgb_encode((0.5 * channel).min(1.0)));
        for nm in (432..650).step_by(2) {
            let [before, here, after] = [nm - 2, nm, nm + 2].map(bytes);
            let edge = [0, 1, 2].map(|i| (before[i] - 2.0 * here[i] + after[i]).abs());
            assert!(edge.iter().all(|edge| *edge < 28.0), "{nm}: {edge:?}");
        }
    }
}
