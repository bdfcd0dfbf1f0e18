//! The files that a scene names.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use flate2::read::MultiGzDecoder;

use crate::base::input::{self, Budget, Held};
use crate::scene::format::error::{Location, SceneError};

/// Returns the folder that a scene's file names are relative to.
pub(crate) fn directory(path: &Path) -> &Path {
    path.parent().unwrap_or(Path::new(""))
}

/// Returns a path that is equal for all names of the same file.
pub(crate) fn identity(path: &Path) -> PathBuf {
    fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf())
}

/// Reads the text of a file, gzipped or not, and returns it with the memory that it takes from the budget.
/// Bytes that are not UTF-8 are replaced. `location` is the place that names the file, for the error.
pub(in crate::scene) fn read_text(
    path: &Path,
    location: Option<&Location>,
    budget: &Arc<Budget>,
) -> Result<(String, Held), SceneError> {
    let read = || {
        let mut bytes = input::read(path, budget)?;
        let mut held = budget.hold(bytes.len() as u64)?;
        if bytes.starts_with(&[0x1f, 0x8b]) {
            bytes = input::read_to_end(MultiGzDecoder::new(&bytes[..]), budget)?;
            held = budget.hold(bytes.len() as u64)?;
        }
        if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
            return Err(io::Error::other("it is UTF-16; expected UTF-8"));
        }
        // Old scenes have comments in other encodings, so bytes that are not UTF-8 are replaced. They cause
        // an error only where they have a meaning.
        let text = match String::from_utf8(bytes) {
            Ok(text) => text,
            Err(error) => {
                // A replaced byte takes at most three bytes.
                budget.check(3 * error.as_bytes().len() as u64)?;
                String::from_utf8_lossy(error.as_bytes()).into_owned()
            }
        };
        held.grow((text.len() as u64).saturating_sub(held.bytes()))?;
        Ok((text, held))
    };
    read().map_err(|source| SceneError::Unreadable { path: path.to_path_buf(), location: location.cloned(), source })
}
