//! How radii begin and how they shrink.

use crate::base::names::named;
use crate::kernels::RadiusPush;

/// How far a radius that follows the footprints of pixels may go from its median over the
/// image, as a factor.
const SPREAD: f64 = 2.0;
/// The median is rounded to so many steps per octave, so that a device's rounding does not
/// tell shards apart.
const STEPS: f64 = 8.0;

/// What decides the radius that a visible point starts with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstRadius {
    /// Radius over path length ..
    pub per_length: f32,
    /// .. and its bounds, render units.
    pub least: f32,
    /// At most this.
    pub most: f32,
}

impl FirstRadius {
    /// The same for all points; render units.
    pub fn constant(radius: f64) -> Self {
        Self { per_length: 0.0, least: radius as f32, most: radius as f32 }
    }

    /// Of a given width at the visible point, which is that of pixels there times so many. At
    /// distance 1 the width is `width`. `lengths` are those of one round of eye paths, 0 where there is no point.
    /// Without any, nothing will be gathered, and any radius does.
    pub fn from_footprints(width: f64, lengths: impl Iterator<Item = f32>) -> Self {
        let mut lengths: Vec<f32> = lengths.filter(|length| *length > 0.0).collect();
        if lengths.is_empty() {
            return Self::constant(1.0);
        }
        let middle = lengths.len() / 2;
        let (_, median, _) = lengths.select_nth_unstable_by(middle, f32::total_cmp);
        let rounded = ((f64::from(*median).log2() * STEPS).round() / STEPS).exp2();
        let radius = width * rounded;
        Self { per_length: width as f32, least: (radius / SPREAD) as f32, most: (radius * SPREAD) as f32 }
    }

    /// What the radius pass is told of an iteration.
    pub fn push(&self, pixel_count: u32, shrink: f64, first: bool) -> RadiusPush {
        let Self { per_length, least, most } = *self;
        RadiusPush { pixel_count, per_length, least, most, shrink: shrink as f32, first: first.into() }
    }
}

named! {
    /// How radii shrink.
    pub enum RadiusSchedule = Adaptive {
        /// By the photons that each pixel finds
        Adaptive: "adaptive",
        /// By the number of the iteration, for all pixels alike: iterations are independent of each other
        Global: "global",
    }
}

/// Iterations after which a product of as many factors is left to its series, which is then as
/// exact: a checkpoint may say that any number was done.
const MANY: u64 = 1 << 24;

/// The squared radius of the global schedule at an iteration, over the first: the product of
/// (i + α) / (i + 1) over the iterations before it (Knaus and Zwicker 2011, eq. 20). It starts
/// at i = 0, one earlier than theirs: then a disc that finds as many photons in every iteration
/// has the same radii under both schedules, and the mean of their squares is a power of N
/// sooner.
#[derive(Clone, Debug)]
pub struct GlobalShrink {
    alpha: f64,
    step: u64,
    value: f64,
}

impl GlobalShrink {
    /// At the first iteration.
    pub fn new(alpha: f64) -> Self {
        Self { alpha, step: 0, value: 1.0 }
    }

    /// At iteration `step`, from 0. Iterations are asked for in order, but for new rounds.
    pub fn at(&mut self, step: u64) -> f64 {
        if step > MANY {
            // Γ(n + α) / Γ(n + 1), to the second term of its series.
            let alpha = self.alpha;
            let series = |n: f64| n.powf(alpha - 1.0) * (1.0 + 0.5 * alpha * (alpha - 1.0) / n);
            return self.at(MANY) * (series(step as f64) / series(MANY as f64));
        }
        if step < self.step {
            *self = Self::new(self.alpha);
        }
        while self.step < step {
            let i = self.step as f64;
            self.step += 1;
            self.value *= (i + self.alpha) / (i + 1.0);
        }
        self.value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn global_radii_shrink_as_photons_to_the_alpha_minus_one() {
        let mut shrink = GlobalShrink::new(2.0 / 3.0);
        assert_eq!(shrink.at(0), 1.0);
        assert_eq!(shrink.at(1), 2.0 / 3.0);
        assert!((shrink.at(2) - 2.0 / 3.0 * (5.0 / 3.0) / 2.0).abs() < 1e-15);
        let [early, late] = [1_000, 1_000_000].map(|step| shrink.at(step));
        let slope = (late / early).ln() / 1000f64.ln();
        assert!((slope + 1.0 / 3.0).abs() < 1e-4, "{slope}");
        assert_eq!(shrink.at(1_000), early);
        // The series goes on where the product ends, and takes no time.
        for (a, b) in [(MANY, MANY + 1), (u64::MAX - 1, u64::MAX)] {
            let [a, b] = [a, b].map(|step| shrink.at(step));
            assert!(b <= a && b > a * (1.0 - 1e-7), "{a} {b}");
        }
        let slope = (shrink.at(1 << 40) / shrink.at(1 << 20)).log2() / 20.0;
        assert!((slope + 1.0 / 3.0).abs() < 1e-8, "{slope}");
    }

    #[test]
    fn footprints_follow_the_path_within_bounds() {
        let lengths = [0.0, 4.0, 1.0, 4.0, 4.0, 1000.0, 0.0];
        let radius = FirstRadius::from_footprints(0.03, lengths.into_iter());
        assert_eq!(radius.per_length, 0.03_f64 as f32);
        assert!((radius.most / radius.least - 4.0).abs() < 1e-5 && (radius.least - 0.06).abs() < 1e-6, "{radius:?}");
        assert_eq!(FirstRadius::from_footprints(0.03, std::iter::repeat_n(0.0, 3)), FirstRadius::constant(1.0));
    }
}
