//! The array jobs of `docs/`, run as a scheduler would, against one render.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::support::command::{self, Bench, Run};

const TASKS: u32 = 3;
const ITERATIONS: &str = "7";

fn docs(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("docs").join(name)
}

/// A command that runs in the bench and finds this build of goblet.
fn program(bench: &Bench, program: &str) -> Command {
    let goblet = Path::new(env!("CARGO_BIN_EXE_goblet"));
    let folders = [goblet.parent().unwrap().to_owned()].into_iter();
    let path = std::env::var_os("PATH").unwrap_or_default();
    let all = std::env::join_paths(folders.chain(std::env::split_paths(&path))).unwrap();
    let mut command = Command::new(program);
    command.current_dir(bench.0.path()).env("PATH", all).env("GOBLET", goblet).env_remove("SHARD");
    command::isolate(&mut command);
    command
}

fn assert_runs(command: &mut Command) {
    let run = Run::of(command.output().unwrap());
    assert_eq!(run.code, 0, "{command:?}: {run:?}");
}

fn assert_refused(command: &mut Command, words: &str) {
    Run::of(command.output().unwrap()).assert_refused(&format!("{command:?}"), 2, &[words]);
}

/// A task of an array, without a Slurm.
fn task(bench: &Bench, index: u32, iterations: &str) -> Command {
    let mut command = program(bench, "sh");
    command.arg(docs("slurm-array.sh")).args(["scene.pbrt", "parts", iterations]);
    command.env("SLURM_ARRAY_TASK_ID", index.to_string()).env("SLURM_ARRAY_TASK_COUNT", TASKS.to_string());
    command.env("SLURM_ARRAY_TASK_MIN", "0").env("SLURM_ARRAY_TASK_STEP", "1");
    command
}

/// Merges what is in `parts`, and compares with one render.
fn assert_merges(bench: &Bench, iterations: &str) {
    let parts: Vec<String> = (0..TASKS).map(|index| format!("parts/{index}.checkpoint")).collect();
    let parts: Vec<&str> = parts.iter().map(String::as_str).collect();
    let run = bench.run(&[&["merge"], &parts[..], &["-o", "merged.exr"]].concat());
    assert_eq!((run.code, run.stderr.as_str()), (0, "wrote merged.exr\n"));
    bench.rendered(&["--radius-schedule", "global", "--iterations", iterations, "-o", "whole.exr"]);
    assert!(bench.bytes("merged.exr") == bench.bytes("whole.exr"));
}

/// With the variables that Slurm sets, and where there is one, by it too.
#[test]
fn an_array_of_tasks_makes_the_image_of_one_render() {
    let bench = Bench::new();
    // Task 1 was preempted early; task 2 is rendered when somebody finds it missing.
    for (index, iterations) in [(1, "3"), (0, ITERATIONS), (1, ITERATIONS)] {
        assert_runs(&mut task(&bench, index, iterations));
    }
    let mut missing = program(&bench, "sh");
    missing.arg(docs("slurm-array.sh")).args(["scene.pbrt", "parts", ITERATIONS]);
    assert_refused(&mut missing, "neither in an array nor is SHARD set");
    assert_runs(missing.env("SHARD", "2/3"));
    assert_merges(&bench, ITERATIONS);

    // More iterations are added by running it again.
    (0..TASKS).for_each(|index| assert_runs(&mut task(&bench, index, "8")));
    assert_merges(&bench, "8");
    assert_refused(program(&bench, "sh").arg(docs("slurm-array.sh")), "usage: sbatch");
    let mut other = task(&bench, 0, "8");
    assert_refused(
        other.args(["--seed", "1"]),
        "parts/0.checkpoint: seed: the checkpoint was made with 0, and this render has 1; expected --seed 0",
    );
    if has_slurm() {
        assert_slurm_merges();
    }
}

/// By AWS Batch's names too.
#[test]
fn the_script_knows_other_arrays() {
    let bench = Bench::new();
    for index in 0..TASKS {
        let mut command = program(&bench, "sh");
        command.arg(docs("slurm-array.sh")).args(["scene.pbrt", "parts", ITERATIONS]);
        command.env("AWS_BATCH_JOB_ARRAY_INDEX", index.to_string()).env("AWS_BATCH_JOB_ARRAY_SIZE", TASKS.to_string());
        assert_runs(&mut command);
    }
    assert_merges(&bench, ITERATIONS);
}

/// A Slurm that answers.
fn has_slurm() -> bool {
    let nodes = Command::new("sinfo").arg("--noheader").output();
    nodes.is_ok_and(|output| output.status.success() && !output.stdout.is_empty())
}

/// The array as Slurm runs it.
fn assert_slurm_merges() {
    let bench = Bench::new();
    let array = format!("--array=0-{}", TASKS - 1);
    let mut command = program(&bench, "sbatch");
    command.args(["--wait", &array]).arg(docs("slurm-array.sh")).args(["scene.pbrt", "parts", ITERATIONS]);
    assert_runs(&mut command);
    assert_merges(&bench, ITERATIONS);
}

/// What follows `key` on the first line that has it.
fn value<'a>(manifest: &'a str, key: &str) -> &'a str {
    let line = manifest.lines().find_map(|line| line.trim_start().strip_prefix(key));
    line.unwrap_or_else(|| panic!("no {key} in the manifest")).trim()
}

#[test]
fn the_manifest_of_kubernetes_makes_the_image_of_one_render() {
    let manifest = fs::read_to_string(docs("kubernetes-job.yaml")).unwrap();
    assert_eq!((value(&manifest, "kind:"), value(&manifest, "completionMode:")), ("Job", "Indexed"));
    let variables = manifest.split("env:").nth(1).and_then(|rest| rest.split("command:").next()).unwrap();
    let count = variables.split("name: JOB_COMPLETIONS").nth(1).expect("JOB_COMPLETIONS");
    assert_eq!(value(count, "value:"), format!("{:?}", value(&manifest, "completions:")));
    for name in ["SCENE", "FOLDER", "ITERATIONS"] {
        assert!(variables.contains(&format!("- name: {name}\n")), "{name}");
    }
    assert!(!manifest.contains('\t'), "YAML has no tabs");

    // Its script is what stands deeper than the bar.
    assert_eq!(value(&manifest, "command:"), r#"["/bin/sh", "-euc"]"#);
    let script: Vec<&str> = manifest
        .lines()
        .skip_while(|line| line.trim() != "- |")
        .skip(1)
        .take_while(|line| line.starts_with("              "))
        .map(str::trim_start)
        .collect();
    let bench = Bench::new();
    fs::create_dir(bench.path("parts")).unwrap();
    for (index, iterations) in [(1, "2"), (0, ITERATIONS), (1, ITERATIONS), (2, ITERATIONS)] {
        let mut pod = program(&bench, "/bin/sh");
        pod.args(["-euc", &script.join("\n")]).envs([
            ("JOB_COMPLETION_INDEX", index.to_string().as_str()),
            ("JOB_COMPLETIONS", &TASKS.to_string()),
            ("SCENE", "scene.pbrt"),
            ("FOLDER", "parts"),
            ("ITERATIONS", iterations),
        ]);
        assert_runs(&mut pod);
    }
    assert_merges(&bench, ITERATIONS);
}
