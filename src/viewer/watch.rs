//! The thread that watches the files of the scene for changes.

use std::fs;
use std::path::PathBuf;
use std::time::{Duration, SystemTime};

use super::shared::Shared;

/// The time between two looks at the files: short enough for a person who saves a file and then looks up.
const BETWEEN: Duration = Duration::from_millis(500);

/// Returns the time of the last change of each file; `None` if the file does not exist.
fn times(files: &[PathBuf]) -> Vec<Option<SystemTime>> {
    files.iter().map(|file| fs::metadata(file).and_then(|data| data.modified()).ok()).collect()
}

/// Calls `changed` whenever a file of the scene has changed, until the window closes.
pub fn run(shared: &Shared, files: Vec<PathBuf>, changed: impl Fn()) {
    let mut files = files;
    let mut before = times(&files);
    while !shared.waits_for_close(BETWEEN) {
        if let Some(others) = shared.files_of_new_scene() {
            files = others;
            before = times(&files);
        }
        let now = times(&files);
        // A file that is being replaced may be missing for a moment.
        if now != before && now.iter().all(Option::is_some) {
            before = now;
            changed();
        }
    }
}
