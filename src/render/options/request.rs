//! The request of a user: options and limits of a render, read from the text of their values.

use std::time::Duration;

use super::Options;

/// The limits of a render. It ends at the first limit that it reaches.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Limits {
    /// Number of iterations.
    pub iterations: Option<u32>,
    /// Number of rounds of the integrator `ppm`. It cannot be combined with `iterations`.
    pub rounds: Option<u32>,
    /// Total time of the iterations. A render ends after the iteration that reaches it.
    pub time: Option<Duration>,
    /// Estimated relative error of the image, as defined by [`crate::Renderer::relative_error`].
    pub target_error: Option<f64>,
}

/// The options of a render and its limits.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Request {
    /// The options.
    pub options: Options,
    /// The limits.
    pub limits: Limits,
}
