//! How long the window keeps its user waiting.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use serde::Serialize;

/// Times from events to what they bring about.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Times {
    count: u64,
    mean_seconds: f64,
    longest_seconds: f64,
}

impl Times {
    fn add(&mut self, time: Duration) {
        let seconds = time.as_secs_f64();
        self.count += 1;
        self.mean_seconds += (seconds - self.mean_seconds) / self.count as f64;
        self.longest_seconds = self.longest_seconds.max(seconds);
    }
}

/// What the window's `--stats` say.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Stats {
    /// Frames that were shown.
    pub frames: u64,
    /// Iterations of the last render.
    pub iterations: u32,
    /// From an input event to the next frame, the newest picture with the interface above it.
    pub input_to_frame: Times,
    /// From a move of the camera to the first picture that has seen it.
    pub move_to_picture: Times,
}

/// Measures both.
#[derive(Debug, Default)]
pub struct Latency {
    /// When the window was last done with all events.
    idle: Option<Instant>,
    /// When it last looked for them.
    looked: Option<Instant>,
    /// From when on events may have come that are seen only now.
    since: Option<Instant>,
    /// The oldest event that no frame has followed.
    waiting: Option<Instant>,
    /// Moves of the camera that no picture has seen.
    moves: VecDeque<(u64, Instant)>,
    /// What there is so far.
    pub stats: Stats,
}

impl Latency {
    /// The window goes to look for events. Those that came while it was busy may be as old as its
    /// last look.
    pub fn looks(&mut self) {
        let now = Instant::now();
        let waited = self.idle.is_some_and(|idle| now - idle > Duration::from_millis(1));
        self.since = if waited { Some(now) } else { self.looked.or(Some(now)) };
        self.looked = Some(now);
    }

    /// All events are dealt with.
    pub fn rests(&mut self) {
        self.idle = Some(Instant::now());
    }

    /// An input event.
    pub fn input(&mut self) {
        self.waiting = self.waiting.or(self.since);
    }

    /// A move of the camera.
    pub fn moved(&mut self, moves: u64) {
        self.moves.push_back((moves, self.waiting.unwrap_or_else(Instant::now)));
    }

    /// A frame is shown; its picture has seen so many moves.
    pub fn shown(&mut self, seen: u64) {
        self.stats.frames += 1;
        if let Some(event) = self.waiting.take() {
            self.stats.input_to_frame.add(event.elapsed());
        }
        let mut newest = None;
        while let Some((moves, event)) = self.moves.front().copied().filter(|(moves, _)| *moves <= seen) {
            newest = Some((moves, event));
            self.moves.pop_front();
        }
        if let Some((_, event)) = newest {
            self.stats.move_to_picture.add(event.elapsed());
        }
    }
}
