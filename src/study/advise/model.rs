//! A model of the parts of an image's error, and of how they fall with iterations.

use serde::Serialize;

use super::goal::Goal;
use crate::render::radius::GlobalShrink;

/// Settings that can be advised.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choice {
    /// Eye paths of a pixel and iteration.
    pub eye_paths: u32,
    /// Initial radius over the default one.
    pub radius: f64,
    /// Photons of an iteration over the default number.
    pub photons: f64,
}

impl Choice {
    /// The default settings.
    pub const DEFAULT: Self = Self { eye_paths: crate::render::options::DEFAULT_EYE_PATHS, radius: 1.0, photons: 1.0 };

    /// Returns all choices that are considered.
    pub fn all() -> impl Iterator<Item = Self> {
        let radii = [0.5, 0.7, 1.0, 1.4, 2.0];
        let photons = [0.25, 0.5, 1.0, 2.0, 4.0];
        [1, 2, 4, 8].into_iter().flat_map(move |eye_paths| {
            radii.into_iter().flat_map(move |radius| photons.map(|photons| Self { eye_paths, radius, photons }))
        })
    }
}

/// The parts of the squared relative error: absolute, or as shares that add up to 1.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Parts {
    /// Noise of eye paths: direct light and edges.
    pub eye: f64,
    /// Noise of photons.
    pub photons: f64,
    /// Blur: the bias from gathering photons on discs.
    pub blur: f64,
}

/// A prediction for settings.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Expected {
    /// Number of iterations.
    pub iterations: u32,
    /// Seconds of iterations.
    pub seconds: f64,
    /// Root mean square over pixels of the error over the luminance, noise and blur together. Dark
    /// pixels count as in [`crate::image::estimate::Estimate::relative_error`], and the 0.1 % worst
    /// pixels are left out, as in [`crate::image::compare::Gates`].
    pub error: f64,
    /// The parts as shares of the squared error.
    pub parts: Parts,
}

impl Parts {
    fn sum(self) -> f64 {
        self.eye + self.photons + self.blur
    }
}

/// A model that is fitted to a probe. Its squared errors are relative, and those of an image of one
/// iteration with the default settings.
#[derive(Clone, Copy, Debug)]
pub struct Model {
    /// Share of new photons that is kept while the radius shrinks.
    pub alpha: f64,
    /// Squared noise that falls as 1 / (eye paths of an iteration), at the default number of these.
    pub eye: f64,
    /// Squared noise that falls with iterations only.
    pub iteration: f64,
    /// Squared noise of photons, in proportion to 1 / r² and 1 / photons.
    pub photons: f64,
    /// Blur: the root of its square.
    pub blur: f64,
    /// Blur is in proportion to r to this power: 2 in smooth light, 1/2 if all blur is at edges.
    pub blur_power: f64,
    /// Seconds of an iteration.
    pub seconds: Seconds,
    /// Seconds before the first iteration: of the guide's pilot.
    pub start: f64,
}

/// Seconds of an iteration with the default settings.
#[derive(Clone, Copy, Debug, Default)]
pub struct Seconds {
    /// For one eye path of each pixel.
    pub eye_path: f64,
    /// In proportion to photons.
    pub photons: f64,
    /// In proportion to photons and to the area of discs.
    pub gather: f64,
    /// Independent of the settings.
    pub rest: f64,
}

/// The numbers of pixels and of photons of a short render over those of the full image.
#[derive(Clone, Copy, Debug)]
pub struct Size {
    /// That of pixels.
    pub pixels: f64,
    /// That of photons of an iteration.
    pub photons: f64,
}

impl Size {
    /// The size of the full image.
    pub const FULL: Self = Self { pixels: 1.0, photons: 1.0 };

    /// Returns the factors from this size to the full one.
    pub fn inverse(self) -> Self {
        Self { pixels: self.pixels.recip(), photons: self.photons.recip() }
    }
}

impl Seconds {
    /// Returns the seconds of an iteration with other numbers of pixels and of photons, by these factors.
    pub fn scaled(self, by: Size) -> Self {
        let Self { eye_path, photons, gather, rest } = self;
        Self {
            eye_path: by.pixels * eye_path,
            photons: by.photons * photons,
            gather: by.pixels * by.photons * gather,
            rest: by.pixels * rest,
        }
    }

    /// Returns the seconds of an iteration of a choice.
    pub fn of(self, choice: Choice) -> f64 {
        let Self { eye_path, photons, gather, rest } = self;
        f64::from(choice.eye_paths) * eye_path + choice.photons * (photons + choice.radius.powi(2) * gather) + rest
    }
}

/// The largest number of iterations that is predicted.
const MOST: u32 = 1 << 30;

/// Sums over iterations of powers of the radius, which shrinks: noise and blur of an image are in
/// proportion to them (Knaus and Zwicker 2011, section 4).
struct Sums {
    noise: f64,
    blur: f64,
}

impl Sums {
    /// Sums over `n` iterations, with the radius of the first as unit. Beyond a number of iterations the
    /// sum is approximated by an integral.
    fn new(alpha: f64, blur_power: f64, n: u32) -> Self {
        /// Iterations that are summed one by one.
        const EXACT: u32 = 4096;
        let mut shrink = GlobalShrink::new(alpha);
        let mut sums = Self { noise: 0.0, blur: 0.0 };
        for i in 0..n.min(EXACT) {
            let area = shrink.at(i.into());
            sums.noise += 1.0 / area;
            sums.blur += area.powf(0.5 * blur_power);
        }
        if n > EXACT {
            // From there on the area is in proportion to i^(α - 1).
            let area = shrink.at((EXACT - 1).into());
            let [from, to] = [EXACT, n].map(f64::from);
            let integral = |power: f64| from * ((to / from).powf(power + 1.0) - 1.0) / (power + 1.0);
            sums.noise += integral(1.0 - alpha) / area;
            sums.blur += area.powf(0.5 * blur_power) * integral(0.5 * blur_power * (alpha - 1.0));
        }
        sums
    }
}

impl Model {
    /// Returns the parts of the squared error after `n` iterations.
    pub fn parts(&self, choice: Choice, n: u32) -> Parts {
        let sums = Sums::new(self.alpha, self.blur_power, n);
        let count = f64::from(n);
        let eye_paths = f64::from(choice.eye_paths) / f64::from(Choice::DEFAULT.eye_paths);
        Parts {
            eye: (self.eye / eye_paths + self.iteration) / count,
            photons: self.photons / (choice.radius.powi(2) * choice.photons) * sums.noise / (count * count),
            blur: (self.blur * choice.radius.powf(self.blur_power) * sums.blur / count).powi(2),
        }
    }

    /// Returns the seconds of an iteration.
    pub fn seconds_of(&self, choice: Choice) -> f64 {
        self.seconds.of(choice)
    }

    /// Predicts error and time at the iteration that reaches a goal.
    pub fn expect(&self, choice: Choice, goal: Goal) -> Expected {
        let iterations = match goal {
            Goal::Time(seconds) => {
                ((seconds - self.start) / self.seconds_of(choice)).ceil().clamp(1.0, f64::from(MOST)) as u32
            }
            Goal::Error(error) => self.iterations_for(choice, error),
        };
        self.after(choice, iterations)
    }

    /// Predicts error and time after this number of iterations.
    pub fn after(&self, choice: Choice, iterations: u32) -> Expected {
        let parts = self.parts(choice, iterations);
        let sum = parts.sum();
        let share = |part: f64| if sum > 0.0 { part / sum } else { 0.0 };
        let parts = Parts { eye: share(parts.eye), photons: share(parts.photons), blur: share(parts.blur) };
        Expected {
            iterations,
            seconds: self.start + f64::from(iterations) * self.seconds_of(choice),
            error: sum.sqrt(),
            parts,
        }
    }

    /// Returns the least number of iterations with an error of at most `error`, by bisection: the error
    /// never grows with iterations.
    fn iterations_for(&self, choice: Choice, error: f64) -> u32 {
        let reached = |n: u32| self.parts(choice, n).sum() <= error * error;
        let (mut too_few, mut enough) = (0, 1);
        while enough < MOST && !reached(enough) {
            (too_few, enough) = (enough, enough * 2);
        }
        while enough - too_few > 1 {
            let middle = too_few + (enough - too_few) / 2;
            if reached(middle) {
                enough = middle;
            } else {
                too_few = middle;
            }
        }
        enough
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn model() -> Model {
        let seconds = Seconds { eye_path: 0.1, photons: 0.2, gather: 0.3, rest: 0.1 };
        Model {
            alpha: 2.0 / 3.0,
            eye: 0.5,
            iteration: 0.5,
            photons: 4.0,
            blur: 0.1,
            blur_power: 2.0,
            seconds,
            start: 0.25,
        }
    }

    #[test]
    fn noise_of_photons_falls_as_the_power_alpha_and_blur_as_its_complement() {
        let parts = |n| model().parts(Choice::DEFAULT, n);
        let slope = |a: f64, b: f64| (b / a).ln() / 16_f64.ln();
        let (early, late) = (parts(1 << 16), parts(1 << 20));
        assert!((slope(early.eye, late.eye) + 1.0).abs() < 1e-9);
        assert!((slope(early.photons, late.photons) + 2.0 / 3.0).abs() < 0.01);
        assert!((slope(early.blur, late.blur) + 2.0 / 3.0).abs() < 0.01);
    }

    #[test]
    fn long_sums_go_on_where_short_ones_end() {
        let exact = |n: u32| {
            let mut shrink = GlobalShrink::new(2.0 / 3.0);
            let areas: Vec<f64> = (0..n).map(|i| shrink.at(i.into())).collect();
            [areas.iter().map(|area| 1.0 / area).sum::<f64>(), areas.iter().map(|area| area.sqrt()).sum()]
        };
        for n in [1, 4096, 4097, 100_000] {
            let Sums { noise, blur } = Sums::new(2.0 / 3.0, 1.0, n);
            for (sum, expected) in [noise, blur].into_iter().zip(exact(n)) {
                assert!((sum / expected - 1.0).abs() < 1e-3, "{n}: {sum}, {expected}");
            }
        }
    }

    #[test]
    fn a_time_for_an_error_is_that_error_after_the_time() {
        for choice in Choice::all() {
            for error in [0.5, 0.1, 0.02] {
                let there = model().expect(choice, Goal::Error(error));
                let back = model().expect(choice, Goal::Time(there.seconds * (1.0 - 1e-9)));
                assert_eq!(there.iterations, back.iterations);
                assert!(there.error <= error && (there.iterations == 1 || there.error > 0.9 * error), "{there:?}");
            }
        }
        assert!(Choice::all().any(|choice| choice == Choice::DEFAULT));
    }
}
