//! Errors of reading a scene, with their place in the text.

use std::fmt;
use std::io;
use std::path::PathBuf;
use std::sync::Arc;

use crate::base::input::OverBudget;

/// A place in a scene file; prints as `file:line:column`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Location {
    /// Name of the file, as the user or the including file gave it.
    pub file: Arc<str>,
    /// Line number, from 1.
    pub line: u32,
    /// Column number in characters, from 1.
    pub column: u32,
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}:{}", self.file, self.line, self.column)
    }
}

impl Location {
    /// Returns the error that the scene is invalid at this place.
    pub(in crate::scene) fn invalid(&self, message: impl Into<String>) -> SceneError {
        SceneError::Invalid { location: self.clone(), message: bounded(message.into()) }
    }

    /// Returns a function from an exceeded budget to the error that this place needs too much memory.
    pub(in crate::scene) fn over(&self) -> impl Fn(OverBudget) -> SceneError {
        |over| self.too_large("", over)
    }

    /// Returns the error that this place needs too much memory. `what` names the object and its verb, with
    /// a blank at the end, or is empty.
    pub(in crate::scene) fn too_large(&self, what: &str, over: OverBudget) -> SceneError {
        SceneError::TooLarge { location: self.clone(), message: format!("{what}too large: {over}") }
    }

    /// Returns the error that the scene is valid but needs an unsupported feature. `what` starts the
    /// sentence, and `supported` lists the alternatives.
    pub(in crate::scene) fn unsupported(&self, what: &str, supported: &str) -> SceneError {
        SceneError::Unsupported {
            location: self.clone(),
            message: bounded(format!("{what} is not supported yet; supported here: {supported}")),
        }
    }
}

/// The reason why a scene could not be read.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// The scene is not a valid pbrt-v4 scene, or no renderer could render it.
    #[error("{location}: {message}")]
    Invalid {
        /// Place of the error.
        location: Location,
        /// The offending text, and the expected text.
        message: String,
    },
    /// The scene is valid but needs a feature that goblet does not have.
    #[error("{location}: {message}")]
    Unsupported {
        /// Place of the error.
        location: Location,
        /// The missing feature, and the supported ones.
        message: String,
    },
    /// The scene needs more memory than its budget.
    #[error("{location}: {message}")]
    TooLarge {
        /// Place of the directive or value that needs the memory.
        location: Location,
        /// The bytes needed, and the bytes permitted.
        message: String,
    },
    /// A file could not be opened or read.
    #[error("{}cannot read {}: {source}", prefix(.location), bounded(.path.display().to_string()))]
    Unreadable {
        /// The file that could not be read.
        path: PathBuf,
        /// Place of the directive that names the file; `None` for the scene file itself.
        location: Option<Location>,
        /// The operating system's reason.
        source: io::Error,
    },
}

/// Shortens a message to 2000 characters: names in a scene may have any length.
pub(in crate::scene) fn bounded(mut message: String) -> String {
    const MOST: usize = 2000;
    if let Some((end, _)) = message.char_indices().nth(MOST) {
        message.truncate(end);
        message.push('…');
    }
    message
}

fn prefix(location: &Option<Location>) -> String {
    location.as_ref().map_or_else(String::new, |location| format!("{location}: "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn display_is_file_line_column_message() {
        let location = Location { file: "a.pbrt".into(), line: 3, column: 14 };
        assert_eq!(location.invalid("no").to_string(), "a.pbrt:3:14: no".to_string());
        let error =
            SceneError::Unreadable { path: "b.ply".into(), location: Some(location), source: io::Error::other("gone") };
        assert_eq!(error.to_string(), "a.pbrt:3:14: cannot read b.ply: gone");
    }
}
