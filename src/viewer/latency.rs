//! Measurement of the time that a user waits for the window.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use serde::Serialize;

/// Statistics of the times from events to their effects.
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

/// The statistics that `goblet view --stats` writes.
#[derive(Clone, Debug, Default, Serialize)]
pub struct LatencyStats {
    /// The number of frames that were shown.
    pub frames: u64,
    /// The number of iterations of the last render.
    pub iterations: u32,
    /// Times from an input event to the next frame, which has the newest picture and the interface.
    pub input_to_frame: Times,
    /// Times from a move of the camera to the first picture from the new place.
    pub move_to_picture: Times,
}

/// Measures the times of [`LatencyStats`].
#[derive(Debug, Default)]
pub struct Latency {
    /// The time when the window had last handled all events.
    idle: Option<Instant>,
    /// The time when the window last looked for events.
    looked: Option<Instant>,
    /// The earliest time at which an event that is handled now may have come.
    since: Option<Instant>,
    /// The time of the oldest event that no frame has followed.
    waiting: Option<Instant>,
    /// Numbers and times of the moves of the camera that no picture shows yet.
    moves: VecDeque<(u64, Instant)>,
    /// The statistics so far.
    pub stats: LatencyStats,
}

impl Latency {
    /// Notes that the window looks for events. Events that came while the window was busy may be as old as
    /// its last look.
    pub fn looks(&mut self) {
        let now = Instant::now();
        let waited = self.idle.is_some_and(|idle| now - idle > Duration::from_millis(1));
        self.since = if waited { Some(now) } else { self.looked.or(Some(now)) };
        self.looked = Some(now);
    }

    /// Notes that all events are handled.
    pub fn rests(&mut self) {
        self.idle = Some(Instant::now());
    }

    /// Notes an input event.
    pub fn input(&mut self) {
        self.waiting = self.waiting.or(self.since);
    }

    /// Notes a move of the camera; `moves` is its number.
    pub fn moved(&mut self, moves: u64) {
        self.moves.push_back((moves, self.waiting.unwrap_or_else(Instant::now)));
    }

    /// Notes that a frame is shown. `seen` is the number of the last move of the camera in its picture.
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
