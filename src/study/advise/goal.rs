//! What a user asks for: a goal of the render, and the length of the probe.

use std::time::Duration;

/// What a user wants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Goal {
    /// The least error after so many seconds of iterations.
    Time(f64),
    /// A relative error, as soon as possible.
    Error(f64),
}

/// How long a probe is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Length {
    /// About so long in all.
    Time(Duration),
    /// Iterations of each of its renders, an even number from 2. What is expected of settings does
    /// not depend on how fast the device is, then.
    Iterations(u32),
}
