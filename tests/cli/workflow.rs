//! The script of `.github/workflows/images.yml`, run as a runner would: it passes what is right,
//! and fails with a picture for what is not.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::support::command::{self, Bench, LIGHT, scene};

/// The lines of a step's `run: |`.
fn script(step: &str) -> String {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/.github/workflows/images.yml");
    let workflow = fs::read_to_string(file).expect("the workflow");
    let lines = workflow.lines().skip_while(|line| line.trim() != format!("- name: {step}"));
    let lines = lines.skip_while(|line| line.trim() != "run: |").skip(1);
    let script: Vec<&str> = lines.take_while(|line| line.starts_with("          ")).collect();
    assert!(script.len() > 3, "no script in {step}");
    script.join("\n")
}

/// Runs the gate over the scenes here.
fn gate(bench: &Bench, scenes: &str) -> bool {
    let goblet = Path::new(env!("CARGO_BIN_EXE_goblet"));
    let paths = std::env::var_os("PATH").unwrap_or_default();
    let folders = [goblet.parent().expect("a folder").to_owned()].into_iter().chain(std::env::split_paths(&paths));
    // As runners run `shell: bash`.
    let mut bash = Command::new("bash");
    bash.args(["--noprofile", "--norc", "-eo", "pipefail", "-c", &script("Render and compare")]);
    bash.current_dir(bench.0.path()).env("PATH", std::env::join_paths(folders).expect("a path"));
    bash.envs([("SCENES", scenes), ("OPTIONS", "--iterations 4"), ("MAX_RELMSE", "0.01"), ("MAX_ENERGY", "0.01")]);
    command::isolate(&mut bash);
    let output = bash.output().expect("bash");
    println!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    output.status.success()
}

#[test]
fn the_gate_of_the_workflow_tells_right_from_wrong() {
    let bench = Bench::new();
    bench.rendered(&["--iterations", "4", "-o", "scene.exr"]);
    assert!(gate(&bench, "scene.pbrt"), "the image of the same scene");
    bench.write("dark.pbrt", scene(LIGHT, &LIGHT.replace("5 5 5", "4 4 4")));
    fs::copy(bench.path("scene.exr"), bench.path("dark.exr")).expect("a reference");
    assert!(!gate(&bench, "dark.pbrt scene.pbrt"), "a lamp that is too dark");
    for name in ["dark-difference.png", "dark.png", "dark.json", "scene.exr"] {
        assert!(bench.path("images").join(name).exists(), "{name}");
    }
    assert!(!gate(&bench, "missing.pbrt"));
}
