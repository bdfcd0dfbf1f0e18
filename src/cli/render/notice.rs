//! What takes long before the first iteration, on standard error.

use std::io::IsTerminal;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use super::progress::LINE_INTERVAL;
use crate::cli::terminal;

/// Says what is being done for as long as it lives: a spinner on a terminal, once a second
/// has passed, a line now and then otherwise, nothing when quiet.
pub struct Notice {
    end: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

/// What takes less is not worth a word.
const PATIENCE: Duration = Duration::from_secs(1);

impl Notice {
    pub fn new(what: &'static str, quiet: bool) -> Self {
        let (end, ended) = channel();
        let thread = (!quiet).then(|| thread::spawn(move || show(what, &ended)));
        Self { end: Some(end), thread }
    }
}

impl Drop for Notice {
    fn drop(&mut self) {
        self.end = None;
        // The spinner must be gone before anything else is said.
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
