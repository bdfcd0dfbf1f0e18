//! The choice of the numbers of photons and of eye paths per iteration with which noise falls fastest.
//!
//! A trial measures E, the squared noise with one eye path per pixel; P, the squared noise with one photon; and their
//! work, e and q. With n eye paths and p photons, the squared noise is E / n + P / p, and the work is e n + q p. The
//! product of noise and work is the squared noise after a unit of work. It is least if n / p = sqrt(E q / (P e)). A
//! third part of the noise depends on the number of iterations only. It limits how much a choice can gain.
//!
//! The trial counts work and does not measure time. Counts are the same on every device, so that every shard makes the
//! same choice.

use std::fmt;
use std::time::Duration;

/// The numbers that a trial chooses; the others are given.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Auto {
    /// The number of photons.
    pub photons: bool,
    /// The number of eye paths.
    pub eye_paths: bool,
}

impl Auto {
    /// Returns whether a trial chooses any number.
    pub fn is_any(self) -> bool {
        self.photons || self.eye_paths
    }
}

/// The numbers of an iteration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Counts {
    /// Photons of an iteration.
    pub photons: u64,
    /// Eye paths of a pixel.
    pub eye_paths: u32,
}

/// The noise and the work that a trial has found. Noise is squared, and relative to the image's luminance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trial {
    /// Noise of eye paths in an iteration with one eye path per pixel.
    pub eye_noise: f64,
    /// Noise of photons in an iteration with one photon.
    pub photon_noise: f64,
    /// Noise of an iteration that does not depend on either number. Only the last eye path of a pixel gathers photons, so
    /// the light of photons is noisy at edges, in textures and in reflections.
    pub other_noise: f64,
    /// Work of an iteration with one eye path per pixel, in units of an eye path's work.
    pub eye_work: f64,
    /// Work of a photon, in units of an eye path's work.
    pub photon_work: f64,
    /// Whether photons may contribute light that eye paths cannot find.
    pub photons_matter: bool,
}

/// What a trial has chosen, and why. It prints as one line.
#[derive(Clone, Copy, Debug)]
pub struct Choice {
    /// What the trial has found.
    pub trial: Trial,
    /// The numbers without the trial: given ones, or defaults.
    pub usual: Counts,
    /// The numbers that the trial has chosen.
    pub taken: Counts,
    /// The time that the trial took.
    pub time: Duration,
}

impl fmt::Display for Choice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { trial, usual, taken, .. } = self;
        let percent = |part: f64, of: f64| if of > 0.0 { 100.0 * part / of } else { 0.0 };
        let shares = |counts: Counts| {
            let ([eye, photons], all) = (trial.noise(counts), trial.all_noise(counts));
            let [eye_work, photon_work] = trial.work(counts);
            let work = percent(eye_work, eye_work + photon_work);
            let [eye, photons] = [eye, photons].map(|noise| percent(noise, all));
            format!(
                "eye paths cause {eye:.0} % of the noise and take {work:.0} % of the work, photons cause {photons:.0} % and \
                 take {:.0} %",
                100.0 - work
            )
        };
        let Counts { photons, eye_paths } = taken;
        write!(f, "eye paths {eye_paths}, photons {photons}")?;
        if trial.noise(*usual) == [0.0; 2] {
            return write!(f, ", as without the trial, which has found no noise");
        }
        if taken == usual {
            let least = 100.0 * (1.0 - WORTHWHILE);
            let shares = shares(*usual);
            return write!(
                f,
                ", as without the trial: {shares}. Other numbers would lower the squared noise by less than {least:.0} %"
            );
        }
        let Counts { photons, eye_paths } = usual;
        write!(f, ". Without the trial ({eye_paths} and {photons}), {}. ", shares(*usual))?;
        write!(f, "Now {}. ", shares(*taken))?;
        write!(f, "After the same work, the squared noise is {:.2} times as large", trial.gain(*usual, *taken))
    }
}

/// The least number of photons that a trial chooses if photons matter, as a share of the usual number. The trial may have
/// missed light that few photons bring.
const LEAST_SHARE: f64 = 0.25;
/// The largest ratio of a chosen number to the usual one, if the other number is given.
const MOST_FACTOR: f64 = 16.0;
/// The least work of an iteration as a share of the usual work, if both numbers are chosen.
const LEAST_WORK: f64 = 0.75;
/// The trial chooses other numbers only if their noise after the same work is below this share of the usual numbers'
/// noise, because a trial is not exact.
const WORTHWHILE: f64 = 0.9;

impl Trial {
    /// Returns the noise of eye paths and the noise of photons in an iteration.
    pub fn noise(&self, counts: Counts) -> [f64; 2] {
        [self.eye_noise / f64::from(counts.eye_paths), self.photon_noise / counts.photons as f64]
    }

    /// Returns the work of eye paths and the work of photons in an iteration, in units of an eye path's work.
    pub fn work(&self, counts: Counts) -> [f64; 2] {
        [self.eye_work * f64::from(counts.eye_paths), self.photon_work * counts.photons as f64]
    }

    /// Returns all noise of an iteration.
    pub fn all_noise(&self, counts: Counts) -> f64 {
        self.noise(counts).iter().sum::<f64>() + self.other_noise
    }

    /// Returns the noise with `taken`, divided by the noise with `usual` after the same work; 1 if there is no noise.
    pub fn gain(&self, usual: Counts, taken: Counts) -> f64 {
        let left = |counts| self.all_noise(counts) * self.work(counts).iter().sum::<f64>();
        if left(usual) > 0.0 { left(taken) / left(usual) } else { 1.0 }
    }

    /// Returns the noise of eye paths and photons after a unit of work.
    fn product(&self, counts: Counts) -> f64 {
        self.noise(counts).iter().sum::<f64>() * self.work(counts).iter().sum::<f64>()
    }

    /// Returns the number of photons with the least noise for the work, with this number of eye paths.
    fn best_photons(&self, eye_paths: u32) -> f64 {
        let ratio = self.photon_noise * self.eye_work / (self.eye_noise * self.photon_work);
        if ratio.is_finite() { f64::from(eye_paths) * ratio.sqrt() } else { f64::INFINITY }
    }

    /// Returns the numbers with the least noise for the work. Where both are asked for, an iteration has about as much
    /// work as with the usual numbers, or up to a quarter less. Neither is above `most`.
    pub fn choose(&self, usual: Counts, auto: Auto, most: Counts) -> Counts {
        let least = if self.photons_matter { (LEAST_SHARE * usual.photons as f64).max(1.0) } else { 1.0 };
        let largest = (usual.photons as f64 * MOST_FACTOR).min(most.photons as f64);
        let photons = |wanted: f64| rounded(wanted.clamp(least, largest));
        let budget: f64 = self.work(usual).iter().sum();
        let choices: Vec<Counts> = match auto {
            Auto { photons: false, eye_paths: false } => Vec::new(),
            Auto { photons: true, eye_paths: false } => {
                let steps = (-16..=16).map(|step| f64::from(step) / 4.0);
                let wanted = steps.map(|step| usual.photons as f64 * step.exp2()).chain([least]);
                wanted.map(|wanted| Counts { photons: photons(wanted), ..usual }).collect()
            }
            Auto { photons: false, eye_paths: true } => {
                let most = most.eye_paths.min((f64::from(usual.eye_paths) * MOST_FACTOR) as u32);
                (1..=most).map(|eye_paths| Counts { eye_paths, ..usual }).collect()
            }
            Auto { photons: true, eye_paths: true } => {
                let left = |eye_paths: u32| (budget - self.eye_work * f64::from(eye_paths)) / self.photon_work;
                let counts = |eye_paths, wanted| Counts { photons: photons(wanted), eye_paths };
                let wanted = |eye_paths| if self.photons_matter { left(eye_paths) } else { least };
                let fitting = || (1..=most.eye_paths).take_while(|eye_paths| left(*eye_paths) >= least);
                let full = fitting().map(|eye_paths| counts(eye_paths, wanted(eye_paths)));
                // Where there is no room for another eye path, photons need not take what is left.
                let fewer = fitting().last().map(|last| counts(last, wanted(last).min(self.best_photons(last))));
                let is_enough = |counts: &Counts| self.work(*counts).iter().sum::<f64>() >= LEAST_WORK * budget;
                full.chain(fewer).filter(is_enough).collect()
            }
        };
        let best = choices.into_iter().min_by(|a, b| self.product(*a).total_cmp(&self.product(*b))).unwrap_or(usual);
        if self.gain(usual, best) < WORTHWHILE { best } else { usual }
    }
}

/// Rounds a number of photons to three bits, so that roundings of a device hardly change it.
fn rounded(photons: f64) -> u64 {
    let unit = (photons.log2().floor() - 2.0).exp2().max(1.0);
    ((photons / unit).round() * unit) as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOTH: Auto = Auto { photons: true, eye_paths: true };
    const MOST: Counts = Counts { photons: 1 << 31, eye_paths: 64 };
    const USUAL: Counts = Counts { photons: 10_000, eye_paths: 4 };

    /// An iteration with the usual numbers has as much work of eye paths as of photons.
    fn trial(eye_noise: f64, photon_noise: f64) -> Trial {
        let of_photon = 10_000.0 * photon_noise;
        Trial {
            eye_noise: 4.0 * eye_noise,
            photon_noise: of_photon,
            other_noise: 0.0,
            eye_work: 1e4,
            photon_work: 4.0,
            photons_matter: true,
        }
    }

    #[test]
    fn numbers_follow_the_noise_at_the_same_work() {
        assert_eq!(trial(1.0, 1.0).choose(USUAL, BOTH, MOST), USUAL, "they are the best");
        assert_eq!(trial(0.0, 0.0).choose(USUAL, BOTH, MOST), USUAL, "a black image");
        // n / p is three times the usual ratio: 8 (3 / 4) eye paths, and 8 (1 / 4) times a quarter of the photons.
        assert_eq!(trial(9.0, 1.0).choose(USUAL, BOTH, MOST), Counts { photons: 5120, eye_paths: 6 });
        assert_eq!(trial(1.0, 9.0).choose(USUAL, BOTH, MOST), Counts { photons: 14_336, eye_paths: 2 });
        for noise in [[1.0, 0.0], [0.0, 1.0], [3.0, 1.0], [1.0, 30.0]] {
            let trial = trial(noise[0], noise[1]);
            let taken = trial.choose(USUAL, BOTH, MOST);
            let work = |counts| trial.work(counts).iter().sum::<f64>();
            assert!((work(taken) / work(USUAL) - 1.0).abs() < 0.13, "{taken:?}");
            assert!(trial.gain(USUAL, taken) <= 1.0, "{taken:?}");
        }
    }

    /// Where most noise falls with iterations alone, other numbers are not worth an estimate that may be wrong.
    #[test]
    fn numbers_stay_where_there_is_little_to_gain() {
        let with_other = |other_noise| Trial { other_noise, ..trial(9.0, 1.0) };
        assert_eq!(with_other(5.0).choose(USUAL, BOTH, MOST), Counts { photons: 5120, eye_paths: 6 });
        assert_eq!(with_other(50.0).choose(USUAL, BOTH, MOST), USUAL);
    }

    #[test]
    fn where_one_number_is_given_the_other_keeps_the_ratio() {
        let ratio = |counts: Counts| f64::from(counts.eye_paths) / counts.photons as f64 / (4.0 / 10_000.0);
        let photons = trial(9.0, 1.0).choose(USUAL, Auto { photons: true, eye_paths: false }, MOST);
        assert!(photons.eye_paths == 4 && (ratio(photons) / 3.0 - 1.0).abs() < 0.2, "{photons:?}");
        let eye_paths = trial(9.0, 1.0).choose(USUAL, Auto { photons: false, eye_paths: true }, MOST);
        assert_eq!(eye_paths, Counts { eye_paths: 12, ..USUAL });
        assert_eq!(trial(9.0, 1.0).choose(USUAL, Auto::default(), MOST), USUAL);
    }

    #[test]
    fn some_photons_look_for_light_that_the_trial_has_missed() {
        let only_eye = trial(1.0, 0.0);
        assert_eq!(only_eye.choose(USUAL, BOTH, MOST), Counts { photons: 2560, eye_paths: 7 });
        let useless = Trial { photons_matter: false, ..only_eye };
        assert_eq!(useless.choose(USUAL, BOTH, MOST), Counts { photons: 1, eye_paths: 7 });
        assert_eq!(
            useless.choose(USUAL, BOTH, Counts { eye_paths: 6, ..MOST }).eye_paths,
            6,
            "the most that there may be"
        );
        // The work of one more eye path is more than all that photons can give.
        let few_photons = Trial { photon_work: 1.0, ..only_eye };
        assert_eq!(few_photons.choose(USUAL, BOTH, MOST), Counts { photons: 2560, eye_paths: 4 });
        assert_eq!(trial(0.0, 1.0).choose(USUAL, BOTH, MOST), Counts { photons: 16_384, eye_paths: 1 });
        let only_photons = trial(0.0, 1.0).choose(USUAL, BOTH, Counts { photons: 12_288, ..MOST });
        assert_eq!(only_photons.photons, 12_288, "the most that there may be");
        // Photons that are not emitted are no work, so that there is nothing to share.
        let no_photons = Trial { photon_work: 0.0, ..useless };
        assert_eq!(no_photons.choose(USUAL, BOTH, MOST), USUAL);
    }

    #[test]
    fn a_choice_says_why() {
        let text = |trial: Trial| {
            let choice = Choice { trial, usual: USUAL, taken: trial.choose(USUAL, BOTH, MOST), time: Duration::ZERO };
            choice.to_string()
        };
        assert_eq!(
            text(trial(9.0, 1.0)),
            "eye paths 6, photons 5120. Without the trial (4 and 10000), eye paths cause 90 % of the noise and take 50 % of \
             the work, photons cause 10 % and take 50 %. Now eye paths cause 75 % of the noise and take 75 % of the work, \
             photons cause 25 % and take 25 %. After the same work, the squared noise is 0.80 times as large"
        );
        assert!(text(trial(1.0, 1.0)).ends_with("Other numbers would lower the squared noise by less than 10 %"));
        assert!(text(trial(0.0, 0.0)).ends_with("no noise"));
    }

    #[test]
    fn numbers_of_photons_have_three_bits() {
        let cases = [(1.0, 1), (5.4, 5), (8.9, 8), (9.1, 10), (1000.0, 1024), (262_143.0, 262_144), (3.2e5, 327_680)];
        for (photons, expected) in cases {
            assert_eq!(rounded(photons), expected, "{photons}");
        }
    }
}
