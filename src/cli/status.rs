//! What a command does, on standard error while it does it: on a terminal one line that is drawn again and again, else a
//! line now and then.

use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use super::terminal;
use crate::render::activity::{Activity, Observer, Since};

/// The time between two drawings of the line of a terminal.
const TICK: Duration = Duration::from_millis(100);
/// The time before the first line that is not on a terminal, and the longest time between two. It doubles from line to
/// line, so that the log of a long render stays short.
const LINE_INTERVALS: [Duration; 2] = [Duration::from_secs(5), Duration::from_secs(60)];
/// The columns of a bar with its brackets: the least and the most.
const BAR: [usize; 2] = [12, 32];

/// A state of a job in words.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Line {
    /// The share of the job that is done, from 0 to 1; `None` if it is not known.
    pub share: Option<f64>,
    /// What there is to say, the most important first: the last parts are left out where there is no room.
    pub parts: Vec<String>,
}

impl Line {
    /// Writes the line in fewer than `width` columns.
    pub fn within(&self, width: usize) -> String {
        let room = width.saturating_sub(1);
        let of_bar = if self.share.is_some() { BAR[0] + 1 } else { 0 };
        let mut count = self.parts.len();
        let text = |count: usize| self.parts[..count].join(", ");
        let length = |count: usize| text(count).chars().count();
        while count > 1 && length(count) + of_bar > room {
            count -= 1;
        }
        let words = text(count);
        match self.share.filter(|_| length(count) + of_bar <= room) {
            Some(share) => format!("{} {words}", bar(share, (room - length(count) - 1).min(BAR[1]))),
            None => words.chars().take(room).collect(),
        }
    }

    /// Writes the line for a log.
    fn plain(&self) -> String {
        self.parts.join(", ")
    }
}

/// Draws a bar of a width in columns, of which a share is full.
fn bar(share: f64, width: usize) -> String {
    let inner = width.saturating_sub(2);
    let full = (share.clamp(0.0, 1.0) * inner as f64).round() as usize;
    // The tip shows that the job goes on even where the bar is short.
    let tip = if full < inner { ">" } else { "" };
    format!("[{}{tip}{}]", "=".repeat(full), " ".repeat(inner - full - tip.len()))
}

/// Describes a job: its line at this moment, with what is done in it.
pub type Describe = Box<dyn Fn(&Since) -> Line + Send>;

/// The display of what a command does, until it is dropped. With `--quiet` nothing is shown.
pub struct Status {
    shown: Arc<Mutex<Shown>>,
    end: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

struct Shown {
    since: Since,
    /// The job of which it is a part; `None` before it begins.
    job: Option<Describe>,
    is_quiet: bool,
    is_terminal: bool,
}

impl Shown {
    fn line(&self) -> Line {
        match &self.job {
            Some(describe) => describe(&self.since),
            None => Line { share: None, parts: vec![self.since.to_string()] },
        }
    }

    /// Draws the line, if there is a terminal.
    fn draw(&self) {
        if self.is_terminal && !self.is_quiet {
            terminal::show_status(&self.line().within(terminal::width()));
        }
    }
}

impl Status {
    /// Begins to show an activity.
    pub fn new(activity: Activity, is_quiet: bool) -> Self {
        let is_terminal = terminal::has_status();
        let shown = Shown { since: Since::now(activity), job: None, is_quiet, is_terminal };
        shown.draw();
        let shown = Arc::new(Mutex::new(shown));
        let (end, ended) = channel();
        let thread = (!is_quiet).then(|| {
            let shown = Arc::clone(&shown);
            thread::spawn(move || show(&shown, is_terminal, &ended))
        });
        Self { shown, end: Some(end), thread }
    }

    /// Shows another activity.
    pub fn note(&self, activity: Activity) {
        note(&self.shown, activity);
    }

    /// Returns an observer whose activities are shown.
    pub fn observer(&self) -> Observer {
        let shown = Arc::clone(&self.shown);
        Observer::new(move |activity| note(&shown, activity))
    }

    /// Shows the state of a job from now on.
    pub fn show(&self, job: Describe) {
        lock(&self.shown).job = Some(job);
    }

    /// Draws the state at once, if there is a terminal.
    pub fn draw(&self) {
        lock(&self.shown).draw();
    }
}

impl Drop for Status {
    fn drop(&mut self) {
        self.end = None;
        // The line must be gone before the command ends.
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn lock(shown: &Mutex<Shown>) -> MutexGuard<'_, Shown> {
    shown.lock().unwrap_or_else(PoisonError::into_inner)
}

fn note(shown: &Mutex<Shown>, activity: Activity) {
    let mut shown = lock(shown);
    if shown.since.activity != activity {
        shown.since.note(activity);
        shown.draw();
    }
}

fn show(shown: &Mutex<Shown>, is_terminal: bool, ended: &Receiver<()>) {
    let mut interval = if is_terminal { TICK } else { LINE_INTERVALS[0] };
    while ended.recv_timeout(interval) == Err(RecvTimeoutError::Timeout) {
        if is_terminal {
            lock(shown).draw();
        } else {
            terminal::say(lock(shown).line().plain());
            interval = (2 * interval).min(LINE_INTERVALS[1]);
        }
    }
    if is_terminal {
        terminal::show_status("");
    }
}

/// Writes seconds for people: `4.2 s`, `12 s`, `3 min 20 s`, `2 h 5 min`.
pub fn duration(seconds: f64) -> String {
    match seconds {
        ..9.95 => format!("{seconds:.1} s"),
        ..119.5 => format!("{seconds:.0} s"),
        ..7170.0 => {
            let whole = seconds.round() as u64;
            format!("{} min {} s", whole / 60, whole % 60)
        }
        _ => {
            let minutes = (seconds / 60.0).round() as u64;
            format!("{} h {} min", minutes / 60, minutes % 60)
        }
    }
}

/// A limit of time for people: `4.2 of 10 s`.
pub fn of_limit(elapsed: Duration, limit: Duration) -> String {
    let (elapsed, limit) = (elapsed.as_secs_f64(), limit.as_secs_f64());
    if limit < 600.0 {
        let digits = usize::from(limit < 100.0);
        format!("{:.digits$} of {} s", elapsed.min(limit), trimmed(limit))
    } else {
        format!("{} of {}", duration(elapsed.min(limit)), duration(limit))
    }
}

/// Writes a number with at most one digit after the point.
fn trimmed(number: f64) -> String {
    let text = format!("{number:.1}");
    text.strip_suffix(".0").map_or_else(|| text.clone(), str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line() -> Line {
        let parts = ["4.2 of 10 s", "iteration 123", "error 3.20 %", "1.31 M photons/s"];
        Line { share: Some(0.42), parts: parts.map(str::to_owned).to_vec() }
    }

    #[test]
    fn a_line_fits_every_width_and_says_the_most_important_last() {
        assert_eq!(
            line().within(100),
            "[=============>                ] 4.2 of 10 s, iteration 123, error 3.20 %, 1.31 M photons/s"
        );
        assert_eq!(
            line().within(80),
            "[========>         ] 4.2 of 10 s, iteration 123, error 3.20 %, 1.31 M photons/s"
        );
        assert_eq!(line().within(60), "[=======>        ] 4.2 of 10 s, iteration 123, error 3.20 %");
        assert_eq!(line().within(40), "[====>     ] 4.2 of 10 s, iteration 123");
        assert_eq!(line().within(20), "4.2 of 10 s");
        for width in 0..200 {
            let text = line().within(width);
            assert!(text.len() < width.max(1), "{width}: {text}");
        }
        assert_eq!(Line { share: None, ..line() }.within(40), "4.2 of 10 s, iteration 123");
        assert_eq!(Line::default().within(80), "");
    }

    #[test]
    fn a_bar_fills_in_proportion() {
        for (share, expected) in [
            (0.0, "[>         ]"),
            (0.25, "[===>      ]"),
            (0.5, "[=====>    ]"),
            (0.94, "[=========>]"),
            (1.0, "[==========]"),
            (7.0, "[==========]"),
            (-1.0, "[>         ]"),
        ] {
            assert_eq!(bar(share, 12), expected, "{share}");
        }
        assert_eq!(bar(f64::NAN, 12), "[>         ]");
    }

    #[test]
    fn times_are_written_for_people() {
        for (seconds, expected) in [
            (0.04, "0.0 s"),
            (9.94, "9.9 s"),
            (9.96, "10 s"),
            (119.0, "119 s"),
            (200.4, "3 min 20 s"),
            (7500.0, "2 h 5 min"),
        ] {
            assert_eq!(duration(seconds), expected);
        }
        let of = |elapsed, limit| of_limit(Duration::from_secs_f64(elapsed), Duration::from_secs_f64(limit));
        assert_eq!(of(4.23, 10.0), "4.2 of 10 s");
        assert_eq!(of(11.0, 10.0), "10.0 of 10 s");
        assert_eq!(of(0.0, 2.5), "0.0 of 2.5 s");
        assert_eq!(of(61.0, 300.0), "61 of 300 s");
        assert_eq!(of(61.0, 3600.0), "61 s of 60 min 0 s");
    }
}
