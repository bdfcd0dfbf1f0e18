//! The number of photons per batch and per invocation, and the number of invocations per dispatch. They
//! follow the clock, so that no dispatch keeps the device for long.

use std::time::Duration;

use goblet_host::DeviceKind;

use crate::render::options::Submission;

/// The time that tracing a batch should take: short enough for any watchdog, and long enough that the cost
/// of submission is negligible.
const TARGET: Duration = Duration::from_millis(300);
/// The time for a CPU, which has no watchdog. Larger batches are better, because every batch visits every
/// visible point.
const TARGET_OF_CPU: Duration = Duration::from_secs(3);
/// The number of photons in the first batch, before any time is measured.
const FIRST: u64 = 1 << 12;
const FIRST_OF_CPU: u64 = 1 << 18;

/// The number of photons that an invocation traces. A CPU needs many per SIMD lane, so that a lane starts
/// its next photon when a path ends; a GPU needs many invocations.
const PER_INVOCATION: u64 = 2;
const PER_INVOCATION_OF_CPU: u64 = 32;

/// Returns the number of photons that an invocation traces one after the other, on a kind of device.
pub fn photons_per_invocation(kind: DeviceKind) -> u64 {
    if kind == DeviceKind::Cpu { PER_INVOCATION_OF_CPU } else { PER_INVOCATION }
}

/// The time that a dispatch should take in a responsive render.
const MOMENT: Duration = Duration::from_millis(40);
/// The time that a dispatch should take on a GPU: the systems of some end a dispatch after two seconds.
const BREATH: Duration = Duration::from_millis(100);
/// The same on a CPU, which has no watchdog, and whose cores wait for each other at the end of a dispatch.
const BREATH_OF_CPU: Duration = Duration::from_secs(1);
/// The number of invocations in the first dispatch, before any time is measured, and the smallest number in
/// any but the last. Every workgroup size divides it.
const FEWEST_INVOCATIONS: u64 = 128;
/// The number in the first dispatch on a CPU, unless the render is responsive.
const FIRST_INVOCATIONS_OF_CPU: u64 = 1 << 16;

/// Iterations that run in pieces after one that did not fit in one submission.
const PAUSE: u32 = 16;

/// The number of invocations of a pass in one dispatch.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    /// The largest number of invocations in a dispatch.
    invocations: u64,
    /// The time that a dispatch should take.
    target: Duration,
}

impl Pace {
    /// Returns the pace of a pass that has not run yet, on a kind of device.
    pub fn new(kind: DeviceKind, responsive: bool) -> Self {
        let (invocations, target) = match kind {
            _ if responsive => (FEWEST_INVOCATIONS, MOMENT),
            DeviceKind::Cpu => (FIRST_INVOCATIONS_OF_CPU, BREATH_OF_CPU),
            _ => (FEWEST_INVOCATIONS, BREATH),
        };
        Self { invocations, target }
    }

    /// Returns the number of invocations of the next dispatch, if `left` invocations remain. Only the last
    /// dispatch may end within a workgroup.
    pub fn next(&self, left: u64) -> u64 {
        self.invocations.min(left)
    }

    /// Adapts the limit to the time that a dispatch took.
    pub fn observe(&mut self, invocations: u64, took: Duration) {
        if invocations < self.invocations && took < self.target {
            return; // The time of a small last dispatch says little.
        }
        let wanted = invocations as f64 * self.target.as_secs_f64() / took.as_secs_f64().max(1e-6);
        let wanted = (wanted as u64).min(self.invocations.saturating_mul(4));
        self.invocations = (wanted / FEWEST_INVOCATIONS * FEWEST_INVOCATIONS).max(FEWEST_INVOCATIONS);
    }
}

/// The paces of the passes that may take long.
#[derive(Clone, Copy, Debug)]
pub struct Paces {
    /// The pass that traces eye paths.
    pub eye: Pace,
    /// The pass that traces photons.
    pub photon: Pace,
    /// The pass that adds photons to visible points.
    pub gather: Pace,
    /// The pass that gathers photons on rough surfaces.
    pub rough: Pace,
}

/// The sizes of photon batches and of dispatches. They do not change an image, so they may follow the clock.
#[derive(Clone, Debug)]
pub struct Schedule {
    /// The pace of each pass.
    pub paces: Paces,
    photons: u64,
    max: u64,
    fixed: bool,
    target: Duration,
    per_invocation: u64,
    submission: Submission,
    /// Time of the last iteration; zero before the first one.
    last_iteration: Duration,
    /// Iterations that are to run in pieces, since one submission could not hold the last that was tried.
    in_pieces: u32,
}

impl Schedule {
    /// Returns a schedule with batches of at most `max` photons. If `asked` is given, the size of batches is
    /// fixed at the smaller of both numbers.
    pub fn new(asked: Option<u64>, max: u64, kind: DeviceKind, responsive: bool, submission: Submission) -> Self {
        let first = if kind == DeviceKind::Cpu { FIRST_OF_CPU } else { FIRST };
        let photons = asked.unwrap_or(first).clamp(1, max);
        let target = if kind == DeviceKind::Cpu { TARGET_OF_CPU } else { TARGET };
        let pace = Pace::new(kind, responsive);
        Self {
            paces: Paces { eye: pace, photon: pace, gather: pace, rough: pace },
            photons,
            max,
            fixed: asked.is_some(),
            target,
            per_invocation: photons_per_invocation(kind),
            submission: match submission {
                Submission::Auto if kind == DeviceKind::Cpu => Submission::Pieces,
                submission => submission,
            },
            last_iteration: Duration::ZERO,
            in_pieces: 0,
        }
    }

    /// Returns whether the next iteration, of `photons` photons, is to run in one submission. It then must not take
    /// longer than a dispatch should.
    pub fn is_whole(&self, photons: u64) -> bool {
        let is_quick = !self.last_iteration.is_zero() && self.last_iteration <= self.paces.eye.target;
        let is_wanted = match self.submission {
            Submission::Auto => is_quick,
            Submission::Pieces => false,
            Submission::Whole => true,
        };
        is_wanted && self.in_pieces == 0 && (photons == 0 || self.end(0, photons) == photons)
    }

    /// Notes that an iteration did not fit in one submission.
    pub fn pause_whole(&mut self) {
        self.in_pieces = PAUSE;
    }

    /// Notes the time that an iteration took.
    pub fn observe_iteration(&mut self, took: Duration) {
        self.last_iteration = took;
        self.in_pieces = self.in_pieces.saturating_sub(1);
    }

    /// Returns the number of photons that an invocation traces one after the other.
    pub fn per_invocation(&self) -> u64 {
        self.per_invocation
    }

    /// Halves the size of batches, because a batch left more records than there is room for. Returns false if
    /// a batch already had a single photon.
    pub fn overflowed(&mut self) -> bool {
        let divisible = self.photons > 1;
        self.photons = (self.photons / 2).max(1);
        self.max = self.photons;
        divisible
    }

    /// Returns the end of the batch that starts at photon `first` of `total`. The remaining photons are split
    /// evenly into batches.
    pub fn end(&self, first: u64, total: u64) -> u64 {
        let left = total - first;
        first + left.div_ceil(left.div_ceil(self.photons))
    }

    /// Adapts the size of batches to the time in which a batch was traced. The time to gather the photons
    /// does not count: gathering has dispatches of its own, and hardly takes less time for fewer photons.
    pub fn observe(&mut self, photons: u64, took: Duration) {
        if self.fixed || took.is_zero() {
            return;
        }
        let wanted = photons as f64 * self.target.as_secs_f64() / took.as_secs_f64();
        // At most a factor of four at once: a batch may be slow because the machine is busy.
        let low = self.photons / 4;
        let high = self.photons.saturating_mul(4);
        self.photons = (wanted as u64).clamp(low, high).clamp(256.min(self.max), self.max);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn batches_cover_every_photon_once() {
        for asked in [1, 7, 100, 1000] {
            let size = Schedule::new(Some(asked), 500, DeviceKind::Cpu, false, Submission::Auto);
            let mut first = 0;
            while first < 777 {
                let end = size.end(first, 777);
                assert!(end > first && end - first <= asked.min(500));
                first = end;
            }
            assert_eq!(first, 777);
        }
    }

    #[test]
    fn dispatches_come_to_take_a_moment() {
        let mut pace = Pace::new(DeviceKind::Cpu, true);
        for _ in 0..20 {
            let invocations = pace.next(1_000_003);
            assert!(invocations.is_multiple_of(FEWEST_INVOCATIONS));
            pace.observe(invocations, Duration::from_micros(4 * invocations));
        }
        assert!(pace.next(u64::MAX).abs_diff(10_000) < FEWEST_INVOCATIONS);
        assert_eq!(pace.next(7), 7);
        pace.observe(7, Duration::from_micros(7));
        assert!(pace.next(u64::MAX) > 9_000, "the last few tell little");
        pace.observe(9_984, Duration::from_secs(100));
        assert_eq!(pace.next(u64::MAX), FEWEST_INVOCATIONS);
    }

    /// Paths of a millisecond each: no dispatch takes much longer than its time, the first one included.
    #[test]
    fn dispatches_of_a_slow_pass_are_short_from_the_first_one_on() {
        for kind in [DeviceKind::Discrete, DeviceKind::Integrated, DeviceKind::Virtual, DeviceKind::Other] {
            let mut pace = Pace::new(kind, false);
            let mut left: u64 = 100_000;
            while left > 0 {
                let invocations = pace.next(left);
                let took = Duration::from_millis(invocations);
                assert!(took <= BREATH.max(Duration::from_millis(FEWEST_INVOCATIONS)), "{kind:?}: {took:?}");
                pace.observe(invocations, took);
                left -= invocations;
            }
        }
    }

    #[test]
    fn slow_batches_shrink_and_fast_ones_grow_within_bounds() {
        let mut size = Schedule::new(None, 1 << 20, DeviceKind::Discrete, false, Submission::Auto);
        size.observe(FIRST, Duration::from_secs(100));
        assert_eq!(size.photons, FIRST / 4);
        for _ in 0..10 {
            size.observe(size.photons, Duration::from_micros(1));
        }
        assert_eq!(size.photons, 1 << 20);
        for _ in 0..20 {
            size.observe(size.photons, Duration::from_secs(100));
        }
        assert_eq!(size.photons, 256);
    }
    #[test]
    fn an_iteration_is_one_submission_where_it_is_quick() {
        let ms = Duration::from_millis;
        let schedule = |kind, submission| Schedule::new(Some(1000), 1000, kind, false, submission);
        let mut auto = schedule(DeviceKind::Discrete, Submission::Auto);
        assert!(!auto.is_whole(1000), "nothing is known yet");
        for (took, is_whole) in [(101, false), (99, true), (500, false), (5, true)] {
            auto.observe_iteration(ms(took));
            assert_eq!(auto.is_whole(1000), is_whole, "{took} ms");
        }
        assert!(!auto.is_whole(1001), "two batches");
        assert!(auto.is_whole(0), "no photons");
        auto.pause_whole();
        for _ in 0..PAUSE {
            assert!(!auto.is_whole(1000));
            auto.observe_iteration(ms(5));
        }
        assert!(auto.is_whole(1000));
        for (kind, submission, is_whole) in [
            (DeviceKind::Cpu, Submission::Auto, false),
            (DeviceKind::Cpu, Submission::Whole, true),
            (DeviceKind::Discrete, Submission::Pieces, false),
        ] {
            let mut schedule = schedule(kind, submission);
            schedule.observe_iteration(ms(5));
            assert_eq!(schedule.is_whole(1000), is_whole, "{kind:?}, {submission:?}");
        }
    }
}
