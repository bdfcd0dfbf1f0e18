//! How many photons a dispatch traces, and an invocation.

use std::time::Duration;

use goblet_host::DeviceKind;

/// Tracing a batch should keep the device this long: short of any watchdog, long enough that
/// submitting costs nothing.
const TARGET: Duration = Duration::from_millis(300);
/// No CPU has a watchdog, and every batch visits every visible point.
const TARGET_OF_CPU: Duration = Duration::from_secs(3);
/// The first batch, before anything is known.
const FIRST: u64 = 1 << 12;
const FIRST_OF_CPU: u64 = 1 << 18;

/// SIMD lanes of a CPU want many photons each, to start the next where a path ends; a GPU
/// wants many invocations.
const PER_INVOCATION: u64 = 2;
const PER_INVOCATION_OF_CPU: u64 = 32;

/// Where a caller waits to be heard, a dispatch should keep the device this long.
const MOMENT: Duration = Duration::from_millis(40);
/// The first of them; every workgroup size divides it.
const FEWEST_INVOCATIONS: u64 = 128;

/// How many invocations of a pass a dispatch runs.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    /// All, where there is no such number.
    invocations: Option<u64>,
}

impl Pace {
    /// All at once, or as many as a moment is enough for.
    pub fn new(responsive: bool) -> Self {
        Self { invocations: responsive.then_some(FEWEST_INVOCATIONS) }
    }

    /// Of those that are left. Only the last dispatch may end within a workgroup.
    pub fn next(&self, left: u64) -> u64 {
        self.invocations.map_or(left, |invocations| invocations.min(left))
    }

    /// Learns how long a dispatch took.
    pub fn observe(&mut self, invocations: u64, took: Duration) {
        let Some(most) = &mut self.invocations else { return };
        if invocations < *most && took < MOMENT {
            return; // The last few tell little.
        }
        let wanted = invocations as f64 * MOMENT.as_secs_f64() / took.as_secs_f64().max(1e-6);
        let wanted = (wanted as u64).min(most.saturating_mul(4)) / FEWEST_INVOCATIONS * FEWEST_INVOCATIONS;
        *most = wanted.max(FEWEST_INVOCATIONS);
    }
}

/// Paces of the passes that may take long.
#[derive(Clone, Copy, Debug)]
pub struct Paces {
    /// Eye paths.
    pub eye: Pace,
    /// Photons.
    pub photon: Pace,
    /// Adding photons to points.
    pub gather: Pace,
}

/// The size of photon batches, and of dispatches. It does not change an image, so it may follow
/// the clock.
#[derive(Clone, Debug)]
pub struct Schedule {
    /// Of each pass.
    pub paces: Paces,
    photons: u64,
    max: u64,
    fixed: bool,
    target: Duration,
    per_invocation: u64,
}

impl Schedule {
    /// Batches of at most `max` photons; of `asked` photons, where that is less.
    pub fn new(asked: Option<u64>, max: u64, kind: DeviceKind, responsive: bool) -> Self {
        let first = if kind == DeviceKind::Cpu { FIRST_OF_CPU } else { FIRST };
        let photons = asked.unwrap_or(first).clamp(1, max);
        let per_invocation = if kind == DeviceKind::Cpu { PER_INVOCATION_OF_CPU } else { PER_INVOCATION };
        let target = if kind == DeviceKind::Cpu { TARGET_OF_CPU } else { TARGET };
        let pace = Pace::new(responsive);
        Self {
            paces: Paces { eye: pace, photon: pace, gather: pace },
            photons,
            max,
            fixed: asked.is_some(),
            target,
            per_invocation,
        }
    }

    /// Photons that an invocation traces, one after the other.
    pub fn per_invocation(&self) -> u64 {
        self.per_invocation
    }

    /// Learns that a batch left more records than there is room for. False if it cannot be
    /// smaller.
    pub fn overflowed(&mut self) -> bool {
        let divisible = self.photons > 1;
        self.photons = (self.photons / 2).max(1);
        self.max = self.photons;
        divisible
    }

    /// Where the batch that starts at `first` of `total` photons ends. What is left is
    /// split evenly.
    pub fn end(&self, first: u64, total: u64) -> u64 {
        let left = total - first;
        first + left.div_ceil(left.div_ceil(self.photons))
    }

    /// Learns how long a batch was traced. What its photons then cost the visible points is
    /// cut into dispatches by itself, and hardly less for fewer photons.
    pub fn observe(&mut self, photons: u64, took: Duration) {
        if self.fixed || took.is_zero() {
            return;
        }
        let wanted = photons as f64 * self.target.as_secs_f64() / took.as_secs_f64();
        // At most a factor of four at once: one slow batch may be the machine's doing.
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
            let size = Schedule::new(Some(asked), 500, DeviceKind::Cpu, false);
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
        let mut pace = Pace::new(true);
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
        assert_eq!(Pace::new(false).next(u64::MAX), u64::MAX);
    }

    #[test]
    fn slow_batches_shrink_and_fast_ones_grow_within_bounds() {
        let mut size = Schedule::new(None, 1 << 20, DeviceKind::Discrete, false);
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
}
