//! A scene may be asked for all that is wrong with it, rather than for the first of it.

use super::super::error::{Location, SceneError};
use super::super::model::Scene;
use super::SceneBuilder;

/// What is wrong with a scene, in the order in which it was found.
#[derive(Debug, Default)]
pub struct Collected {
    /// What goblet does not have.
    pub unsupported: Vec<SceneError>,
    /// All else.
    pub errors: Vec<SceneError>,
}

impl SceneBuilder {
    /// Goes on after what is wrong, and remembers it.
    pub fn collect_errors(&mut self) {
        self.collected = Some(Collected::default());
    }

    pub fn collects_errors(&self) -> bool {
        self.collected.is_some()
    }

    /// Whether an outcome is an error that is remembered.
    pub fn notes(&mut self, outcome: Result<(), SceneError>) -> Result<bool, SceneError> {
        match (outcome, &mut self.collected) {
            (Ok(()), _) => Ok(false),
            (Err(error @ SceneError::Unsupported { .. }), Some(collected)) => {
                collected.unsupported.push(error);
                Ok(true)
            }
            (Err(error), Some(collected)) => {
                collected.errors.push(error);
                Ok(true)
            }
            (Err(error), None) => Err(error),
        }
    }

    /// The scene without what is wrong, if that makes one, and what is.
    pub fn finish_collecting(mut self, end: &Location) -> (Option<Scene>, Collected) {
        let scene = self.resolve(end);
        let mut collected = self.collected.unwrap_or_default();
        match scene {
            Ok(scene) => (Some(scene), collected),
            Err(error) => {
                collected.errors.push(error);
                (None, collected)
            }
        }
    }
}
