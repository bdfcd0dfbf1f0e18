//! The initial radii of visible points, and the global schedule by which radii shrink.

use crate::base::names::named;
use crate::kernels::RadiusPush;

/// The largest factor between a radius that follows the footprints of pixels and the median radius of the
/// image.
const SPREAD: f64 = 2.0;
/// The number of steps per octave to which the median is rounded, so that all shards have the same median
/// in spite of a device's rounding.
const STEPS: f64 = 8.0;

/// The initial radius of a visible point as a function of the length of its eye path: proportional to the
/// length, within bounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstRadius {
    /// Radius over path length.
    pub per_length: f32,
    /// The smallest radius in render units.
    pub least: f32,
    /// The largest radius in render units.
    pub most: f32,
}

impl FirstRadius {
    /// Returns a radius that is the same for all points, in render units.
    pub fn constant(radius: f64) -> Self {
        Self { per_length: 0.0, least: radius as f32, most: radius as f32 }
    }

    /// Returns a radius that follows the footprints of pixels. `width` is the radius of a visible point at
    /// distance 1, in render units. `lengths` are the lengths of the eye paths of one round, 0 for pixels
    /// without a visible point. If no pixel has one, nothing is gathered, and the radius is 1.
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

    /// Returns the radius of most visible points in render units: the geometric mean of the smallest and the largest.
    pub fn middle(&self) -> f64 {
        (f64::from(self.least) * f64::from(self.most)).sqrt()
    }

    /// Returns the radius of a visible point at the end of an eye path of this length, in render units.
    pub fn at(&self, length: f64) -> f64 {
        (f64::from(self.per_length) * length).clamp(self.least.into(), self.most.into())
    }

    /// Returns the push constants of the radius pass for an iteration: the size of the image in pixels, the factor of
    /// the squared radius that is the same for all of them, the number of the iteration among those that share the
    /// pixels' statistics, from 0, and whether the statistics begin with it.
    pub fn push(&self, [width, height]: [u32; 2], shrink: f64, step: u64, first: bool) -> RadiusPush {
        let Self { per_length, least, most } = *self;
        RadiusPush {
            pixel_count: width * height,
            per_length,
            least,
            most,
            shrink: shrink as f32,
            first: first.into(),
            width,
            iterations: step as f32 + 1.0,
        }
    }
}

/// The radii of rough points in an iteration. They shrink by the number of the iteration under every schedule: a pixel's
/// rough points may lie on other surfaces in every iteration, so that the photons which one finds tell nothing of the
/// next.
#[derive(Clone, Copy, Debug)]
pub struct RoughRadii {
    first: FirstRadius,
    /// The factor of squared radii.
    shrink: f64,
}

impl RoughRadii {
    /// Returns the radii whose squares are those of an initial radius times `shrink`.
    pub fn new(first: FirstRadius, shrink: f64) -> Self {
        Self { first, shrink }
    }

    /// Returns radius over path length, the smallest and the largest initial radius, and the factor of their squares.
    pub fn values(&self) -> [f32; 4] {
        let FirstRadius { per_length, least, most } = self.first;
        [per_length, least, most, self.shrink as f32]
    }

    /// Returns the square of the largest radius, in square render units.
    pub fn largest2(&self) -> f64 {
        f64::from(self.first.most).powi(2) * self.shrink
    }
}

/// The name of the schedule in the identity of a render.
pub(crate) const RADIUS_SCHEDULE: &str = "radius schedule";

named! {
    /// How radii shrink.
    pub enum RadiusSchedule = Adaptive {
        /// Each pixel's radius shrinks as the pixel finds photons
        Adaptive: "adaptive",
        /// All radii shrink by the same factor in each iteration; --shard needs this, or --integrator ppm
        Global: "global",
        /// Each pixel has the radius with the least error, estimated from its photons and those of its neighbours
        Data: "data",
    }
}

/// The number of iterations after which the sums of discs are halved (`shaders/include/lookup/data_radius.glsl`). So
/// a sum is at most 2^19 times what an iteration adds on average, and an f32, which rounds by a part in 2^24 or less,
/// rounds that by a part in 32 at most, however long the render.
const ITERATIONS_OF_SUMS: u64 = 1 << 18;

/// Returns the share of the sums of discs that stays when iteration `step` is added to them, counted from 0.
pub fn kept_of_sums(step: u64) -> f32 {
    if step > 0 && step.is_multiple_of(ITERATIONS_OF_SUMS) { 0.5 } else { 1.0 }
}

/// The number of iterations after which [`GlobalShrink`] uses a series instead of a product. The series is
/// as exact by then, and takes no time for the large numbers of iterations that a checkpoint may have.
const MANY: u64 = 1 << 24;

/// The squared radius of the global schedule at an iteration, divided by the initial squared radius: the
/// product of (i + α) / (i + 1) over the iterations before it (Knaus and Zwicker 2011, eq. 20). The product
/// starts at i = 0, one earlier than in the paper. So a disc that finds the same number of photons in every
/// iteration has the same radii under both schedules, and the mean of the squared radii approaches a power
/// of the number of iterations sooner.
#[derive(Clone, Debug)]
pub struct GlobalShrink {
    alpha: f64,
    step: u64,
    value: f64,
}

impl GlobalShrink {
    /// Returns the schedule at the first iteration.
    pub fn new(alpha: f64) -> Self {
        Self { alpha, step: 0, value: 1.0 }
    }

    /// Returns the value at iteration `step`, counted from 0. Increasing steps are fast; a smaller `step`, as
    /// at the start of a round, starts the product again.
    pub fn at(&mut self, step: u64) -> f64 {
        if step > MANY {
            // Γ(n + α) / Γ(n + 1), to the second term of its series in 1 / n.
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
    fn sums_of_discs_are_halved_before_they_lose_digits() {
        let (mut sum, mut exact, mut halved) = (0.0_f32, 0.0_f64, 0);
        for step in 0..3 * ITERATIONS_OF_SUMS {
            let kept = kept_of_sums(step);
            halved += u32::from(kept < 1.0);
            sum = kept * sum + 0.1;
            exact = f64::from(kept) * exact + f64::from(0.1_f32);
        }
        assert!(halved == 2 && (f64::from(sum) / exact - 1.0).abs() < 1.0 / 32.0, "{sum} {exact}");
        assert!(sum < 2.0 * 0.1 * ITERATIONS_OF_SUMS as f32);
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
