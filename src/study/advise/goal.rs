//! What a user asks for: a goal of the render, and the length of the probe.

use std::time::Duration;

/// The goal of a render.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Goal {
    /// The least error after this number of seconds of iterations.
    Time(f64),
    /// This relative error in the least time.
    Error(f64),
}

/// The length of a probe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Length {
    /// About this time in all, from the hierarchy and the kernels on; longer if a scene leaves too little time for renders.
    Time(Duration),
    /// Iterations of each of its renders: an even number of at least 2. Predictions of errors then do not
    /// depend on the speed of the device.
    Iterations(u32),
}
