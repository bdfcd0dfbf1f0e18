//! Compiles the passes: `$OUT_DIR/kernels.rs`.

mod commit;

use std::path::Path;
use std::process::ExitCode;

use goblet_shaders::{Build, Scope};

fn main() -> ExitCode {
    commit::set(Path::new("."));
    // Results must not depend on the workgroup size; tests render with each of these.
    goblet_shaders::main(&Build {
        root: ".",
        folder: "shaders/passes",
        workgroup_sizes: &[32, 64, 128],
        scope: Scope::Library,
    })
}
