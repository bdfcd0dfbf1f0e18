//! Streams that nobody reads, disks that are full, signals, and what must not reach a terminal.

use std::fs::{self, OpenOptions};
use std::os::unix::process::ExitStatusExt;
use std::process::{Child, Command, Stdio};

use goblet::render::checkpoint::Checkpoint;

use crate::support::command::{self, Bench, Run, SCENE, scene, send, wait_until};

/// A pipe whose reader is gone.
fn dead_pipe() -> Stdio {
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    writer.into()
}

fn full() -> Stdio {
    OpenOptions::new().write(true).open("/dev/full").unwrap().into()
}

/// Runs goblet with one of its streams as it is given; what the other has got is returned.
fn run_with(bench: &Bench, arguments: &[&str], stdout: Option<Stdio>, stderr: Option<Stdio>) -> Run {
    let mut command = bench.command(arguments);
    command.stdout(stdout.unwrap_or_else(Stdio::piped)).stderr(stderr.unwrap_or_else(Stdio::piped));
    Run::of(command.spawn().unwrap().wait_with_output().unwrap())
}

/// Runs goblet by a shell, which closes streams.
fn run_closed(bench: &Bench, closed: &str, arguments: &[&str]) -> Run {
    let mut command = Command::new("sh");
    let script = format!("exec \"$0\" \"$@\" {closed}");
    command.args(["-c", &script, env!("CARGO_BIN_EXE_goblet")]).args(arguments).current_dir(bench.0.path());
    command::isolate(&mut command);
    Run::of(command.output().unwrap())
}

const PRINTING: [&[&str]; 12] = [
    &["info", "scene.pbrt"],
    &["info", "scene.pbrt", "--json"],
    &["devices"],
    &["compare", "a.exr", "a.exr"],
    &["compare", "a.exr", "a.exr", "--json"],
    &["advise", "scene.pbrt", "--time", "1", "--probe", "0.1", "--quiet"],
    &["completions", "bash"],
    &["man"],
    &["man", "render"],
    &["--help"],
    &["render", "--help"],
    &["--version"],
];

#[test]
fn what_cannot_be_printed_is_an_error() {
    let bench = Bench::new();
    bench.rendered(&["-o", "a.exr"]);
    for arguments in PRINTING {
        let run = run_with(&bench, arguments, Some(full()), None);
        assert_eq!(run.code, 1, "{arguments:?}: {run:?}");
        assert!(run.stderr.contains("goblet: cannot write to standard output: "), "{arguments:?}: {run:?}");
    }
}

/// As `goblet info scene.pbrt | head -1` does.
#[test]
fn a_reader_that_has_enough_is_no_error() {
    let bench = Bench::new();
    bench.rendered(&["-o", "a.exr"]);
    for arguments in PRINTING {
        let run = run_with(&bench, arguments, Some(dead_pipe()), None);
        assert_eq!((run.code, run.stderr.as_str()), (0, ""), "{arguments:?}");
        let run = run_closed(&bench, ">&-", arguments);
        assert_eq!((run.code, run.stderr.as_str()), (0, ""), "{arguments:?}");
        for stderr in [dead_pipe(), full()] {
            let run = run_with(&bench, arguments, None, Some(stderr));
            assert!(run.code == 0 && !run.stdout.is_empty(), "{arguments:?}");
        }
    }
    // The verdict is that of the images and the scene, whoever listens.
    bench.rendered(&["-o", "b.exr", "--seed", "7"]);
    bench.write("wrong.pbrt", scene("Material \"diffuse\"", "Material \"hair\""));
    for (arguments, code) in
        [(&["compare", "a.exr", "b.exr", "--max-relmse", "0"][..], 1), (&["info", "wrong.pbrt"], 2)]
    {
        assert_eq!(run_with(&bench, arguments, Some(dead_pipe()), None).code, code, "{arguments:?}");
        assert_eq!(run_with(&bench, arguments, None, Some(dead_pipe())).code, code, "{arguments:?}");
    }
    assert_eq!(run_with(&bench, &["rendre"], None, Some(dead_pipe())).code, 2);
}

/// A log collector that has died, `2>&1 | head`, a full log.
#[test]
fn a_render_goes_on_when_nobody_hears_it() {
    let bench = Bench::new();
    // Something is said before, during and after.
    bench.write("scene.pbrt", scene("\"sppm\" \"integer maxdepth\" 6", "\"path\"\n#"));
    let render = ["render", "scene.pbrt", "--photons", "500", "-o", "x.exr", "--checkpoint", "c", "--stats", "s.json"];
    let said = bench.run(&render);
    assert!(said.stderr.contains("warning: ") && said.stderr.contains("wrote x.exr"), "{said:?}");
    let expected = bench.bytes("x.exr");
    let assert_written = |how: &str, run: &Run| {
        assert_eq!(run.code, 0, "{how}: {run:?}");
        assert!(bench.bytes("x.exr") == expected, "{how}");
        assert_eq!(Checkpoint::read(&bench.path("c")).unwrap().estimate.iterations(), 2, "{how}");
        assert_eq!(bench.json("s.json")["iterations"], 2, "{how}");
        for name in ["x.exr", "c", "s.json"] {
            fs::remove_file(bench.path(name)).unwrap();
        }
    };
    assert_written("heard", &said);
    assert_written("dead pipe", &run_with(&bench, &render, None, Some(dead_pipe())));
    assert_written("full disk", &run_with(&bench, &render, None, Some(full())));
    for closed in ["2>&-", ">&-", "<&-", "<&- >&- 2>&-"] {
        assert_written(closed, &run_closed(&bench, closed, &render));
    }
}

#[test]
fn no_other_command_minds_who_hears_it() {
    let bench = Bench::new();
    bench.write("body.pbrt", format!("{SCENE}Shape \"revolution\" \"point2 P\" [ 0 0 .5 0 .6 .4 .6 1 ]"));
    let shard = ["--radius-schedule", "global", "--shard", "0/2", "--checkpoint", "0.checkpoint"];
    bench.rendered(&shard);
    let measure = ["measure", "scene.pbrt", "--reference", "auto", "--budget", "0.1", "--repeat", "1", "-o", "out"];
    for (arguments, written) in [
        (&["merge", "0.checkpoint", "-o", "m.exr"][..], "m.exr"),
        (&["tessellate", "body.pbrt", "-o", "t.pbrt", "--tolerance", "0.01"], "t-1.ply"),
        (&measure, "out/report.html"),
    ] {
        for (how, stderr) in [("dead pipe", dead_pipe()), ("full disk", full())] {
            let run = run_with(&bench, arguments, None, Some(stderr));
            assert_eq!(run.code, 0, "{how}: {arguments:?}");
            fs::remove_file(bench.path(written)).unwrap_or_else(|error| panic!("{how}: {written}: {error}"));
        }
    }
}

/// Where a name stands in a message, a terminal would obey what is in it.
#[test]
fn names_do_not_reach_a_terminal_as_they_are() {
    const NAME: &str = "\u{1b}]0;owned\u{7}\u{9b}2J\r.pbrt";
    let bench = Bench::new();
    bench.write(NAME, scene("\"sppm\" \"integer maxdepth\" 6", "\"path\"\n#"));
    bench.write("wrong\u{1b}[2J.pbrt", "Film \"rgb");
    bench.rendered(&["-o", "x.exr", "--checkpoint", "c"]);
    let mut checkpoint = Checkpoint::read(&bench.path("c")).unwrap();
    checkpoint.made_by.device = "\u{1b}[2Jlavapipe".to_owned();
    checkpoint.write(&bench.path("c")).unwrap();
    let resume: &[&str] = &["render", "scene.pbrt", "--iterations", "3", "--resume", "c", "-o", "x\u{1b}[2J.exr"];
    let cases: [(&[&str], &str); 7] = [
        (
            &["render", NAME, "--photons", "500", "-o", "x.exr"],
            "warning: \\u001b]0;owned\\u0007\\u009b2J\\u000d.pbrt:5",
        ),
        (&["info", NAME], "warning: \\u001b]0;owned"),
        (&["info", "wrong\u{1b}[2J.pbrt"], "goblet: wrong\\u001b[2J.pbrt"),
        (&["render", "no\u{1b}[2J.pbrt"], "\\u001b[2J"),
        (&["render", "scene.pbrt", "--device", "\u{1b}[2J"], "\\u001b[2J"),
        (&["ren\u{1b}[2J"], "unrecognized subcommand 'ren"),
        (resume, "c: made by goblet 0.1.0 on \\u001b[2Jlavapipe"),
    ];
    for (arguments, expected) in cases {
        let run = bench.run(arguments);
        let text = run.stdout + &run.stderr;
        assert!(text.contains(expected), "{arguments:?}: `{expected}` in {text}");
        assert!(!text.contains(|c: char| c.is_control() && c != '\n'), "{arguments:?}: {text:?}");
    }
}

/// A render that never ends by itself, with the default of a signal or without hearing it.
fn start(bench: &Bench, hangup: &str, more: &[&str]) -> Child {
    let script = match hangup {
        "heard" => "exec env --default-signal=HUP \"$0\" \"$@\"",
        _ => "trap '' HUP; exec \"$0\" \"$@\"",
    };
    let mut command = Command::new("sh");
    command.args(["-c", script, env!("CARGO_BIN_EXE_goblet"), "render", "scene.pbrt", "--quiet"]);
    command.args(["--iterations", "4000000000", "-o", "x.exr", "--checkpoint", "c"]).args(more);
    command.current_dir(bench.0.path()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command::isolate(&mut command);
    command.spawn().unwrap()
}

/// Whether a process handles a signal, from the system's mask.
fn listens(child: &Child, signal: u32) -> bool {
    let status = fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap_or_default();
    // The shell that starts it may handle some signals itself.
    if !status.starts_with("Name:\tgoblet\n") {
        return false;
    }
    let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:"));
    caught.is_some_and(|mask| u64::from_str_radix(mask.trim(), 16).unwrap() >> (signal - 1) & 1 == 1)
}

#[test]
fn a_hangup_ends_a_render_as_other_signals_do() {
    let bench = Bench::new();
    let child = start(&bench, "heard", &["--checkpoint-every", "1e-9"]);
    wait_until("there is a checkpoint", || bench.path("c").exists());
    send("-HUP", &child);
    let run = Run::of(child.wait_with_output().unwrap());
    assert_eq!((run.code, run.stderr.as_str()), (130, ""));
    let done = Checkpoint::read(&bench.path("c")).unwrap().estimate.iterations().to_string();
    bench.rendered(&["--quiet", "--iterations", &done, "-o", "expected.exr"]);
    assert!(bench.bytes("x.exr") == bench.bytes("expected.exr"), "{done} iterations");
}

/// As with `nohup goblet render`.
#[test]
fn a_hangup_that_is_ignored_stays_so() {
    let bench = Bench::new();
    let mut child = start(&bench, "ignored", &["--checkpoint-every", "1e-9"]);
    wait_until("there is a checkpoint", || bench.path("c").exists());
    send("-HUP", &child);
    fs::remove_file(bench.path("c")).unwrap();
    wait_until("there is a later checkpoint", || bench.path("c").exists());
    assert!(child.try_wait().unwrap().is_none(), "it has ended");
    send("-TERM", &child);
    assert_eq!(Run::of(child.wait_with_output().unwrap()).code, 130);
    assert!(bench.path("x.exr").exists());
}

#[test]
fn a_signal_while_the_scene_is_loaded_ends_at_once() {
    let bench = Bench::new();
    // A million shapes take seconds to load on any machine. A load that is not ended by the signal
    // comes to the error after them: exit code 2.
    bench.write("scene.pbrt", SCENE.to_owned() + &"Shape \"sphere\"\n".repeat(1_000_000) + "Shape \"cube\"");
    bench.write("x.exr", "older");
    for (signal, number) in [("-TERM", 15), ("-INT", 2), ("-HUP", 1)] {
        let child = start(&bench, "heard", &[]);
        wait_until("it listens", || listens(&child, number));
        send(signal, &child);
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.signal(), None, "{signal}");
        let run = Run::of(output);
        assert_eq!(run.code, 130, "{signal}: {run:?}");
        assert!(run.stderr.contains("stopped by a signal before the first iteration"), "{signal}: {run:?}");
        assert_eq!(bench.bytes("x.exr"), b"older");
        assert_eq!(fs::read_dir(bench.0.path()).unwrap().count(), 2, "{signal}: nothing else is left");
    }
}
