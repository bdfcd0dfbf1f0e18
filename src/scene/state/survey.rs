//! A scene may be asked for all that goblet cannot render, rather than for the first of it.

use super::super::error::{Location, SceneError};
use super::super::model::Scene;
use super::SceneBuilder;

impl SceneBuilder {
    /// Goes on after what is not supported, and remembers it.
    pub fn collect_unsupported(&mut self) {
        self.unsupported = Some(Vec::new());
    }

    pub fn collects_unsupported(&self) -> bool {
        self.unsupported.is_some()
    }

    /// Whether an outcome is of what is not supported, and remembered.
    pub fn notes(&mut self, outcome: Result<(), SceneError>) -> Result<bool, SceneError> {
        match (outcome, &mut self.unsupported) {
            (Ok(()), _) => Ok(false),
            (Err(error @ SceneError::Unsupported { .. }), Some(all)) => {
                all.push(error);
                Ok(true)
            }
            (Err(error), _) => Err(error),
        }
    }

    /// The scene, and what was not supported.
    pub fn finish_collecting(mut self, end: &Location) -> (Result<Scene, SceneError>, Vec<SceneError>) {
        let scene = self.resolve(end);
        (scene, self.unsupported.unwrap_or_default())
    }
}
