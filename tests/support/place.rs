//! Where files are: in the project, unless `tests/gpu.sh` has carried the programs elsewhere. It says so in the
//! variables that cargo sets for what it runs.

use std::path::PathBuf;

/// The folder of `Cargo.toml`, or one with the same `scenes` and `tests/reference`.
pub fn root() -> PathBuf {
    std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or_else(|| env!("CARGO_MANIFEST_DIR").into()).into()
}
