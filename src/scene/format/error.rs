//! What can go wrong while a scene is read, always with its place in the text.

use std::fmt;
use std::io;
use std::path::PathBuf;
use std::sync::Arc;

use crate::base::input::OverBudget;

/// A place in a scene file; prints as `file:line:column`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Location {
    /// The file, as the user or the including file named it.
    pub file: Arc<str>,
    /// Line, from 1.
    pub line: u32,
    /// Column in characters, from 1.
    pub column: u32,
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}:{}", self.file, self.line, self.column)
    }
}

impl Location {
    /// The scene is wrong here.
    pub(in crate::scene) fn invalid(&self, message: impl Into<String>) -> SceneError {
        SceneError::Invalid { location: self.clone(), message: bounded(message.into()) }
    }

    /// What stands here needs more memory than the scene may take.
    pub(in crate::scene) fn over(&self) -> impl Fn(OverBudget) -> SceneError {
        |over| self.too_large("", over)
    }

    /// The same, with what is too large: a noun and a verb.
    pub(in crate::scene) fn too_large(&self, what: &str, over: OverBudget) -> SceneError {
        SceneError::TooLarge { location: self.clone(), message: format!("{what}too large: {over}") }
    }

    /// The scene is right, but asks for what goblet cannot do; `what` starts the
    /// sentence and `supported` lists the alternatives.
    pub(in crate::scene) fn unsupported(&self, what: &str, supported: &str) -> SceneError {
        SceneError::Unsupported {
            location: self.clone(),
            message: bounded(format!("{what} is not supported yet; supported here: {supported}")),
        }
    }
}

/// Why a scene could not be read.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// The scene is not a valid pbrt-v4 scene, or cannot be rendered by anyone.
    #[error("{location}: {message}")]
    Invalid {
        /// Where.
        location: Location,
        /// The offending text and what was expected.
        message: String,
    },
    /// The scene is valid but needs a feature that goblet does not have.
    #[error("{location}: {message}")]
    Unsupported {
        /// Where.
        location: Location,
        /// What is missing, and what there is.
        message: String,
    },
    /// The scene needs more memory than it may take.
    #[error("{location}: {message}")]
    TooLarge {
        /// What it would be for.
        location: Location,
        /// How much is needed, and how much may be taken.
        message: String,
    },
    /// A file could not be opened or read.
    #[error("{}cannot read {}: {source}", prefix(.location), bounded(.path.display().to_string()))]
    Unreadable {
        /// The file that could not be read.
        path: PathBuf,
        /// The directive that names it; none for the scene file itself.
        location: Option<Location>,
        /// The operating system's reason.
        source: io::Error,
    },
}

/// Keeps a message on a few screen lines, whatever names the scene has.
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
