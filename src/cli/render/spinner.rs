//! Messages on standard error about long work before the first iteration.

use std::io::IsTerminal;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use super::progress::LINE_INTERVAL;
use crate::cli::terminal;

/// A message that is shown until it is dropped. On a terminal it is a spinner that appears after
/// [`PATIENCE`]; else it is a line at each [`LINE_INTERVAL`]. With `--quiet` nothing is shown.
pub struct Spinner {
    end: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

/// The time before a spinner appears.
const PATIENCE: Duration = Duration::from_secs(1);

impl Spinner {
    pub fn new(what: &'static str, quiet: bool) -> Self {
        let (end, ended) = channel();
        let thread = (!quiet).then(|| thread::spawn(move || show(what, &ended)));
        Self { end: Some(end), thread }
    }
}

impl Drop for Spinner {
    fn drop(&mut self) {
        self.end = None;
        // The spinner must be gone before anything else is printed.
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn show(what: &str, ended: &Receiver<()>) {
    let start = Instant::now();
    let lasts = |time| ended.recv_timeout(time) == Err(RecvTimeoutError::Timeout);
    if !std::io::stderr().is_terminal() {
        while lasts(LINE_INTERVAL) {
            terminal::say(format_args!("{what}: {:.0} s", start.elapsed().as_secs_f64()));
        }
        return;
    }
    if lasts(PATIENCE) {
        let spinner = ProgressBar::new_spinner().with_message(what.to_owned()).with_elapsed(start.elapsed());
        if let Ok(style) = ProgressStyle::with_template("{spinner} {msg}: {elapsed}") {
            spinner.set_style(style);
        }
        spinner.enable_steady_tick(Duration::from_millis(100));
        let _ = ended.recv();
        spinner.finish_and_clear();
    }
}
