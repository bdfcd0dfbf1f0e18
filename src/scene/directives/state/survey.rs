//! A scene may be asked for all that is wrong with it, rather than for the first of it.

use crate::scene::directives::state::SceneBuilder;
use crate::scene::format::error::{Location, SceneError};
use crate::scene::model::Scene;
use crate::scene::survey::Survey;

/// What is wrong with a scene, in the order in which it was found.
#[derive(Debug, Default)]
pub struct Collected {
    /// What goblet does not have.
    pub unsupported: Vec<SceneError>,
    /// All else.
    pub errors: Vec<SceneError>,
    /// How many are not kept.
    pub more: u64,
}

impl Collected {
    /// Keeps an error, if there are not too many.
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
    /// Goes on after what is wrong, and remembers it.
    pub fn collect_errors(&mut self) {
        self.collected = Some(Collected::default());
    }

    pub fn collects_errors(&self) -> bool {
        self.collected.is_some()
    }

    /// Whether there are more errors than are kept.
    pub fn has_many_errors(&self) -> bool {
        self.collected.as_ref().is_some_and(|collected| collected.more > 0)
    }

    /// Whether an outcome is an error that is remembered.
    /// One of memory is not: what comes next would need more.
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

    /// The scene without what is wrong, if that makes one, and what is.
    pub fn finish_collecting(mut self, end: &Location) -> (Option<Scene>, Collected) {
        match self.resolve(end) {
            Ok(scene) => (Some(scene), self.collected.unwrap_or_default()),
            Err(error) => (None, self.collected_with(error)),
        }
    }

    /// What is wrong, and an error that ends the search.
    pub fn collected_with(self, error: SceneError) -> Collected {
        let mut collected = self.collected.unwrap_or_default();
        collected.errors.push(error);
        collected
    }
}
