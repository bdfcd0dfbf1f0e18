//! The report of `tests/gpu.sh`: it is JSON whatever the parts print, and says which of them are not well.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::process::{Command, Stdio};

use crate::support::command::{self, Bench, Run, goblet};
use crate::support::root;

const CPU: &str = "0  llvmpipe\n   CPU; driver llvmpipe; 1.0 GiB free; fits\n";

/// A folder as `gpu.sh --pack` lays it out, on a machine whose only device is a CPU. The suites and the benchmark
/// are scripts.
fn pack(kernels: &str, rays: &str) -> Bench {
    let bench = Bench::new();
    let program = format!("[ \"$1\" = devices ] && echo '{}' || exec '{}' \"$@\"", CPU.trim_end(), goblet().display());
    for (name, script) in [("goblet", program.as_str()), ("kernels", kernels), ("rays", rays)] {
        bench.write(&format!("pack/{name}"), format!("#!/bin/sh\n{script}\n"));
        fs::set_permissions(bench.path("pack").join(name), fs::Permissions::from_mode(0o755)).unwrap();
    }
    bench.write("pack/commit", "0123abcd\n");
    bench.write("pack/scenes/wine-cup.pbrt", fs::read(root().join("scenes/wine-cup.pbrt")).unwrap());
    bench.write("pack/gpu.sh", fs::read(root().join("tests/gpu.sh")).unwrap());
    bench
}

fn run(bench: &Bench, arguments: &[&str]) -> Run {
    let mut script = Command::new("sh");
    script.arg("pack/gpu.sh").args(arguments).current_dir(bench.0.path()).stdin(Stdio::null());
    command::isolate(&mut script);
    Run::of(script.output().expect("sh"))
}

#[test]
fn the_report_of_a_graphics_card_says_what_failed_and_has_the_rest() {
    let kernels = r#"printf 'running 2 tests\ntest a ... ok\ntest b ... FAILED\n"\\"\t\033[1mé\n'; exit 101"#;
    let bench = pack(kernels, r#"echo '| "water" | 1.5 |'"#);
    let run = run(&bench, &["--dry-run", "out", "kernels", "rays", "picture"]);
    assert_eq!(run.code, 1, "{run:?}");

    let report = bench.json("out/report.json");
    assert_eq!(report["dry_run"], true);
    assert_eq!(report["commit"], "0123abcd");
    let parts = report["parts"].as_object().expect("the parts");
    let statuses: Vec<_> = parts.iter().map(|(name, part)| (name.as_str(), part["status"].as_str().unwrap())).collect();
    assert_eq!(statuses, [("kernels", "failed"), ("picture", "ok"), ("rays", "ok")]);
    assert_eq!(parts["kernels"]["results"]["kernels"], serde_json::json!({ "tests": 2, "passed": 1 }));
    let log = parts["kernels"]["log"].as_array().expect("lines");
    assert!(log.contains(&r#""\" [1mé"#.into()), "{log:?}");
    assert_eq!(parts["rays"]["results"]["rays"][0], r#"| "water" | 1.5 |"#);
    assert_eq!(parts["picture"]["results"]["picture"]["photons"], 32768);
    let picture = bench.image("out/picture.png");
    assert_eq!([picture.width, picture.height], [64, 48]);
}

#[test]
fn a_graphics_card_is_not_well_because_nothing_ran() {
    let bench = pack("echo 'running 0 tests'", "");
    let run_of_none = run(&bench, &["--dry-run", "out", "kernels"]);
    assert_eq!(run_of_none.code, 1, "{run_of_none:?}");
    assert_eq!(bench.json("out/report.json")["parts"]["kernels"]["status"], "failed");

    let on_cpu = run(&bench, &["full", "kernels"]);
    on_cpu.assert_refused("a CPU", 2, &["the only device that can render is a CPU"]);
    assert_eq!(on_cpu.stderr.lines().count(), 1, "{on_cpu:?}");
    assert!(!bench.path("full").exists());
    run(&bench, &["--dry-run", "out", "kernel"]).assert_refused("an unknown part", 2, &["there is no part kernel"]);
}
