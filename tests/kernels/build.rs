//! Compiles the kernels of tests.

use std::process::ExitCode;

use goblet_shaders::{Build, Scope};

fn main() -> ExitCode {
    goblet_shaders::main(&Build {
        root: "../..",
        folder: "tests/kernels",
        // The only size that tests of kernels dispatch.
        workgroup_sizes: &[64],
        scope: Scope::Tests,
    })
}
