//! Signals, kills and full disks.

use std::fs::{self, File};
use std::process::{Child, Stdio};
use std::thread::sleep;
use std::time::{Duration, SystemTime};

use goblet::render::checkpoint::Checkpoint;

use crate::support::command::{self, Bench, Run, send, wait_until};
use crate::support::random::Rng;
use crate::support::work;

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
    assert_eq!(child.wait().unwrap().code(), Some(130));
    // A render that had finished its iteration would have written it.
    assert!(!bench.path("x.exr").exists());
}

#[test]
fn a_checkpoint_that_cannot_be_written_costs_no_image() {
    let bench = Bench::new();
    fs::create_dir(bench.path("folder")).unwrap();
    let file = "folder/x.checkpoint";
    let said = || fs::read_to_string(bench.path("said.txt")).unwrap();
    let child = bench
        .command(&["render", "scene.pbrt", "--iterations", "4000000000", "-o", "x.exr"])
        .args(["--checkpoint", file, "--checkpoint-every", "1e-9"])
        .stderr(File::create(bench.path("said.txt")).unwrap())
        .spawn()
        .unwrap();
    wait_until("there is a checkpoint", || bench.path(file).exists());
    // In vain while a temporary file is being made.
    wait_until("the folder is gone", || fs::remove_dir_all(bench.path("folder")).is_ok());
    wait_until("a warning is given", || said().contains("warning: folder/x.checkpoint: cannot write"));
    send("-INT", &child);
    assert_eq!(child.wait_with_output().unwrap().status.code(), Some(1), "{}", said());
    for words in ["wrote x.exr", "goblet: folder/x.checkpoint: cannot"] {
        assert!(said().contains(words), "expected `{words}` in: {}", said());
    }
    assert!(bench.path("x.exr").exists());
}

/// Sleeps for a random time below `limit` milliseconds.
fn sleep_below(limit: usize, rng: &mut Rng) {
    sleep(Duration::from_micros(rng.below(1000 * limit) as u64));
}

fn written(bench: &Bench) -> Option<SystemTime> {
    fs::metadata(bench.path(CHECKPOINT)).and_then(|file| file.modified()).ok()
}

fn temporary_files(bench: &Bench) -> usize {
    let names = fs::read_dir(bench.0.path()).unwrap().map(|entry| entry.unwrap().file_name());
    names.filter(|name| name.to_string_lossy().starts_with(".goblet-")).count()
}

/// Each render resumes what the last one left. A fifth of them are killed at any time, two fifths
/// soon after they have written a checkpoint, and two fifths while a checkpoint is being written,
/// as far as a poll of the folder can tell: kills go on until three (two in the quick form) have met one.
#[test]
fn kills_at_any_time_do_not_change_a_byte() {
    let bench = Bench::new();
    // Large enough that most of the time is spent on checkpoints.
    bench.write("scene.pbrt", command::scene("16 \"integer yresolution\" 12", "64 \"integer yresolution\" 48"));
    let (mut rng, mut done, mut torn, mut kills) = (Rng(1), 0, 0, 0);
    let (least, enough) = work((5, 2), (10, 3));
    while kills < least || torn < enough {
        assert!(kills < 200, "{torn} of {kills} kills have met a checkpoint that was being written");
        let before = written(&bench);
        let resume: &[&str] = if before.is_some() { &["--resume", CHECKPOINT] } else { &[] };
        let mut child = start(&bench, &[&ENDLESS[..], resume].concat());
        let anytime = kills % 5 == 4;
        if anytime {
            sleep_below(400, &mut rng);
        } else {
            wait_until("a checkpoint is written", || written(&bench) != before);
            match kills % 2 {
                0 => wait_until("a checkpoint is being written", || temporary_files(&bench) > 0),
                _ => sleep_below(50, &mut rng),
            }
        }
        kills += 1;
        child.kill().unwrap();
        let status = child.wait().unwrap();
        assert_eq!(status.code(), None, "it ended by itself: {status}");

        let now = iterations(&bench);
        assert!(now > done || (now == done && anytime), "{now} iterations after {done}");
        done = now;
        let left = temporary_files(&bench);
        assert!(left <= torn + 1, "{left} temporary files after {torn}");
        torn = left;
    }
    println!("{torn} of {kills} kills have met a checkpoint that was being written, {done} iterations");
    assert_resumes(&bench, 2);
    // A run that ends by itself leaves none.
    assert_eq!(temporary_files(&bench), torn);
}
