//! The share of light that the underside of a coat reflects back to its base.

use crate::kernels::{COAT_FINEST, COAT_OCTAVES, COAT_STEPS};

/// What is under a coat.
#[derive(Clone, Copy, Debug)]
pub(super) enum Base {
    /// A Lambertian surface.
    Lambertian,
    /// A metal with GGX's alpha.
    Facets {
        /// GGX's alpha, 0 or more.
        alpha: f64,
    },
}

impl Base {
    /// Returns the fraction of the base's light that the coat sends back to it. `eta` is the index of the coat
    /// over that outside, `thickness` is that of absorption alone.
    pub fn sent_back(self, eta: f64, thickness: f64) -> f64 {
        match self {
            Self::Lambertian => sent_back_diffusely(eta, thickness),
            Self::Facets { alpha } => sent_back_by_facets(eta, thickness, alpha),
        }
    }

    /// Returns a key that tells tables apart.
    pub fn key(self, eta: f64) -> Vec<u64> {
        match self {
            Self::Lambertian => vec![eta.to_bits()],
            Self::Facets { alpha } => vec![eta.to_bits(), alpha.to_bits()],
        }
    }

    /// Returns [`Self::sent_back`] at the thicknesses of a table, as `shaders/include/material/coat_table.glsl` reads
    /// it: each element has the bits of two neighbours.
    pub fn table(self, eta: f64) -> impl Iterator<Item = [u32; 4]> {
        let value = move |i: u32| (self.sent_back(eta, thickness_at(i)) as f32).to_bits();
        (0..COAT_OCTAVES * COAT_STEPS + 1).map(move |i| [value(i), value(i + 1), 0, 0])
    }
}

/// Returns the thickness of an entry of a table. It is 0 at the first one, and grows geometrically from the second.
pub(super) fn thickness_at(i: u32) -> f64 {
    if i == 0 { 0.0 } else { (f64::from(i - 1) / f64::from(COAT_STEPS) - f64::from(COAT_FINEST)).exp2() }
}

/// Returns the reflectance of a boundary between dielectrics for unpolarised light; `eta` is the index of
/// the far side over that of the near side.
pub(super) fn fresnel(cos_i: f64, eta: f64) -> f64 {
    let sin2_t = (1.0 - cos_i * cos_i) / (eta * eta);
    if sin2_t >= 1.0 {
        return 1.0;
    }
    let cos_t = (1.0 - sin2_t).sqrt();
    let parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    let perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    0.5 * (parallel * parallel + perpendicular * perpendicular)
}

const STEPS: u32 = 512;

/// Returns the mean of `value` over quantiles in [0, 1], by the midpoint rule.
fn mean_over(value: impl Fn(f64) -> f64) -> f64 {
    (0..STEPS).map(|i| value((f64::from(i) + 0.5) / f64::from(STEPS))).sum::<f64>() / f64::from(STEPS)
}

/// Returns the fraction of the light from a Lambertian surface that its coat reflects back to it.
fn sent_back_diffusely(eta: f64, thickness: f64) -> f64 {
    mean_over(|quantile| {
        let cos = quantile.sqrt();
        fresnel(cos, 1.0 / eta) * (-2.0 * thickness / cos).exp()
    })
}

/// Returns the fraction of the light from microfacets, lit perpendicularly, that their coat reflects back
/// (Walter and others 2007, eq. 35).
fn sent_back_by_facets(eta: f64, thickness: f64, alpha: f64) -> f64 {
    mean_over(|quantile| {
        let cos2 = (1.0 - quantile) / (1.0 - quantile + alpha * alpha * quantile);
        let cos = 2.0 * cos2 - 1.0; // of twice the facet's angle
        if cos <= 0.0 {
            return 0.0;
        }
        fresnel(cos, 1.0 / eta) * (-thickness * (1.0 + 1.0 / cos)).exp()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks the loss of Lambertian light at a boundary: the mean over the outside of 1 - F is eta² times
    /// the mean over the inside, because both are the same beams.
    #[test]
    fn a_coat_sends_back_what_reciprocity_says() {
        for eta in [1.0, 1.33, 1.5, 2.5] {
            let outside = mean_over(|quantile| fresnel(quantile.sqrt(), eta));
            let inside = sent_back_diffusely(eta, 0.0);
            assert!(((1.0 - inside) * eta * eta - (1.0 - outside)).abs() < 0.01, "{eta}: {inside} {outside}");
        }
    }

    #[test]
    fn smooth_facets_send_back_the_reflectance_straight_up() {
        assert!((sent_back_by_facets(1.5, 0.0, 0.0) - 0.04).abs() < 1e-12);
        let dim = sent_back_by_facets(1.5, 0.5, 0.0);
        assert!((dim - 0.04 * (-1.0_f64).exp()).abs() < 1e-12);
    }

    /// Between the entries of the table, which are a quarter of an octave apart.
    #[test]
    fn tables_are_near_what_they_stand_for() {
        for base in [Base::Lambertian, Base::Facets { alpha: 0.3 }] {
            let table: Vec<_> = base.table(1.5).collect();
            for (i, pair) in table.iter().enumerate() {
                let [low, high] = [pair[0], pair[1]].map(|bits| f64::from(f32::from_bits(bits)));
                let [from, to] = [thickness_at(i as u32), thickness_at(i as u32 + 1)];
                let middle = if i == 0 { 0.5 * to } else { (from * to).sqrt() };
                let exact = base.sent_back(1.5, middle);
                assert!((0.5 * (low + high) - exact).abs() < 1e-3, "{base:?} at {middle}: {low} {high} {exact}");
            }
            assert!(f32::from_bits(table[table.len() - 1][1]) < 1e-6, "{base:?}");
        }
    }
}
