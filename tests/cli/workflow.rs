//! The script of `.github/workflows/images.yml`, run as a runner would: it passes what is right,
//! and fails with a picture for what is not. The commands of docs/ci.md, run as they are written.

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

/// A shell as runners run `shell: bash`, in a folder, with goblet on its path.
fn shell(bench: &Bench, script: &str) -> Command {
    let goblet = Path::new(env!("CARGO_BIN_EXE_goblet"));
    let paths = std::env::var_os("PATH").unwrap_or_default();
    let folders = [goblet.parent().expect("a folder").to_owned()].into_iter().chain(std::env::split_paths(&paths));
    let mut bash = Command::new("bash");
    bash.args(["--noprofile", "--norc", "-eo", "pipefail", "-c", script]);
    bash.current_dir(bench.0.path()).env("PATH", std::env::join_paths(folders).expect("a path"));
    command::isolate(&mut bash);
    bash
}

/// Runs the gate over the scenes here.
fn gate(bench: &Bench, scenes: &str) -> bool {
    let mut bash = shell(bench, &script("Render and compare"));
    bash.envs([("SCENES", scenes), ("OPTIONS", "--iterations 4"), ("MAX_RELMSE", "0.01"), ("MAX_ENERGY", "0.01")]);
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

const PAGE: &str = include_str!("../../docs/ci.md");

/// The lines of the page's fenced blocks of a language; those of a list are indented.
fn lines_of(language: &str) -> Vec<&'static str> {
    let mut lines = Vec::new();
    let mut inside = false;
    for line in PAGE.lines() {
        if line.trim_start().starts_with("```") {
            inside = line.trim() == format!("```{language}");
        } else if inside {
            lines.push(line);
        }
    }
    lines
}

/// The scene's film is larger than the reference, as the page allows.
#[test]
fn every_command_of_the_ci_page_works() {
    let bench = Bench::new();
    let film = scene(
        r#""integer xresolution" 16 "integer yresolution" 12"#,
        r#""integer xresolution" 512 "integer yresolution" 512"#,
    );
    bench.write("glass.pbrt", film);
    let installer = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/install.sh")).expect("install.sh");
    let commands = lines_of("sh");
    let mut count = 0;
    for command in commands.iter().map(|line| line.trim()) {
        if let Some(arguments) = command.strip_prefix("apt-get ") {
            // What it installs is what install.sh does, which continuous integration runs.
            let packages = arguments.split(' ').filter(|word| !word.starts_with('-'));
            let packages = packages.filter(|word| !["install", "update"].contains(word));
            assert!(packages.clone().all(|package| installer.contains(package)), "{command}");
            continue;
        }
        let output = shell(&bench, command).output().expect("bash");
        let [out, error] = [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned());
        assert!(output.status.success(), "{command}\n{out}{error}");
        count += 1;
    }
    assert!(count >= 5, "{count} commands: {commands:?}");
    assert_eq!([bench.image("glass.exr").width, bench.image("reference/glass.exr").width], [128; 2]);
    // Image, reference and the map with its scale, a zoom of two.
    assert!(bench.image("difference.png").width > 3 * 256);
    let report = bench.text("out/report.html");
    for words in ["Each turn by itself", "trimmed", "mean energy"] {
        assert!(report.contains(words), "{words}");
    }
    let runs = &bench.json("out/results.json")["settings"][0]["points"];
    let runs = runs.as_array().and_then(|points| points.last()?["runs"].as_array().cloned()).expect("runs");
    assert!(runs.len() == 4 && runs.iter().all(|run| run["relmse_trimmed"].as_f64().is_some_and(|it| it < 0.01)));

    // Without the size, each command says what to do.
    let refuse = |arguments: &[&str], words: &str| {
        let run = bench.run(arguments);
        assert!(run.code == 2 && run.stderr.contains(words), "{run:?}");
    };
    refuse(&["measure", "glass.pbrt", "--reference", "reference/glass.exr", "-o", "x"], "--vary resolution=128x128");
    bench.rendered(&["--iterations", "1", "-o", "other.exr"]);
    refuse(&["compare", "other.exr", "reference/glass.exr"], "`goblet render --resolution 128x128`");
}

#[test]
fn the_workflow_takes_what_the_ci_page_gives_it() {
    let workflow = include_str!("../../.github/workflows/images.yml");
    let (_, after) = workflow.split_once("inputs:").expect("inputs");
    let (inputs, _) = after.split_once("jobs:").expect("jobs");
    let lines = lines_of("yaml");
    let given = lines.iter().skip_while(|line| line.trim() != "with:").skip(1);
    let names: Vec<&str> = given.filter_map(|line| line.trim().split(':').next()).collect();
    assert!(names.len() >= 5, "{lines:?}");
    assert!(names.iter().all(|name| inputs.contains(&format!("\n      {name}:"))), "{names:?}");
    let options = lines.iter().find_map(|line| line.trim().strip_prefix("options: ")).expect("options");
    let bench = Bench::new();
    let output = shell(&bench, &format!("goblet render scene.pbrt {options} -o scene.exr")).output().expect("bash");
    assert!(output.status.success() && bench.image("scene.exr").width == 128, "{output:?}");
}
