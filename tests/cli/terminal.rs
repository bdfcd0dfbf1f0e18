//! What people see on a terminal: commands run on a pseudo-terminal of a given width.

use std::fs::File;
use std::io::{Read, Write};
use std::os::fd::OwnedFd;
use std::process::{Child, Command};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};

use rustix::fs::{Mode, OFlags};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{Winsize, tcsetwinsize};

use crate::support::command::{self, Bench, goblet, wait_until};

/// The character that a terminal sends for Ctrl-C.
const CTRL_C: &[u8] = b"\x03";

/// A command on a terminal of its own.
struct Terminal {
    child: Ended,
    keys: File,
    shown: Arc<Mutex<Vec<u8>>>,
    reader: JoinHandle<()>,
}

/// A process that does not outlive the test.
struct Ended(Child);

impl Drop for Ended {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.0.kill();
    }
}

/// All that a command has shown.
#[derive(Debug)]
struct Shown {
    code: Option<i32>,
    /// What was drawn on the last line and drawn over, in order.
    drawn: Vec<String>,
    /// The lines that stay.
    lines: Vec<String>,
}

impl Terminal {
    /// Runs a command of a shell in a folder, on a terminal with so many columns.
    fn new(bench: &Bench, columns: u16, script: &str) -> Self {
        let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).expect("a pseudo-terminal");
        grantpt(&master).and_then(|()| unlockpt(&master)).expect("a terminal that may be opened");
        let name = ptsname(&master, Vec::new()).expect("its name");
        let size = Winsize { ws_row: 24, ws_col: columns, ws_xpixel: 0, ws_ypixel: 0 };
        tcsetwinsize(&master, size).expect("its size");
        let open = || -> OwnedFd {
            rustix::fs::open(&name, OFlags::RDWR | OFlags::NOCTTY, Mode::empty()).expect("the terminal")
        };
        // The terminal is the one that the session is controlled by, so that Ctrl-C is a signal.
        let mut command = Command::new("setsid");
        command.args(["--ctty", "sh", "-c", &format!("exec {script}")]).current_dir(bench.0.path());
        command.stdin(open()).stdout(open()).stderr(open());
        command::isolate(&mut command);
        let child = command.spawn().expect("setsid");
        let (mut output, keys) = (File::from(master.try_clone().expect("a copy")), File::from(master));
        let shown = Arc::new(Mutex::new(Vec::new()));
        let shared = Arc::clone(&shown);
        let reader = thread::spawn(move || {
            let mut buffer = [0; 4096];
            // Once nobody has the terminal open, reading fails.
            while let Ok(count @ 1..) = output.read(&mut buffer) {
                shared.lock().unwrap().extend(&buffer[..count]);
            }
        });
        Self { child: Ended(child), keys, shown, reader }
    }

    /// Runs goblet.
    fn goblet(bench: &Bench, columns: u16, arguments: &str) -> Self {
        Self::new(bench, columns, &format!("'{}' {arguments}", goblet().display()))
    }

    fn wait_for(&self, words: &str) {
        let has = || String::from_utf8_lossy(&self.shown.lock().unwrap()).contains(words);
        wait_until(&format!("`{words}` is shown"), has);
    }

    fn press(&mut self, keys: &[u8]) {
        self.keys.write_all(keys).expect("a terminal that is open");
    }

    /// Waits for the end. Only the carriage return moves the cursor, and nothing that is drawn over reaches the last
    /// column, after which a terminal may begin another line.
    fn end(mut self, columns: usize) -> Shown {
        let code = self.child.0.wait().expect("an end").code();
        drop(self.keys);
        self.reader.join().expect("all output");
        let text = String::from_utf8(std::mem::take(&mut self.shown.lock().unwrap())).expect("UTF-8");
        // The terminal shows the key itself so.
        let text = text.replace("^C", "");
        assert!(text.chars().all(|c| !c.is_control() || matches!(c, '\r' | '\n')), "{text:?}");
        let mut shown = Shown { code, drawn: Vec::new(), lines: Vec::new() };
        for line in text.split_terminator("\r\n") {
            let mut parts: Vec<&str> = line.split('\r').collect();
            let last = parts.pop().unwrap_or_default();
            for part in parts {
                assert!(part.chars().count() < columns, "{columns} columns: {part:?}");
                shown.drawn.extend((!part.trim().is_empty()).then(|| part.trim_end().to_owned()));
            }
            shown.lines.push(last.to_owned());
        }
        shown
    }
}

impl Shown {
    #[track_caller]
    fn assert_drawn(&self, words: &str) {
        assert!(self.drawn.iter().any(|line| line.contains(words)), "`{words}` is not in {self:#?}");
    }
}

#[test]
fn a_render_fills_one_line_by_time_and_ends_with_its_summary() {
    for columns in [80, 60, 40] {
        let bench = Bench::new();
        let files = "-o x.exr -o x.png --stats s.json --checkpoint c";
        let arguments = format!("render scene.pbrt --time 0.3 --photons auto {files}");
        let shown = Terminal::goblet(&bench, columns, &arguments).end(columns.into());
        assert_eq!(shown.code, Some(0), "{shown:#?}");
        for words in ["reading the scene, ", "opening the device, ", "building the hierarchy, ", "copying the scene"] {
            shown.assert_drawn(words);
        }
        for words in ["compiling kernels 0/9, ", "compiling kernels 9/9, ", "trial of photons and eye paths, "] {
            shown.assert_drawn(words);
        }
        shown.assert_drawn("] 0.0 of 0.3 s");
        shown.assert_drawn("] 0.3 of 0.3 s");
        shown.assert_drawn("writing the files, ");
        assert!(shown.drawn.iter().any(|line| line.starts_with("[>") && line.contains(" of 0.3 s")), "{shown:#?}");
        let is_full = |line: &String| line.starts_with("[=") && line.contains("=] 0.3 of 0.3 s");
        assert!(shown.drawn.iter().any(is_full), "{shown:#?}");

        let [compiled, trial, summary, rest @ ..] = &shown.lines[..] else { panic!("{shown:#?}") };
        assert!(compiled.starts_with("compiled the kernels in ") && trial.starts_with("trial of "), "{shown:#?}");
        assert!(summary.contains(" iteration") && summary.contains(" in ") && summary.contains("photon"), "{shown:#?}");
        assert_eq!(rest, ["wrote x.exr", "wrote x.png", "wrote s.json", "wrote c"], "{shown:#?}");
    }
}

/// What the command says is a command that resumes.
#[test]
fn after_ctrl_c_the_command_that_resumes_is_named() {
    let bench = Bench::new();
    let stop = |mut terminal: Terminal| {
        terminal.press(CTRL_C);
        let shown = terminal.end(80);
        assert_eq!(shown.code, Some(130), "{shown:#?}");
        let last = shown.lines.last().expect("a line").clone();
        let (stopped, command) = last.split_once("; resume with: ").unwrap_or_else(|| panic!("{shown:#?}"));
        let count = stopped.strip_prefix("stopped after ").and_then(|rest| rest.split(' ').next());
        (count.and_then(|count| count.parse::<u32>().ok()).expect("a number"), command.to_owned(), shown)
    };
    let arguments = "render scene.pbrt --iterations 4000000000 -o 'x y.exr' --checkpoint 'c d' --checkpoint-every 1e-9";
    let terminal = Terminal::goblet(&bench, 80, arguments);
    wait_until("there is a checkpoint", || bench.path("c d").exists());
    let (first, command, _) = stop(terminal);
    assert!(command.ends_with(" --checkpoint-every 1e-9 --resume 'c d'"), "{command}");
    let terminal = Terminal::new(&bench, 80, &command);
    terminal.wait_for(&format!("iteration {first} of 4000000000"));
    let (second, again, shown) = stop(terminal);
    assert!(second >= first && again == command, "{first} {second} {again}");
    let summary = format!("{second} iterations, of them {} in ", second - first);
    assert!(shown.lines.iter().any(|line| line.starts_with(&summary)), "{summary}: {shown:#?}");
    bench.rendered(&["--quiet", "--iterations", &second.to_string(), "-o", "whole.exr"]);
    assert!(bench.bytes("x y.exr") == bench.bytes("whole.exr"), "{second} iterations");

    // Without a checkpoint there is nothing to resume.
    let mut terminal = Terminal::goblet(&bench, 80, "render scene.pbrt --iterations 4000000000 -o x.exr");
    terminal.wait_for(" left");
    terminal.press(CTRL_C);
    let shown = terminal.end(80);
    let last = shown.lines.last().expect("a line");
    assert!(
        last.starts_with("stopped after ") && last.ends_with("with --checkpoint FILE, another command can resume them")
    );
}

#[test]
fn advice_shows_where_it_is_in_its_time() {
    let bench = Bench::new();
    let shown = Terminal::goblet(&bench, 80, "advise scene.pbrt --time 1 --probe 0.2").end(80);
    assert_eq!(shown.code, Some(0), "{shown:#?}");
    let stages = [
        "compiling kernels 9/9, ",
        "trial of photons",
        "probe 1/5, ",
        "probe 2/5, ",
        "probe 5/5, ",
        " of 0.2 s in all",
    ];
    stages.iter().for_each(|words| shown.assert_drawn(words));
    // Kernels are compiled once for all renders of the probe.
    let after = shown.drawn.iter().skip_while(|line| !line.contains("compiling kernels 9/9"));
    let again = after.filter(|line| line.contains("compiling kernels") && !line.contains("9/9")).count();
    assert_eq!(again, 0, "{shown:#?}");
    assert!(shown.lines[0].starts_with("probe  ") && shown.lines.last().expect("a line").starts_with("goblet render "));
}

#[test]
fn a_measurement_says_how_long_it_takes_and_where_it_is() {
    let bench = Bench::new();
    let arguments = "measure scene.pbrt --reference auto --vary alpha=0.5,1 --budget 0.1 --repeat 2 -o out";
    let shown = Terminal::goblet(&bench, 80, arguments).end(80);
    assert_eq!(shown.code, Some(0), "{shown:#?}");
    let plan = "measuring 2 settings in 2 turns of 0.1 s each, after a reference: about 1.4 s of rendering";
    assert!(shown.lines[0].starts_with(plan), "{shown:#?}");
    for words in ["] turn 1 of 2", "] turn 2 of 2, about ", " left, alpha=0.5", " left, alpha=1"] {
        shown.assert_drawn(words);
    }
}

/// As in the log of a CI job.
#[test]
fn what_is_no_terminal_gets_plain_lines() {
    let bench = Bench::new();
    for arguments in [
        &["render", "scene.pbrt", "--time", "0.1", "-o", "x.exr"][..],
        &["advise", "scene.pbrt", "--time", "1", "--probe", "0.1"],
        &["measure", "scene.pbrt", "--reference", "auto", "--budget", "0.05", "--repeat", "1", "-o", "out"],
    ] {
        let run = bench.run(arguments);
        assert_eq!(run.code, 0, "{run:?}");
        assert!(run.stderr.chars().all(|c| !c.is_control() || c == '\n'), "{run:?}");
        assert!(!run.stderr.contains("compiling kernels 0/"), "{run:?}");
    }
}
