//! When to stop.

use std::time::Duration;

use super::RenderArgs;
use crate::render::options::request::Limits;
use crate::render::sequence::Sequence;
use crate::scene::Scene;

/// Rounds before the error is estimated for the first time.
const FIRST_ESTIMATE: u32 = 8;

/// What ends a render.
pub struct Limit {
    /// Of this shard, those of a resumed checkpoint included.
    pub iterations: Option<u32>,
    time: Option<Duration>,
    error: Option<f64>,
    round_length: u32,
}

impl Limit {
    /// What is asked for; the scene's own number of iterations if nothing is.
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

    /// Whether there is nothing left to do. At least one iteration is rendered, whatever the
    /// time.
    pub fn reached(&self, iterations: u32, elapsed: Duration, error: Option<f64>) -> bool {
        iterations >= self.iterations.unwrap_or(u32::MAX)
            || (iterations > 0 && self.time.is_some_and(|most| elapsed >= most))
            || self.error.zip(error).is_some_and(|(most, error)| error <= most)
    }

    /// Whether the error is to be estimated now: a few times in every doubling of the
    /// rounds. By count and not by time, so that a target error always stops at the same
    /// iteration.
    pub fn wants_error(&self, iterations: u32, quiet: bool) -> bool {
        let rounds = iterations / self.round_length;
        let often = (rounds.max(1).ilog2()).saturating_sub(FIRST_ESTIMATE.ilog2());
        (self.error.is_some() || !quiet)
            && iterations.is_multiple_of(self.round_length)
            && rounds >= FIRST_ESTIMATE
            && rounds.is_multiple_of(1 << often)
    }

    /// Seconds left, as far as can be told, after `done` of the iterations took `elapsed`.
    pub fn left(&self, iterations: u32, done: u32, elapsed: Duration) -> f64 {
        let by_count = self
            .iterations
            .map(|most| elapsed.as_secs_f64() / f64::from(done.max(1)) * f64::from(most.saturating_sub(iterations)));
        let by_time = self.time.map(|most| most.saturating_sub(elapsed).as_secs_f64());
        by_count.into_iter().chain(by_time).fold(f64::INFINITY, f64::min)
    }
}
