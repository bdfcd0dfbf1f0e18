//! Single wavelengths as colours, for paths that glass has split by colour.

use std::ops::RangeInclusive;

use crate::scene::model::{ByWavelength, Index, Rgb};
use crate::scene::spectrum::data::{FIRST, LAST, OBSERVER};
use crate::scene::spectrum::{Spectrum, daylight, interpolated, response, response_of_daylight, rgb_from_xyz};

/// A range of wavelengths that a path takes with the same chance as any other range of [`Wavelengths`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Band {
    /// The shortest wavelength, nm.
    pub first: f64,
    /// What daylight of these wavelengths shows in linear RGB, over the chance of the band: some channels are
    /// negative, since single wavelengths lie outside of sRGB. The mean of all bands is white, (1, 1, 1).
    pub color: Rgb,
}

/// The visible wavelengths in bands of the same chance. The chance of a wavelength is proportional to the length of its
/// colour in daylight, so that all colours have about the same length: few paths carry little.
#[derive(Clone, Debug, PartialEq)]
pub struct Wavelengths {
    /// The bands, from short to long wavelengths.
    pub bands: Vec<Band>,
    /// The longest wavelength, nm.
    pub last: f64,
}

/// Distance of neighbouring wavelengths at which colours are summed, nm.
const FINE_STEP: f64 = 1.0 / 16.0;

impl Wavelengths {
    /// Returns `count` bands.
    pub fn new(count: u32) -> Self {
        let steps = ((LAST - FIRST) / FINE_STEP) as u32;
        let white = response_of_daylight().rgb;
        let line = |step: u32| {
            let nm = FIRST + FINE_STEP * (f64::from(step) + 0.5);
            rgb_from_xyz(interpolated(nm, |i| Rgb::from(OBSERVER[i].0))) * daylight(nm) / white
        };
        let lines: Vec<Rgb> = (0..steps).map(line).collect();
        let lengths: f64 = lines.iter().map(|line| line.length()).sum();
        let to_mean = f64::from(count) / lines.iter().sum::<Rgb>();
        let mut bands = vec![Band { first: FIRST, color: Rgb::ZERO }];
        let mut reached = 0.0;
        for (line, next) in lines.iter().zip(1..) {
            reached += line.length();
            if let Some(band) = bands.last_mut() {
                band.color += line * to_mean;
            }
            if reached * f64::from(count) >= lengths * bands.len() as f64 && bands.len() < count as usize {
                bands.push(Band { first: FIRST + FINE_STEP * f64::from(next), color: Rgb::ZERO });
            }
        }
        Self { bands, last: LAST }
    }

    /// Returns the first and the last wavelength of each band, nm.
    pub fn ranges(&self) -> impl Iterator<Item = [f64; 2]> {
        let ends = self.bands.iter().skip(1).map(|band| band.first).chain([self.last]);
        self.bands.iter().map(|band| band.first).zip(ends).map(|(first, last)| [first, last])
    }
}

impl Spectrum {
    /// Returns the curve of a light over that of daylight, which is the white of RGB; its largest value is 1. `None` if
    /// the light has the curve of daylight or is known as RGB.
    pub fn over_daylight(&self) -> Option<ByWavelength> {
        match self {
            Spectrum::Rgb(_) | Spectrum::OtherRgb(..) => None,
            _ => ByWavelength::new(|nm| self.at(nm) / daylight(nm)).map(|curve| curve.normalized()),
        }
    }

    /// Returns the curve of a coefficient of absorption; `None` if it is constant or known as RGB.
    pub fn coefficients(&self) -> Option<ByWavelength> {
        match self {
            Spectrum::Rgb(_) | Spectrum::OtherRgb(..) => None,
            _ => ByWavelength::new(|nm| self.at(nm)),
        }
    }

    /// Returns an index of refraction. Its curve is within `range`.
    pub fn index(&self, range: RangeInclusive<f64>) -> Index {
        let weighted = response(|nm| self.index_at(nm) * daylight(nm)).luminance;
        let curve = ByWavelength::new(|nm| self.index_at(nm).clamp(*range.start(), *range.end()));
        Index { mean: weighted / response_of_daylight().luminance, curve }
    }

    /// Returns the index at a wavelength in nm. Beyond the ends of a table it stays what it is there.
    fn index_at(&self, nm: f64) -> f64 {
        match self {
            Spectrum::Table(pairs) => match pairs[..] {
                [[first, _], .., [last, _]] => self.at(nm.clamp(first, last)),
                _ => self.at(nm),
            },
            _ => self.at(nm),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_of_all_bands_is_white_and_none_is_much_stronger() {
        let Wavelengths { bands, last } = Wavelengths::new(256);
        let white = bands.iter().map(|band| band.color).sum::<Rgb>() / 256.0;
        assert!((white - Rgb::ONE).abs().max_element() < 1e-12, "{white}");
        let ends: Vec<f64> = bands.iter().map(|band| band.first).chain([last]).collect();
        assert!(bands.len() == 256 && ends.is_sorted() && ends[1] > ends[0], "{ends:?}");
        let lengths = bands.iter().map(|band| band.color.length());
        let [least, most] = [lengths.clone().fold(f64::MAX, f64::min), lengths.fold(0.0, f64::max)];
        // A band may have a share of a line more or less than others: lines are about a tenth of the narrowest band.
        assert!(most / least < 1.3, "{least} {most}");
    }

    #[test]
    fn a_table_goes_on_beyond_its_ends_and_a_constant_has_no_curve() {
        let index = Spectrum::Table(vec![[500.0, 1.6], [600.0, 1.5]]).index(0.1..=10.0);
        let curve = index.curve.unwrap();
        for (nm, eta) in [(390.0, 1.6), (500.0, 1.6), (552.0, 1.548), (601.0, 1.5), (900.0, 1.5)] {
            assert!((curve.at(nm) - eta).abs() < 1e-12, "{nm}: {}", curve.at(nm));
        }
        assert!(index.mean > 1.54 && index.mean < 1.56, "{}", index.mean);
        assert_eq!(Spectrum::Table(vec![[500.0, 1.5], [600.0, 1.5]]).index(0.1..=10.0).curve, None);
        assert_eq!(Spectrum::Rgb(Rgb::new(1.4, 1.5, 1.6)).index(0.1..=10.0).curve, None);
    }

    /// Lights of any brightness have a curve, and its least value may be far below the largest.
    #[test]
    fn curves_of_lights_are_finite() {
        let table = |scale: f64| Spectrum::Table(vec![[400.0, scale], [700.0, 3.0 * scale]]);
        for spectrum in [table(1e-300), table(1e300), Spectrum::Blackbody(100.0), Spectrum::Blackbody(1e6)] {
            let curve = spectrum.over_daylight().unwrap();
            let most = curve.values().iter().copied().fold(0.0, f64::max);
            assert!(most == 1.0 && curve.values().iter().all(|value| (0.0..=1.0).contains(value)), "{curve:?}");
        }
        assert_eq!(Spectrum::Daylight.over_daylight(), None);
        assert_eq!(table(f64::MAX).over_daylight(), None);
    }

    #[test]
    fn the_curve_of_a_glass_is_near_its_formula() {
        let glass = Spectrum::named("glass-F11").unwrap();
        let curve = glass.index(0.1..=10.0).curve.unwrap();
        for nm in (380..=780).map(f64::from) {
            assert!((curve.at(nm) - glass.at(nm)).abs() < 2e-5, "{nm}: {} {}", curve.at(nm), glass.at(nm));
        }
    }
}
