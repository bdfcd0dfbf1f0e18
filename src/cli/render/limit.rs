//! The limits at which a render stops.

use std::time::Duration;

use super::RenderArgs;
use crate::render::options::request::Limits;
use crate::render::sequence::Sequence;
use crate::scene::Scene;

/// The number of rounds before the error is estimated for the first time.
const FIRST_ESTIMATE: u32 = 8;

/// The limits of a render.
#[derive(Clone, Copy, Debug)]
pub struct Limit {
    /// The number of iterations of this shard, including those of a resumed checkpoint.
    pub iterations: Option<u32>,
    pub time: Option<Duration>,
    pub error: Option<f64>,
    /// The number of iterations in a round.
    pub round_length: u32,
}

impl Limit {
    /// Returns the limits of the arguments. Without any, the limit is the scene's number of iterations.
    pub fn new(args: &RenderArgs, scene: &Scene, sequence: Sequence) -> Self {
        let Limits { iterations, rounds, time, target_error } = args.request.limits;
        let rounds = rounds.map(|rounds| rounds.saturating_mul(sequence.round_length));
        let asked = iterations.or(rounds);
        let unlimited = time.is_some() || target_error.is_some();
        let total = asked.or((!unlimited).then_some(scene.integrator.iterations));
        Self {
            iterations: total.map(|total| sequence.share(total)),
            time,
            error: target_error,
            round_length: sequence.round_length,
        }
    }

    /// Returns whether a limit is reached. A limit of time is reached only after the first iteration.
    pub fn reached(&self, iterations: u32, elapsed: Duration, error: Option<f64>) -> bool {
        iterations >= self.iterations.unwrap_or(u32::MAX)
            || (iterations > 0 && self.time.is_some_and(|most| elapsed >= most))
            || self.error.zip(error).is_some_and(|(most, error)| error <= most)
    }

    /// Returns whether to estimate the error after this iteration: a few times in every doubling of the
    /// number of rounds. This depends on counts and not on time, so that a target error always stops a render
    /// at the same iteration.
    pub fn wants_error(&self, iterations: u32, quiet: bool) -> bool {
        let rounds = iterations / self.round_length;
        let often = (rounds.max(1).ilog2()).saturating_sub(FIRST_ESTIMATE.ilog2());
        (self.error.is_some() || !quiet)
            && iterations.is_multiple_of(self.round_length)
            && rounds >= FIRST_ESTIMATE
            && rounds.is_multiple_of(1 << often)
    }

    /// Returns how far the render has come to the limit that it reaches first, from 0 to 1: by the count of iterations, by
    /// time, or by the error, whose noise falls as the root of the number of iterations. `done` iterations of this run
    /// took `elapsed`. `None` if there is a target error alone, and the error is not known.
    pub fn share(&self, iterations: u32, elapsed: Duration, error: Option<f64>) -> Option<f64> {
        let by_count = self.iterations.map(|most| f64::from(iterations) / f64::from(most.max(1)));
        let by_time = self.time.map(|most| elapsed.as_secs_f64() / most.as_secs_f64());
        let by_error = self.error.zip(error).map(|(most, error)| (most / error).powi(2));
        [by_count, by_time, by_error].into_iter().flatten().reduce(f64::max).map(|share| share.min(1.0))
    }

    /// Estimates the remaining time in seconds, if `done` iterations of this run took `elapsed`; infinite if
    /// there is no limit of iterations or time.
    pub fn left(&self, iterations: u32, done: u32, elapsed: Duration) -> f64 {
        let by_count = self
            .iterations
            .map(|most| elapsed.as_secs_f64() / f64::from(done.max(1)) * f64::from(most.saturating_sub(iterations)));
        let by_time = self.time.map(|most| most.saturating_sub(elapsed).as_secs_f64());
        by_count.into_iter().chain(by_time).fold(f64::INFINITY, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_render_has_come_as_far_as_to_its_nearest_limit() {
        let limit = |iterations, time: Option<f64>, error| Limit {
            iterations,
            time: time.map(Duration::from_secs_f64),
            error,
            round_length: 1,
        };
        let share = |limit: Limit, error| limit.share(5, Duration::from_secs(3), error);
        assert_eq!(share(limit(None, Some(12.0), None), None), Some(0.25), "time alone fills the bar");
        assert_eq!(share(limit(Some(50), None, None), None), Some(0.1));
        assert_eq!(share(limit(Some(50), Some(12.0), None), Some(0.5)), Some(0.25));
        assert_eq!(share(limit(Some(10), Some(12.0), None), None), Some(0.5));
        assert_eq!(share(limit(None, None, Some(0.1)), Some(0.2)), Some(0.25));
        assert_eq!(share(limit(None, None, Some(0.1)), None), None);
        assert_eq!(share(limit(None, Some(1.0), None), None), Some(1.0), "the iteration in flight passes the limit");
    }
}
