//! The progress of a render on standard error.

use std::io::IsTerminal;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use super::limit::Limit;
use crate::cli::terminal;
use crate::render::renderer::Renderer;

/// The state at which this run started: 0, or that of a resumed checkpoint.
pub struct Begin {
    /// Iterations that were finished before.
    pub iterations: u32,
    /// Photons that were emitted before.
    pub photons: u64,
    /// When this run began.
    pub time: Instant,
}

/// The display of progress: a bar on a terminal, else a line at each [`LINE_INTERVAL`]. With `--quiet`
/// nothing is shown.
pub struct ProgressLine<'a> {
    bar: Option<ProgressBar>,
    quiet: bool,
    begin: &'a Begin,
    printed: Duration,
    /// The relative error when it was last estimated.
    pub error: Option<f64>,
}

/// The time between lines if standard error is not a terminal.
pub const LINE_INTERVAL: Duration = Duration::from_secs(5);

impl<'a> ProgressLine<'a> {
    /// Returns the display for a run that started at `begin`.
    pub fn new(limit: &Limit, begin: &'a Begin, quiet: bool) -> Self {
        let bar = (!quiet && std::io::stderr().is_terminal()).then(|| {
            let bar = limit.iterations.map_or_else(ProgressBar::new_spinner, |most| ProgressBar::new(most.into()));
            if let Ok(style) = ProgressStyle::with_template("{bar:30} {pos}/{len} iterations {msg}") {
                bar.set_style(style);
            }
            bar
        });
        Self { bar, quiet, begin, printed: Duration::ZERO, error: None }
    }

    /// Shows the state after an iteration.
    pub fn show(&mut self, renderer: &Renderer, limit: &Limit) {
        let elapsed = self.begin.time.elapsed();
        if self.bar.is_none() && (self.quiet || elapsed - self.printed < LINE_INTERVAL) {
            return;
        }
        self.printed = elapsed;
        let iterations = renderer.iterations();
        let rate = (renderer.photons() - self.begin.photons) as f64 / elapsed.as_secs_f64() / 1e6;
        let left = limit.left(iterations, iterations - self.begin.iterations, elapsed);
        let mut message = format!("{rate:.2} M photons/s");
        if left.is_finite() {
            message += &format!(", {left:.0} s left");
        }
        if let Some(error) = self.error {
            message += &format!(", error {:.2} %", 100.0 * error);
        }
        match &self.bar {
            Some(bar) => {
                bar.set_position(iterations.into());
                bar.set_message(message);
            }
            None => terminal::say(format_args!("iteration {iterations}: {message}")),
        }
    }

    /// Stops the bar and leaves it on the terminal.
    pub fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish();
        }
    }
}
