//! Signals, kills and full disks.

use std::fs;
use std::process::{Child, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant, SystemTime};

use goblet::render::checkpoint::Checkpoint;

use crate::command::{Bench, Run, send, wait_until};

const CHECKPOINT: &str = "x.checkpoint";
/// A render that saves a checkpoint whenever it can, and never ends by itself.
const ENDLESS: [&str; 9] = [
    "render",
    "scene.pbrt",
    "--quiet",
    "--iterations",
    "4000000000",
    "--checkpoint",
    CHECKPOINT,
    "--checkpoint-every",
    "1e-9",
];

fn start(bench: &Bench, arguments: &[&str]) -> Child {
    bench.command(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

fn iterations(bench: &Bench) -> u64 {
    Checkpoint::read(&bench.path(CHECKPOINT)).expect("a whole checkpoint").estimate.iterations()
}

/// Goes on for some iterations, to the image that one run would have made.
fn assert_resumes(bench: &Bench, more: u64) {
    let total = (iterations(bench) + more).to_string();
    let resume = ["--quiet", "--iterations", &total, "--resume", CHECKPOINT, "-o", "resumed.exr"];
    bench.rendered(&[&resume[..], &["--checkpoint", CHECKPOINT]].concat());
    bench.rendered(&["--quiet", "--iterations", &total, "-o", "whole.exr"]);
    assert!(bench.bytes("resumed.exr") == bench.bytes("whole.exr"), "{total} iterations");
}

#[test]
fn a_signal_ends_a_render_that_can_be_resumed() {
    for signal in ["-INT", "-TERM"] {
        let bench = Bench::new();
        let child = start(&bench, &[&ENDLESS[..], &["-o", "x.exr"]].concat());
        wait_until("there is a checkpoint", || bench.path(CHECKPOINT).exists());
        send(signal, &child);
        let run = Run::of(child.wait_with_output().unwrap());
        assert_eq!((run.code, run.stderr.as_str()), (130, ""), "{signal}");

        // The image and the checkpoint are of the same iterations.
        let done = iterations(&bench).to_string();
        bench.rendered(&["--quiet", "--iterations", &done, "-o", "expected.exr"]);
        assert!(bench.bytes("x.exr") == bench.bytes("expected.exr"), "{signal}: {done} iterations");
        assert_resumes(&bench, 3);
    }
}

/// Whether a process still loads its scene: so long, a thread of this name looks for signals.
fn loads(child: &Child) -> bool {
    let threads = fs::read_dir(format!("/proc/{}/task", child.id())).unwrap().flatten();
    let name = |thread: fs::DirEntry| fs::read_to_string(thread.path().join("comm")).unwrap_or_default();
    threads.map(name).any(|name| name.trim() == "signals")
}

#[test]
fn a_second_signal_ends_it_at_once() {
    let bench = Bench::new();
    // The first iteration would take minutes.
    let mut child = start(&bench, &["render", "scene.pbrt", "--photons", "2e9", "-o", "x.exr"]);
    wait_until("it loads its scene", || loads(&child));
    wait_until("the render has begun", || !loads(&child));
    send("-INT", &child);
    sleep(Duration::from_millis(300));
    assert!(child.try_wait().unwrap().is_none(), "the first signal lets it finish the iteration");
    send("-TERM", &child);
    let start = Instant::now();
    let status = child.wait().unwrap();
    assert_eq!(status.code(), Some(130));
    assert!(start.elapsed() < Duration::from_secs(20) && !bench.path("x.exr").exists());
}

#[test]
fn a_checkpoint_that_cannot_be_written_costs_no_image() {
    let bench = Bench::new();
    fs::create_dir(bench.path("folder")).unwrap();
    let file = "folder/x.checkpoint";
    let child = start(
        &bench,
        &["render", "scene.pbrt", "--time", "60", "--checkpoint", file, "--checkpoint-every", "1e-9", "-o", "x.exr"],
    );
    wait_until("there is a checkpoint", || bench.path(file).exists());
    // In vain while a temporary file is being made.
    wait_until("the folder is gone", || fs::remove_dir_all(bench.path("folder")).is_ok());
    sleep(Duration::from_millis(100));
    send("-INT", &child);
    let run = Run::of(child.wait_with_output().unwrap());
    assert_eq!(run.code, 1, "{run:?}");
    for words in ["warning: folder/x.checkpoint: cannot write", "wrote x.exr", "goblet: folder/x.checkpoint: cannot"] {
        assert!(run.stderr.contains(words), "expected `{words}` in: {run:?}");
    }
    assert!(bench.path("x.exr").exists());
}

/// Milliseconds below `limit`, from a fixed seed.
fn random_time(state: &mut u64, limit: u64) -> Duration {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    Duration::from_micros((*state >> 33) % (1000 * limit))
}

fn written(bench: &Bench) -> Option<SystemTime> {
    fs::metadata(bench.path(CHECKPOINT)).and_then(|file| file.modified()).ok()
}

fn temporary_files(bench: &Bench) -> usize {
    let names = fs::read_dir(bench.0.path()).unwrap().map(|entry| entry.unwrap().file_name());
    names.filter(|name| name.to_string_lossy().starts_with(".goblet-")).count()
}

/// Each goes on from what the one before has left. Most are killed soon after they have
/// written a checkpoint, while they are busy with the next ones, and some at any time.
#[test]
fn twenty_kills_do_not_change_a_byte() {
    let bench = Bench::new();
    // Large enough that most of the time is spent on checkpoints.
    bench.write("scene.pbrt", crate::command::scene("16 \"integer yresolution\" 12", "64 \"integer yresolution\" 48"));
    let (mut state, mut done, mut torn) = (1, 0, 0);
    for kill in 0..20 {
        let before = written(&bench);
        let resume: &[&str] = if before.is_some() { &["--resume", CHECKPOINT] } else { &[] };
        let mut child = start(&bench, &[&ENDLESS[..], resume].concat());
        if kill % 5 == 4 {
            sleep(random_time(&mut state, 400));
        } else {
            wait_until("a checkpoint is written", || written(&bench) != before);
            sleep(random_time(&mut state, 50));
        }
        child.kill().unwrap();
        let status = child.wait().unwrap();
        assert_eq!(status.code(), None, "it ended by itself: {status}");

        let now = iterations(&bench);
        assert!(now > done || (now == done && kill % 5 == 4), "{now} iterations after {done}");
        done = now;
        let left = temporary_files(&bench);
        assert!(left <= torn + 1, "{left} temporary files after {torn}");
        torn = left;
    }
    println!("{torn} kills have met a checkpoint that was being written, {done} iterations");
    assert!(torn > 0, "no kill has met a checkpoint that was being written");
    assert_resumes(&bench, 2);
    // A run that ends by itself leaves none.
    assert_eq!(temporary_files(&bench), torn);
}
