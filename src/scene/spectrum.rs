//! Conversion of spectra to linear RGB, as pbrt's images show them.
//!
//! A reflectance becomes its colour under D65, where white is (1, 1, 1): the white of pbrt's `rgb` lights.
//! A light becomes its colour at luminance 1, because pbrt scales every light spectrum that is not `rgb` to
//! luminance 1 before it applies `scale` and `power`.

pub(in crate::scene) mod color_space;
mod data;
pub(in crate::scene) mod files;
pub(in crate::scene) mod samples;
pub(in crate::scene) mod wavelength;
pub(in crate::scene) mod white_balance;

use glam::DVec2;

use crate::scene::format::error::{Location, SceneError};
use crate::scene::format::kind::Kind;
use crate::scene::format::lexer::shorten;
use crate::scene::format::params::Param;
use crate::scene::format::version3;
use crate::scene::model::Rgb;
use crate::scene::spectrum::color_space::ColorSpace;
use crate::scene::spectrum::data::{DAYLIGHT, FIRST, GLASSES, Glass, LAST, METALS, OBSERVER, SAMPLES};

/// The spectrum of a parameter.
#[derive(Clone, Debug)]
pub(in crate::scene) enum Spectrum {
    /// Linear RGB in the sRGB primaries.
    Rgb(Rgb),
    /// Linear RGB of another colour space.
    OtherRgb(Rgb, ColorSpace),
    /// Pairs of a wavelength in nm, ascending, and a value; the spectrum is 0 outside of the table.
    Table(Vec<[f64; 2]>),
    /// One of the two optical constants of a metal.
    Metal(&'static [f64; SAMPLES]),
    /// A glass's index of refraction.
    Glass(&'static Glass),
    /// A black body with this temperature, in K.
    Blackbody(f64),
    /// CIE illuminant D65.
    Daylight,
    /// Daylight of another colour temperature.
    DaylightPhase(DaylightPhase),
}

const NAMES: &str = "\"glass-BK7\", -BAF10, -FK51A, -LASF9, -F5, -F10, -F11, \
    \"metal-Ag-eta\" and \"-k\", and so for -Al, -Au, -Cu, -CuZn, -MgO, -TiO2, \
    \"stdillum-A\", -D50, -D65, \"illum-acesD60\", a file of pairs of wavelength and value, or such pairs";

impl Spectrum {
    /// Returns the spectrum of a parameter of type rgb, spectrum or blackbody.
    pub fn from_param(param: &Param) -> Result<Self, SceneError> {
        match (param.kind, param.text()) {
            (Kind::Rgb, _) => match (param.one()?, param.color_space) {
                (rgb, ColorSpace::Srgb) => Ok(Spectrum::Rgb(rgb.into())),
                (rgb, space) => Ok(Spectrum::OtherRgb(rgb.into(), space)),
            },
            (Kind::Blackbody, _) => match param.numbers() {
                [kelvin] if (100.0..=1e6).contains(kelvin) => Ok(Spectrum::Blackbody(*kelvin)),
                values => {
                    let hint = version3::hint_at_blackbody(values.len());
                    Err(param.bad_value(&format!("one temperature from 100 to 1000000 K{hint}")))
                }
            },
            (_, Some(name)) => Self::named(name).ok_or_else(|| {
                param.location.unsupported(&format!("the spectrum {:?} of {param}", shorten(name)), NAMES)
            }),
            _ => Self::table(param),
        }
    }

    /// Returns the spectrum that pbrt has under a name, or `None` if goblet does not have it.
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "stdillum-D65" => return Some(Spectrum::Daylight),
            // The nominal temperatures are on an older temperature scale.
            "stdillum-D50" => return Some(Spectrum::DaylightPhase(DaylightPhase::new(5000.0 * NEW_KELVIN))),
            "illum-acesD60" => return Some(Spectrum::DaylightPhase(DaylightPhase::new(6000.0 * NEW_KELVIN))),
            "stdillum-A" => return Some(Spectrum::Blackbody(ILLUMINANT_A)),
            _ => {}
        }
        if let Some(glass) = GLASSES.iter().find(|glass| glass.name == name) {
            return Some(Spectrum::Glass(glass));
        }
        let (metal, constant) = name.strip_prefix("metal-")?.rsplit_once('-')?;
        let metal = METALS.iter().find(|m| m.name == metal)?;
        match constant {
            "eta" => Some(Spectrum::Metal(&metal.eta)),
            "k" => Some(Spectrum::Metal(&metal.k)),
            _ => None,
        }
    }

    fn table(param: &Param) -> Result<Self, SceneError> {
        let numbers = param.numbers();
        let pairs: Vec<[f64; 2]> = numbers.chunks_exact(2).map(|p| [p[0], p[1]]).collect();
        let ascending = pairs.windows(2).all(|w| w[0][0] < w[1][0]);
        let positive = pairs.iter().all(|p| p[0] > 0.0 && p[1] >= 0.0);
        if pairs.is_empty() || !numbers.len().is_multiple_of(2) || !ascending || !positive {
            return Err(param.bad_value("pairs of a wavelength in nm and a value of 0 or more, wavelengths ascending"));
        }
        Ok(Spectrum::Table(pairs))
    }

    /// Returns the value at a wavelength in nm; for RGB, the mean of the channels.
    fn at(&self, nm: f64) -> f64 {
        match self {
            Spectrum::Rgb(rgb) | Spectrum::OtherRgb(rgb, _) => rgb.element_sum() / 3.0,
            Spectrum::Table(pairs) => interpolate(pairs, nm),
            Spectrum::Metal(samples) => {
                let at = (nm - FIRST) / (LAST - FIRST) * (SAMPLES - 1) as f64;
                let low = (at.max(0.0) as usize).min(SAMPLES - 2);
                let t = (at - low as f64).clamp(0.0, 1.0);
                samples[low] * (1.0 - t) + samples[low + 1] * t
            }
            Spectrum::Glass(glass) => glass.eta(nm),
            Spectrum::Blackbody(kelvin) => blackbody(*kelvin, nm),
            Spectrum::Daylight => interpolated(nm, |i| Rgb::splat(OBSERVER[i].1)).x,
            Spectrum::DaylightPhase(phase) => phase.at(nm),
        }
    }

    /// Returns the colour of a reflectance. RGB outside of [0, 1] is returned unchanged, for the caller to
    /// refuse; other colours outside of sRGB's gamut are clamped to it.
    pub fn reflectance(&self) -> Rgb {
        match self {
            Spectrum::Rgb(rgb) => *rgb,
            Spectrum::OtherRgb(rgb, _) if rgb.min_element() < 0.0 || rgb.max_element() > 1.0 => *rgb,
            Spectrum::OtherRgb(rgb, space) => space.reflectance_to_srgb(*rgb).clamp(Rgb::ZERO, Rgb::ONE),
            _ => under_daylight(|nm| self.at(nm)).clamp(Rgb::ZERO, Rgb::ONE),
        }
    }

    /// Returns the colour of a light, at luminance 1 if it is not RGB, as in pbrt.
    pub fn light(&self) -> Rgb {
        match self {
            Spectrum::Rgb(rgb) => *rgb,
            Spectrum::OtherRgb(rgb, _) if rgb.min_element() < 0.0 => *rgb,
            Spectrum::OtherRgb(rgb, space) => space.light_to_srgb(*rgb).max(Rgb::ZERO),
            Spectrum::Daylight => Rgb::ONE,
            _ => {
                let response = response(|nm| self.at(nm));
                let white = response_of_daylight();
                if response.luminance <= 0.0 {
                    return Rgb::ZERO;
                }
                let rgb = response.rgb / white.rgb * (white.luminance / response.luminance);
                rgb.max(Rgb::ZERO)
            }
        }
    }

    /// Returns a coefficient of absorption or scattering per channel, which has no upper bound: the mean
    /// over what the eye sees in daylight.
    pub fn coefficient(&self) -> Rgb {
        match self {
            Spectrum::Rgb(rgb) => *rgb,
            Spectrum::OtherRgb(rgb, _) if rgb.min_element() < 0.0 => *rgb,
            Spectrum::OtherRgb(rgb, space) => space.reflectance_to_srgb(*rgb).max(Rgb::ZERO),
            _ => under_daylight(|nm| self.at(nm)).max(Rgb::ZERO),
        }
    }

    /// Returns optical constants per channel, if they are given as RGB.
    fn channels(&self) -> Option<Rgb> {
        match self {
            Spectrum::Rgb(rgb) => Some(*rgb),
            Spectrum::OtherRgb(rgb, space) => Some(space.reflectance_to_srgb(*rgb).max(Rgb::ZERO)),
            _ => None,
        }
    }
}

impl Glass {
    fn eta(&self, nm: f64) -> f64 {
        let squared = (nm / 1000.0).powi(2);
        let terms = self.b.iter().zip(self.c);
        (1.0 + terms.map(|(b, c)| b * squared / (squared - c)).sum::<f64>()).sqrt()
    }
}

fn interpolate(pairs: &[[f64; 2]], nm: f64) -> f64 {
    let above = pairs.partition_point(|pair| pair[0] < nm);
    match (above.checked_sub(1).map(|i| pairs[i]), pairs.get(above)) {
        (_, Some([wavelength, value])) if *wavelength == nm => *value,
        (Some([low, a]), Some([high, b])) => a + (b - a) * (nm - low) / (high - low),
        _ => 0.0,
    }
}

/// Daylight at a colour temperature, by CIE 15 from three measured components.
#[derive(Clone, Copy, Debug)]
pub(in crate::scene) struct DaylightPhase {
    weights: [f64; 2],
}

impl DaylightPhase {
    /// Returns the daylight of a temperature from 4000 K to 7000 K.
    fn new(kelvin: f64) -> Self {
        let DVec2 { x, y } = daylight_chromaticity(kelvin);
        let divisor = 0.0241 + 0.2562 * x - 0.7341 * y;
        let weights = [-1.3515 - 1.7703 * x + 5.9114 * y, 0.0300 - 31.4424 * x + 30.0717 * y];
        Self { weights: weights.map(|weight| weight / divisor) }
    }

    fn at(&self, nm: f64) -> f64 {
        let [first, second] = self.weights;
        interpolated(nm, |i| Rgb::from(DAYLIGHT[i])).dot(Rgb::new(1.0, first, second))
    }
}

/// Returns the chromaticity of daylight of a colour temperature from 4000 K (CIE 15, from Judd, MacAdam and
/// Wyszecki 1964). The CIE defines it up to 25000 K; above, as in pbrt, the formula is used as it is.
fn daylight_chromaticity(kelvin: f64) -> DVec2 {
    let [constant, first, second, third] = if kelvin <= 7000.0 {
        [0.244_063, 0.099_11e3, 2.967_8e6, 4.607_0e9]
    } else {
        [0.237_040, 0.247_48e3, 1.901_8e6, 2.006_4e9]
    };
    let x = constant + first / kelvin + second / kelvin.powi(2) - third / kelvin.powi(3);
    DVec2::new(x, -3.0 * x * x + 2.87 * x - 0.275)
}

/// Factor of temperatures that results from the change of the second radiation constant from 1.438 cm K to
/// 1.4388 cm K.
const NEW_KELVIN: f64 = 1.4388 / 1.438;
/// Temperature of CIE illuminant A, K: 2848 K at a radiation constant of 1.435 cm K.
const ILLUMINANT_A: f64 = 2848.0 * 1.4388 / 1.435;

/// Returns Planck's law divided by its largest value, at Wien's wavelength, as in pbrt.
fn blackbody(kelvin: f64, nm: f64) -> f64 {
    const HC_OVER_K: f64 = 1.438_776_877e7; // nm K
    const WIEN: f64 = 2.897_771_955e6; // nm K
    let (peak, exponential) = (WIEN / kelvin, |nm: f64| (HC_OVER_K / (nm * kelvin)).exp_m1());
    (peak / nm).powi(5) * exponential(peak) / exponential(nm)
}

fn daylight(nm: f64) -> f64 {
    Spectrum::Daylight.at(nm)
}

/// The response of the standard observer to a spectrum.
struct Response {
    /// Colour in linear sRGB; channels may be negative.
    rgb: Rgb,
    luminance: f64,
}

/// Returns the wavelengths in steps of 1 nm, so that narrow lines are not lost, with the observer's
/// response (x, y, z).
fn wavelengths() -> impl Iterator<Item = (f64, Rgb)> {
    let steps = (LAST - FIRST) as u32;
    (0..=steps).map(|step| {
        let nm = FIRST + f64::from(step);
        (nm, interpolated(nm, |i| Rgb::from(OBSERVER[i].0)))
    })
}

/// Interpolates linearly between samples that are 10 nm apart, from [`FIRST`] to [`LAST`].
fn interpolated(nm: f64, sample: impl Fn(usize) -> Rgb) -> Rgb {
    let place = (nm - FIRST) / 10.0;
    let low = (place as usize).min(OBSERVER.len() - 2);
    sample(low).lerp(sample(low + 1), place - low as f64)
}

fn response(spectrum: impl Fn(f64) -> f64) -> Response {
    let xyz: Rgb = wavelengths().map(|(nm, xyz)| xyz * spectrum(nm)).sum();
    Response { rgb: rgb_from_xyz(xyz), luminance: xyz.y }
}

fn rgb_from_xyz(xyz: Rgb) -> Rgb {
    Rgb::new(
        xyz.dot(Rgb::new(3.240_454_2, -1.537_138_5, -0.498_531_4)),
        xyz.dot(Rgb::new(-0.969_266_0, 1.876_010_8, 0.041_556_0)),
        xyz.dot(Rgb::new(0.055_643_4, -0.204_025_9, 1.057_225_2)),
    )
}

fn response_of_daylight() -> Response {
    response(daylight)
}

/// Returns the colour of a reflectance under D65, not clamped.
fn under_daylight(reflectance: impl Fn(f64) -> f64) -> Rgb {
    response(|nm| reflectance(nm) * daylight(nm)).rgb / response_of_daylight().rgb
}

/// pbrt's upper bound of the reflectance: at 1 the absorption would be infinite.
const MAX_REFLECTANCE: f64 = 0.9999;

/// Returns optical constants (eta, k) of a metal of which only the reflectance is known.
pub(in crate::scene) fn conductor_from_reflectance(reflectance: Rgb) -> (Rgb, Rgb) {
    let r = reflectance.clamp(Rgb::ZERO, Rgb::splat(MAX_REFLECTANCE));
    let k = |r: f64| 2.0 * r.sqrt() / (1.0 - r).sqrt();
    (Rgb::ONE, Rgb::new(k(r.x), k(r.y), k(r.z)))
}

/// Returns optical constants (eta, k) per channel of a metal with spectral constants.
///
/// The eye sees the mean of the reflectance, which differs from the reflectance of the mean constants. So
/// eta is the mean over the channel's response, and k is solved for so that the reflectance at normal
/// incidence is right.
pub(in crate::scene) fn conductor(eta: &Spectrum, k: &Spectrum) -> (Rgb, Rgb) {
    if let (Some(eta), Some(k)) = (eta.channels(), k.channels()) {
        return (eta, k);
    }
    let seen = under_daylight(|nm| normal_reflectance(eta.at(nm), k.at(nm)));
    let mut weighted = Rgb::ZERO;
    let mut weights = Rgb::ZERO;
    for (nm, xyz) in wavelengths() {
        // Negative weights of a channel could give a mean that no metal has.
        let weight = (rgb_from_xyz(xyz) * daylight(nm)).max(Rgb::ZERO);
        weighted += weight * eta.at(nm);
        weights += weight;
    }
    let mean = weighted / weights;
    let channel = |i: usize| solve_k(mean[i], seen[i].clamp(0.0, MAX_REFLECTANCE));
    let solved = [0, 1, 2].map(channel);
    (Rgb::from(solved.map(|(eta, _)| eta)), Rgb::from(solved.map(|(_, k)| k)))
}

fn normal_reflectance(eta: f64, k: f64) -> f64 {
    ((eta - 1.0).powi(2) + k * k) / ((eta + 1.0).powi(2) + k * k)
}

/// Returns (eta, k) with reflectance `r`: k for this eta, or another eta if there is no such k.
fn solve_k(eta: f64, r: f64) -> (f64, f64) {
    let squared = (r * (eta + 1.0).powi(2) - (eta - 1.0).powi(2)) / (1.0 - r);
    if squared >= 0.0 {
        return (eta, squared.sqrt());
    }
    let root = r.sqrt();
    ((1.0 + root) / (1.0 - root), 0.0)
}

/// Returns the spectrum of a parameter, or `None` if the parameter is absent.
pub(in crate::scene) fn optional(param: Option<&Param>) -> Result<Option<Spectrum>, SceneError> {
    param.map(Spectrum::from_param).transpose()
}

/// Returns the optical constants (eta, k) of copper, pbrt's default for conductors.
pub(in crate::scene) fn copper(location: &Location) -> Result<(Spectrum, Spectrum), SceneError> {
    let constant = |name| Spectrum::named(name).ok_or_else(|| location.invalid("copper's constants are missing"));
    Ok((constant("metal-Cu-eta")?, constant("metal-Cu-k")?))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: Rgb, b: [f64; 3], tolerance: f64) {
        assert!((a - Rgb::from(b)).abs().max_element() < tolerance, "{a} {b:?}");
    }

    fn metal(name: &str) -> Rgb {
        let named = |part| Spectrum::named(&format!("metal-{name}-{part}")).unwrap();
        let (eta, k) = conductor(&named("eta"), &named("k"));
        let r = |i: usize| normal_reflectance(eta[i], k[i]);
        Rgb::new(r(0), r(1), r(2))
    }

    #[test]
    fn daylight_is_white() {
        let white = response(daylight);
        let xyz_y = white.luminance;
        // The tables are coarse, and linear between their points.
        near(white.rgb / xyz_y, [1.0; 3], 0.004);
        near(under_daylight(|_| 1.0), [1.0; 3], 1e-12);
    }

    #[test]
    fn metals_have_the_colours_of_metals() {
        near(metal("Au"), [1.0, 0.77, 0.34], 0.03);
        near(metal("Ag"), [0.97, 0.96, 0.92], 0.02);
        near(metal("Al"), [0.91, 0.92, 0.92], 0.02);
        near(metal("Cu"), [0.955, 0.64, 0.54], 0.03);
        near(metal("CuZn"), [0.91, 0.78, 0.42], 0.08);
    }

    #[test]
    fn clear_crystals_absorb_nothing() {
        let named = |name| Spectrum::named(name).unwrap();
        let (eta, k) = conductor(&named("metal-MgO-eta"), &named("metal-MgO-k"));
        near(eta, [1.737, 1.74, 1.75], 0.01);
        assert!(k.max_element() < 0.05);
    }

    #[test]
    fn glasses_bend_as_their_makers_say() {
        // At the helium d line, 587.6 nm.
        let known = [1.51680, 1.67003, 1.48656, 1.85025, 1.67271, 1.72828, 1.78472];
        for (glass, eta) in GLASSES.iter().zip(known) {
            assert!((glass.eta(587.6) - eta).abs() < 3e-5, "{}", glass.name);
        }
        let crown = Spectrum::named("glass-BK7").unwrap().index(0.1..=10.0).mean;
        assert!((crown - 1.518).abs() < 1e-3);
    }

    #[test]
    fn black_bodies_have_luminance_one() {
        for (kelvin, expected) in [(6504.0, [1.043, 0.984, 1.036]), (2856.0, [1.845, 0.826, 0.233])] {
            let rgb = Spectrum::Blackbody(kelvin).light();
            near(rgb, expected, 0.01);
            let luminance = rgb.dot(Rgb::new(0.2126, 0.7152, 0.0722));
            assert!((luminance - 1.0).abs() < 0.01, "{kelvin} {luminance}");
        }
    }

    /// pbrt's black bodies have a largest value of 1, wherever that is.
    #[test]
    fn black_bodies_reflect_as_pbrt_has_them() {
        for (kelvin, nm, value) in [(5000.0, 579.55, 1.0), (6504.0, 445.54, 1.0), (2000.0, 700.0, 0.186098)] {
            assert!(
                (Spectrum::Blackbody(kelvin).at(nm) - value).abs() < 1e-4,
                "{}",
                Spectrum::Blackbody(kelvin).at(nm)
            );
        }
        // Nearly all of the visible light at 5500 K, redder and darker below that.
        let warm = Spectrum::Blackbody(2500.0).reflectance();
        assert!(warm.x > 2.0 * warm.y && warm.y > 2.0 * warm.z && warm.z > 0.0, "{warm}");
        let white = Spectrum::Blackbody(5500.0).reflectance();
        assert!(white.min_element() > 0.9 && white.max_element() <= 1.0, "{white}");
    }

    /// The green line of mercury is narrower than the spacing of the tables.
    #[test]
    fn narrow_lines_are_seen() {
        let line = Spectrum::Table(vec![[545.0, 0.0], [546.0, 1.0], [547.0, 0.0]]).light();
        assert!(line.x == 0.0 && line.y > 1.0 && line.z == 0.0, "{line}");
    }

    #[test]
    fn daylight_is_made_as_its_tables_say() {
        let phase = DaylightPhase::new(6500.0 * NEW_KELVIN);
        for (nm, _) in wavelengths() {
            assert!((phase.at(nm) - daylight(nm)).abs() < 0.06, "{nm}: {} {}", phase.at(nm), daylight(nm));
        }
        for (name, x, y) in
            [("stdillum-A", 0.44758, 0.40745), ("stdillum-D50", 0.34567, 0.35851), ("illum-acesD60", 0.32168, 0.33767)]
        {
            let spectrum = Spectrum::named(name).unwrap();
            let xyz: Rgb = wavelengths().map(|(nm, xyz)| xyz * spectrum.at(nm)).sum();
            let [found_x, found_y] = [xyz.x, xyz.y].map(|v| v / xyz.element_sum());
            assert!((found_x - x).abs() < 3e-4 && (found_y - y).abs() < 3e-4, "{name}: {found_x} {found_y}");
        }
    }

    #[test]
    fn reflectance_makes_a_conductor_that_reflects_it() {
        let (eta, k) = conductor_from_reflectance(Rgb::new(0.0, 0.5, 1.0));
        assert!((normal_reflectance(eta.y, k.y) - 0.5).abs() < 1e-12);
        assert!(k.is_finite() && k.x == 0.0);
    }

    #[test]
    fn tables_are_linear_between_their_points_and_zero_beyond() {
        let pairs = [[400.0, 1.0], [500.0, 3.0]];
        for (nm, value) in [(399.0, 0.0), (400.0, 1.0), (450.0, 2.0), (500.0, 3.0), (501.0, 0.0)] {
            assert_eq!(interpolate(&pairs, nm), value);
        }
    }
}
