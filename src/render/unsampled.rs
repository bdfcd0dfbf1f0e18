//! A lower bound of the error of an image: the light that one more photon would add.
//!
//! The error of an image is estimated from the difference between two halves of its iterations. If nearly
//! all photons land outside the view, neither half has recorded a photon near a visible point, and both
//! halves agree on an image without the light of photons. The image may then lack the light of about one
//! photon: if one photon is expected, none may be found by chance. So the error is never reported as smaller
//! than the light of one photon.

use crate::image::estimate::Estimate;
use crate::render::options::{Contribution, DirectLight, Options};

/// The share of the image's radiance that may be unknown before a render reports missing light.
const NOTABLE: f64 = 0.01;
/// Recorded photons are few if they are less than this share of the emitted photons.
const FEW: f64 = 0.001;

/// The estimated error of an image, and the smallest error that is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// The error from the two halves of the iterations: [`Estimate::relative_error`].
    pub of_halves: Option<f64>,
    /// The light that one photon adds to an image if it is spread evenly over the surfaces that are seen: the
    /// mean radiance divided by the median of the pixels that are not black. 0 if photons cannot contribute;
    /// infinite if photons could contribute to an image that is black.
    pub of_one_photon: f64,
}

impl Noise {
    /// Returns the larger of both errors. `None` before both halves have an iteration, and if photons could
    /// contribute to an image that is black.
    pub fn relative_error(&self) -> Option<f64> {
        self.of_halves.map(|error| error.max(self.of_one_photon)).filter(|error| error.is_finite())
    }

    /// Returns whether light may be missing from the image of a render that emitted `emitted` photons and
    /// recorded `recorded` of them.
    pub fn misses_light(&self, emitted: u64, recorded: u64) -> bool {
        // If n photons were recorded, n + 1 may have been expected, with a standard deviation of sqrt(n + 1).
        let expected = recorded as f64 + 1.0;
        let few = expected < FEW * emitted as f64 && expected.sqrt() * self.of_one_photon > NOTABLE;
        few || (self.of_one_photon > NOTABLE && self.of_halves.is_some_and(|error| error < self.of_one_photon))
    }
}

/// Returns the mean radiance that one watt adds to an image if it is spread evenly over the surfaces that are
/// seen, or over a disc of `radius` if their area is smaller; 1/(m² sr) in render units. `pixels` has for
/// each pixel BSDF times throughput in 1/sr for red, green and blue, and the length of its eye path, 0 if
/// there is no visible point; `luminance` has the weights of red, green and blue. A pixel is `width` wide at distance 1, or at any distance if rays are parallel.
pub fn response(
    pixels: impl ExactSizeIterator<Item = [f32; 4]>,
    luminance: [f64; 3],
    width: f64,
    is_parallel: bool,
    radius: f64,
) -> f64 {
    let count = pixels.len() as f64;
    let (mut bsdfs, mut area) = (0.0, 0.0);
    for [red, green, blue, length] in pixels.filter(|pixel| pixel[3] > 0.0) {
        let bsdf = [red, green, blue].map(f64::from);
        bsdfs += bsdf.iter().zip(luminance).map(|(bsdf, weight)| bsdf * weight).sum::<f64>();
        area += (if is_parallel { width } else { width * f64::from(length) }).powi(2);
    }
    let area = f64::max(area, std::f64::consts::PI * radius * radius);
    if bsdfs > 0.0 { bsdfs / (count * area) } else { 0.0 }
}

/// Returns [`Noise::of_one_photon`] for a photon of `flux` W in an image with this [`response`]. `unit` is
/// the unit of the estimate before exposure.
pub fn of_one_photon(response: f64, flux: f64, unit: f64, estimate: &Estimate) -> f64 {
    if response == 0.0 {
        return 0.0;
    }
    estimate.median_lit().map_or(f64::INFINITY, |median| response * flux / (unit * median))
}

/// Returns whether photons may contribute light that eye paths do not.
pub fn photons_matter(options: &Options, max_depth: u32, is_plane: bool) -> bool {
    // If eye paths contribute direct light, a photon is not recorded at its first surface.
    let records = options.direct == DirectLight::Photons || (max_depth > 1 && !is_plane);
    options.contribution != Contribution::Direct && records
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn photons_matter_where_they_can_record_something() {
        let nee = Options::default();
        let photons = Options { direct: DirectLight::Photons, ..Options::default() };
        let direct = Options { contribution: Contribution::Direct, ..Options::default() };
        for (options, max_depth, is_plane, expected) in [
            (&nee, 5, false, true),
            (&nee, 1, false, false),
            (&nee, 5, true, false),
            (&photons, 1, true, true),
            (&direct, 5, false, false),
        ] {
            assert_eq!(photons_matter(options, max_depth, is_plane), expected, "{options:?} {max_depth} {is_plane}");
        }
    }

    /// Two of four pixels have a visible point, with BSDFs of 0.1 and 0.3, at distances of 1 and 2: an area
    /// of 0.01 (1 + 4).
    #[test]
    fn a_watt_is_spread_over_what_is_seen() {
        let pixels = [[0.1, 0.1, 0.1, 1.0], [0.0; 4], [0.3, 0.3, 0.3, 2.0], [9.0, 9.0, 9.0, 0.0]];
        let near = |value: f64, expected: f64| assert!((value / expected - 1.0).abs() < 1e-6, "{value}");
        let weights = [0.25, 0.5, 0.25];
        near(response(pixels.into_iter(), weights, 0.1, false, 0.1), 0.1 / 0.05);
        near(response(pixels.into_iter(), weights, 0.1, true, 0.01), 0.1 / 0.02);
        near(response(pixels.into_iter(), weights, 0.1, true, 1.0), 0.1 / std::f64::consts::PI);
        let red = [[0.2, 0.0, 0.0, 1.0]];
        near(response(red.into_iter(), weights, 0.1, true, 0.01), 0.05 / 0.01);
        assert_eq!(response([[0.0, 0.0, 0.0, 1.0]].into_iter(), weights, 0.1, false, 0.1), 0.0, "all is black");
    }

    #[test]
    fn an_error_is_not_known_below_the_light_of_one_photon() {
        let noise = |of_halves, of_one_photon| Noise { of_halves, of_one_photon };
        assert_eq!(noise(Some(0.01), 0.2).relative_error(), Some(0.2));
        assert_eq!(noise(Some(0.3), 0.2).relative_error(), Some(0.3));
        assert_eq!(noise(None, 0.2).relative_error(), None);
        assert_eq!(noise(Some(0.0), f64::INFINITY).relative_error(), None, "a black image");
        assert_eq!(noise(Some(0.0), 0.0).relative_error(), Some(0.0), "black surfaces");
    }

    #[test]
    fn light_is_missed_where_photons_are_few_and_each_would_be_seen() {
        let noise = |of_halves, of_one_photon| Noise { of_halves: Some(of_halves), of_one_photon };
        assert!(noise(0.01, 0.2).misses_light(10_000, 0));
        assert!(noise(0.3, 0.2).misses_light(10_000, 5));
        assert!(noise(0.3, 0.005).misses_light(100_000, 26), "known to a fifth, and as bright as a fortieth");
        assert!(noise(0.01, f64::INFINITY).misses_light(10_000, 0));
        assert!(noise(0.01, 0.2).misses_light(10_000, 9000), "they are elsewhere: the halves know of none");
        assert!(!noise(0.3, 0.2).misses_light(10_000, 9000), "noise of many photons");
        assert!(!noise(0.3, 0.2).misses_light(100, 0), "so few that none tells nothing");
        assert!(!noise(0.001, 1e-5).misses_light(10_000, 0), "nobody would notice");
        assert!(!noise(0.0, 0.0).misses_light(0, 0));
    }
}
