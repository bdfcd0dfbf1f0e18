//! Collection of all errors of a scene, instead of a stop at the first one.

use crate::scene::directives::state::SceneBuilder;
use crate::scene::format::error::{Location, SceneError};
use crate::scene::model::Scene;
use crate::scene::survey::Survey;

/// The errors of a scene, in the order in which they were found.
#[derive(Debug, Default)]
pub struct Collected {
    /// Unsupported features.
    pub unsupported: Vec<SceneError>,
    /// Other errors.
    pub errors: Vec<SceneError>,
    /// Number of errors that are not kept.
    pub more: u64,
}

impl Collected {
    /// Adds an error, or counts it if the list is full.
    fn add(&mut self, error: SceneError) {
        let list = match error {
            SceneError::Unsupported { .. } => &mut self.unsupported,
            _ => &mut self.errors,
        };
        if list.len() < Survey::MOST_FAULTS {
            list.push(error);
        } else {
            self.more += 1;
        }
    }
}

impl SceneBuilder {
    /// Makes the builder continue after errors, and collect them.
    pub fn collect_errors(&mut self) {
        self.collected = Some(Collected::default());
    }

    pub fn collects_errors(&self) -> bool {
        self.collected.is_some()
    }

    /// Returns true if there are more errors than are kept.
    pub fn has_many_errors(&self) -> bool {
        self.collected.as_ref().is_some_and(|collected| collected.more > 0)
    }

    /// Returns true if an outcome is an error that was collected. An error of memory is returned as an
    /// error, because the next directives would need more memory.
    pub fn notes(&mut self, outcome: Result<(), SceneError>) -> Result<bool, SceneError> {
        match (outcome, &mut self.collected) {
            (Ok(()), _) => Ok(false),
            (Err(error @ SceneError::TooLarge { .. }), _) => Err(error),
            (Err(error), Some(collected)) => {
                collected.add(error);
                Ok(true)
            }
            (Err(error), None) => Err(error),
        }
    }

    /// Returns the scene without the directives that have errors, if there is one, and the errors.
    pub fn finish_collecting(mut self, end: &Location) -> (Option<Scene>, Collected) {
        match self.resolve(end) {
            Ok(scene) => (Some(scene), self.collected.unwrap_or_default()),
            Err(error) => (None, self.collected_with(error)),
        }
    }

    /// Returns the collected errors and a last one.
    pub fn collected_with(self, error: SceneError) -> Collected {
        let mut collected = self.collected.unwrap_or_default();
        collected.errors.push(error);
        collected
    }
}
