//! Guided next-event estimation: the probability with which each light is picked, learned from the direct light that
//! the photons of a pilot bring to visible surfaces.
//!
//! If one light is picked for a sample, the variance is least with a probability proportional to the root of the mean
//! square of the light's contribution (by the Cauchy-Schwarz inequality). The mean is over places, which are groups of
//! neighbouring visible points. A contribution is relative to the direct light of its place.

use super::lights::morton_code;
use super::seen::{Brought, Seen};

/// The share of the probability that stays proportional to power. No light's probability falls below this share of its
/// probability by power.
const SHARE_OF_POWER: f64 = 0.25;
/// The least factor by which learned probabilities must lower the mean square of a sample.
const WORTHWHILE: f64 = 1.25;
/// The number of neighbouring visible points in a place.
const POINTS_OF_PLACE: usize = 16;

/// The light that a photon of a pilot brings straight from a light source to a visible point.
#[derive(Clone, Copy, Debug)]
pub struct Lit {
    /// The light at the point. Its sample is the photon's index.
    pub brought: Brought,
    /// The index of the light source.
    pub light: usize,
}

/// Returns the probabilities of lights that are learned from the photons of a pilot; `None` if probabilities by power are
/// about as good. `weights` has the weights of the photons, `power` is the power of all lights in W, and `by_power` has the
/// probabilities by power.
pub fn learn(seen: &Seen, lit: &[Lit], weights: &[f64], power: f64, by_power: &[f64]) -> Option<Vec<f64>> {
    let places = Places::of(seen);
    let term = |lit: &Lit| Term {
        light: lit.light,
        place: places.of_point[lit.brought.point as usize],
        radiance: lit.brought.radiance * weights[lit.brought.sample as usize] * power,
    };
    // Next-event estimation never picks a constant infinite light.
    let terms: Vec<Term> = lit.iter().map(term).filter(|term| by_power[term.light] > 0.0).collect();
    let importances = places.importances(seen, &terms);
    chances(&roots(by_power.len(), terms, &importances), by_power)
}

/// The radiance that one photon brings from a light to a place.
struct Term {
    light: usize,
    place: usize,
    radiance: f64,
}

/// Returns for each light the root of the mean square of its contribution to a place, relative to the direct light of the
/// place. Because photons are few, the mean square is estimated from pairs of different photons, and is at least the
/// square of the mean.
fn roots(lights: usize, mut terms: Vec<Term>, importances: &[f64]) -> Vec<f64> {
    terms.sort_by(|a, b| (a.light, a.place).cmp(&(b.light, b.place)).then(a.radiance.total_cmp(&b.radiance)));
    let places = importances.len() as f64;
    let mut roots = vec![0.0; lights];
    for of_light in terms.chunk_by(|a, b| a.light == b.light) {
        let (mut sum, mut squares) = (0.0, 0.0);
        for of_place in of_light.chunk_by(|a, b| a.place == b.place) {
            let importance = importances[of_place[0].place];
            let brought: f64 = of_place.iter().map(|term| term.radiance).sum();
            let of_each: f64 = of_place.iter().map(|term| term.radiance * term.radiance).sum();
            sum += importance.sqrt() * brought;
            squares += importance * (brought * brought - of_each);
        }
        roots[of_light[0].light] = f64::max((squares / places).max(0.0).sqrt(), sum / places);
    }
    roots
}

/// Returns the probabilities that follow from the roots; `None` if probabilities by power are about as good.
fn chances(roots: &[f64], by_power: &[f64]) -> Option<Vec<f64>> {
    let total: f64 = roots.iter().sum();
    if total <= 0.0 {
        return None;
    }
    let mix = |(root, chance): (&f64, &f64)| SHARE_OF_POWER * chance + (1.0 - SHARE_OF_POWER) * root / total;
    let learned: Vec<f64> = roots.iter().zip(by_power).map(mix).collect();
    let mean_square = |chances: &[f64]| -> f64 {
        let lit = roots.iter().zip(chances).filter(|(root, _)| **root > 0.0);
        lit.map(|(root, chance)| root * root / chance).sum()
    };
    (mean_square(by_power) > WORTHWHILE * mean_square(&learned)).then_some(learned)
}

/// The places of the visible points.
struct Places {
    of_point: Vec<usize>,
    count: usize,
}

impl Places {
    fn of(seen: &Seen) -> Self {
        let mut order: Vec<usize> = (0..seen.len()).collect();
        order.sort_by_key(|point| morton_code(seen.position(*point)));
        let mut of_point = vec![0; order.len()];
        for (rank, point) in order.iter().enumerate() {
            of_point[*point] = rank / POINTS_OF_PLACE;
        }
        Self { of_point, count: order.len().div_ceil(POINTS_OF_PLACE) }
    }

    /// Returns for each place 1 over the square of its direct light, which is estimated by photons and by eye paths.
    fn importances(&self, seen: &Seen, lit: &[Term]) -> Vec<f64> {
        let mut shown = vec![0.0; self.count];
        let by_photons = lit.iter().map(|term| (term.place, term.radiance));
        let by_eye_paths = (0..seen.len()).map(|point| (self.of_point[point], seen.direct(point)));
        for (place, radiance) in by_photons.chain(by_eye_paths) {
            // Both estimate the same light.
            shown[place] += 0.5 * radiance;
        }
        Seen::importances_of(&shown)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn term(light: usize, place: usize, radiance: f64) -> Term {
        Term { light, place, radiance }
    }

    #[test]
    fn roots_are_of_mean_squares_over_places() {
        // Of light 0, both places have 2 by two photons each: pairs of different photons give 2 of 4. Light 1 brings 3 to
        // one place by one photon, of which nothing but the mean is known. Light 2 brings nothing.
        let terms = vec![term(0, 0, 1.0), term(1, 1, 3.0), term(0, 1, 1.0), term(0, 0, 1.0), term(0, 1, 1.0)];
        assert_eq!(roots(3, terms, &[1.0, 1.0]), [2.0, 1.5, 0.0]);
    }

    #[test]
    fn a_lamp_that_alone_is_seen_is_chosen_most_and_no_chance_is_lost() {
        let by_power = vec![0.1; 10];
        let mut roots = vec![0.0; 10];
        roots[3] = 7.0;
        let chances = chances(&roots, &by_power).expect("other chances");
        assert!((chances[3] - 0.775).abs() < 1e-12 && (chances[0] - 0.025).abs() < 1e-12, "{chances:?}");
        assert!((chances.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        // Where power is about as good, nothing changes.
        assert_eq!(super::chances(&[1.1; 10], &by_power), None);
        assert_eq!(super::chances(&[0.0; 10], &by_power), None);
    }
}
