//! Sees when files change.

use std::fs;
use std::path::PathBuf;
use std::time::{Duration, SystemTime};

use super::shared::Shared;

/// Files are looked at this often: people who save one look up later.
const BETWEEN: Duration = Duration::from_millis(500);

/// When each file was written, if it is there.
fn times(files: &[PathBuf]) -> Vec<Option<SystemTime>> {
    files.iter().map(|file| fs::metadata(file).and_then(|data| data.modified()).ok()).collect()
}

/// Tells when a file of the scene has changed, until the window closes.
pub fn run(shared: &Shared, files: Vec<PathBuf>, changed: impl Fn()) {
    let mut files = files;
    let mut before = times(&files);
    while !shared.waits_for_close(BETWEEN) {
        if let Some(others) = shared.files_of_new_scene() {
            files = others;
            before = times(&files);
        }
        let now = times(&files);
        // One that is being replaced may be gone for a moment.
        if now != before && now.iter().all(Option::is_some) {
            before = now;
            changed();
        }
    }
}
