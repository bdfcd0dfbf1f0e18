//! A scene together with all that is wrong with it.

use crate::scene::format::error::SceneError;
use crate::scene::model::Scene;

/// What a scene file holds, as far as it can be told.
#[derive(Debug)]
pub struct Survey {
    /// The scene without what is wrong, if that makes one.
    pub scene: Option<Scene>,
    /// What is not supported; the first [`MOST_FAULTS`](Self::MOST_FAULTS) of it.
    pub unsupported: Vec<SceneError>,
    /// What else is wrong; as many.
    pub errors: Vec<SceneError>,
    /// How much more is wrong or not supported.
    pub more: u64,
}

impl Survey {
    /// Faults of either kind that are kept.
    pub const MOST_FAULTS: usize = 100;
}
