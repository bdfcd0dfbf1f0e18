//! The progress of a render's iterations, for the status of the command.

use std::time::{Duration, Instant};

use super::limit::Limit;
use crate::cli::status::{Line, Status, duration, of_limit};
use crate::render::activity::{Activity, Since};
use crate::render::renderer::Renderer;

/// The state at which this run started: 0, or that of a resumed checkpoint.
#[derive(Clone, Copy)]
pub struct Begin {
    /// Iterations that were finished before.
    pub iterations: u32,
    /// Photons that were emitted before.
    pub photons: u64,
    /// When this run began.
    pub time: Instant,
}

/// The state after an iteration.
#[derive(Clone, Copy)]
struct State {
    limit: Limit,
    begin: Begin,
    iterations: u32,
    photons: u64,
    /// The time of the iterations so far.
    elapsed: Duration,
    error: Option<f64>,
}

impl State {
    /// Describes the state at a later moment: time goes on, and may be spent by something else than iterations.
    fn line(&self, since: &Since, now: Duration) -> Line {
        let Self { limit, begin, iterations, elapsed, error, .. } = *self;
        if since.activity == Activity::Writing {
            return Line { share: None, parts: vec![since.to_string()] };
        }
        let mut parts = Vec::new();
        if since.activity != Activity::Rendering {
            parts.push(since.to_string());
        }
        parts.extend(limit.time.map(|most| of_limit(now, most)));
        parts.push(match limit.iterations {
            Some(most) => format!("iteration {iterations} of {most}"),
            None => format!("iteration {iterations}"),
        });
        let done = iterations - begin.iterations;
        if limit.time.is_none() && done > 0 {
            let left = limit.left(iterations, done, elapsed) - now.saturating_sub(elapsed).as_secs_f64();
            parts.extend(left.is_finite().then(|| format!("{} left", duration(left.max(0.0)))));
        }
        let percent = |error: f64| format!("{:.2} %", 100.0 * error);
        parts.extend(error.map(|error| match limit.error {
            Some(target) => format!("error {}, target {}", percent(error), percent(target)),
            None => format!("error {}", percent(error)),
        }));
        if done > 0 {
            let rate = (self.photons - begin.photons) as f64 / elapsed.as_secs_f64().max(f64::MIN_POSITIVE) / 1e6;
            parts.push(format!("{rate:.2} M photons/s"));
        }
        Line { share: limit.share(iterations, now, error), parts }
    }
}

/// The progress of a render, which a status shows.
pub struct Progress<'a> {
    status: &'a Status,
    pub limit: Limit,
    pub begin: Begin,
    /// The relative error when it was last estimated.
    pub error: Option<f64>,
}

impl<'a> Progress<'a> {
    /// Returns the progress of a run that started at `begin`.
    pub fn new(status: &'a Status, limit: Limit, begin: Begin) -> Self {
        Self { status, limit, begin, error: None }
    }

    /// Shows the state after an iteration.
    pub fn show(&self, renderer: &Renderer) {
        let begin = self.begin;
        let state = State {
            limit: self.limit,
            begin,
            iterations: renderer.iterations(),
            photons: renderer.photons(),
            elapsed: begin.time.elapsed(),
            error: self.error,
        };
        self.status.show(Box::new(move |since| state.line(since, begin.time.elapsed())));
    }

    /// Shows the state at the begin or at the end of the iterations, and draws it at once.
    pub fn draw(&self, renderer: &Renderer) {
        self.show(renderer);
        self.status.draw();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state(iterations: Option<u32>, time: Option<u64>) -> State {
        let limit = Limit { iterations, time: time.map(Duration::from_secs), error: None, round_length: 1 };
        let begin = Begin { iterations: 10, photons: 0, time: Instant::now() };
        let elapsed = Duration::from_secs(4);
        State { limit, begin, iterations: 20, photons: 8_000_000, elapsed, error: Some(0.032) }
    }

    #[test]
    fn a_line_names_the_limit_and_what_is_done() {
        let rendering = Since::now(Activity::Rendering);
        let line = state(None, Some(10)).line(&rendering, Duration::from_secs(5));
        assert_eq!(line.share, Some(0.5));
        assert_eq!(line.parts, ["5.0 of 10 s", "iteration 20", "error 3.20 %", "2.00 M photons/s"]);
        let line = state(Some(40), None).line(&rendering, Duration::from_secs(5));
        assert_eq!(line.share, Some(0.5));
        // 20 iterations at 0.4 s each, of which one second has passed.
        assert_eq!(line.parts, ["iteration 20 of 40", "7.0 s left", "error 3.20 %", "2.00 M photons/s"]);
        let line = state(None, Some(10)).line(&Since::now(Activity::Pilot), Duration::ZERO);
        assert!(line.parts[0].starts_with("pilot of the guide, 0.0 s") && line.parts[1] == "0.0 of 10 s", "{line:?}");
    }

    #[test]
    fn every_line_fits_80_columns() {
        let whole = state(Some(100_000), Some(100_000));
        let whole = State { iterations: 99_999, ..whole };
        for state in [state(Some(40), None), state(None, Some(10)), whole] {
            for activity in [Activity::Rendering, Activity::Trial, Activity::CompilingKernels { done: 10, all: 17 }] {
                let line = state.line(&Since::now(activity), Duration::from_secs(5));
                for width in [20, 40, 60, 80, 120] {
                    assert!(line.within(width).len() < width, "{}", line.within(width));
                }
            }
        }
    }
}
