//! A scene together with all of its errors.

use crate::scene::format::error::SceneError;
use crate::scene::model::Scene;

/// The result of reading a scene file to its end in spite of errors.
#[derive(Debug)]
pub struct Survey {
    /// The scene without the directives that have errors; `None` if no scene is left.
    pub scene: Option<Scene>,
    /// Unsupported features: at most the first [`MOST_FAULTS`](Self::MOST_FAULTS).
    pub unsupported: Vec<SceneError>,
    /// Other errors: at most the first [`MOST_FAULTS`](Self::MOST_FAULTS).
    pub errors: Vec<SceneError>,
    /// Number of errors and unsupported features that are not listed.
    pub more: u64,
}

impl Survey {
    /// Maximum number of listed entries of either kind.
    pub const MOST_FAULTS: usize = 100;
}
