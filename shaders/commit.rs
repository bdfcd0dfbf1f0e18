//! The commit from which goblet is built, for reports of measurements.

use std::env;
use std::path::Path;
use std::process::Command;

/// Sets `GOBLET_COMMIT` for the crate, in a release build whose sources are the root of a git working
/// tree. Cargo then builds goblet again after each commit, which would only cost time in a debug build:
/// nothing is measured with one.
pub fn set(root: &Path) {
    if env::var("PROFILE").as_deref() != Ok("release") || !root.join(".git").exists() {
        return;
    }
    let git = |arguments: &[&str]| {
        let output = Command::new("git").arg("-C").arg(root).args(arguments).output().ok()?;
        let text = String::from_utf8(output.stdout).ok()?.trim().to_owned();
        (output.status.success() && !text.is_empty()).then_some(text)
    };
    if let (Some(commit), Some(log)) = (git(&["rev-parse", "HEAD"]), git(&["rev-parse", "--git-path", "logs/HEAD"])) {
        println!("cargo:rustc-env=GOBLET_COMMIT={commit}");
        let log = root.join(log);
        // A file that is not there would make every build build all of it.
        if log.exists() {
            println!("cargo:rerun-if-changed={}", log.display());
        }
    }
}
