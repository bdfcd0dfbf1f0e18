//! The output of commands to the terminal. Only this module writes to standard output and standard error.
//!
//! The result of a command goes to standard output. If this fails, the command fails. A closed pipe is not a
//! failure, because its reader needs no more, as in `goblet info scene.pbrt | head -1`. Messages go to
//! standard error. If this fails, nothing changes: a render continues without its log.
//!
//! If standard error is a terminal, its last line may be a status, which is drawn again and again. Messages are printed
//! above it. It needs no control characters but the carriage return, and is never as long as the terminal is wide.
//!
//! Names of files, devices and scenes may contain any characters. Control characters are printed as in JSON,
//! so that they cannot move the cursor of a terminal or change its title.

use std::borrow::Cow;
use std::ffi::OsString;
use std::fmt::{Display, Write as _};
use std::io::{self, ErrorKind, IsTerminal, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use super::Failure;

/// The width of a terminal that does not tell its width, in columns.
const USUAL_WIDTH: usize = 80;

/// The status that is on the last line of the terminal; empty if there is none.
static STATUS: Mutex<String> = Mutex::new(String::new());
/// Whether a status may still be shown.
static MAY_SHOW: AtomicBool = AtomicBool::new(true);

/// Prints a message on standard error.
pub fn say(message: impl Display) {
    let status = STATUS.lock().unwrap_or_else(PoisonError::into_inner);
    let line = format!("{}{}\n{status}", erased(&status), printable(&message.to_string()));
    put(&line);
}

/// Prints the last message of the process: no status is shown after it.
pub fn say_at_last(message: impl Display) {
    MAY_SHOW.store(false, Ordering::Relaxed);
    show_status("");
    say(message);
}

/// Returns whether standard error is a terminal, on which a status can be shown.
pub fn has_status() -> bool {
    io::stderr().is_terminal()
}

/// Returns the number of columns of the terminal.
pub fn width() -> usize {
    let (_, columns) = console::Term::stderr().size_checked().unwrap_or_default();
    if columns == 0 { USUAL_WIDTH } else { columns.into() }
}

/// Shows a status of plain characters in place of the one before; none if it is empty. It must be shorter than the
/// [`width`].
pub fn show_status(line: &str) {
    let mut status = STATUS.lock().unwrap_or_else(PoisonError::into_inner);
    let line = if MAY_SHOW.load(Ordering::Relaxed) { line } else { "" };
    if *status == line {
        return;
    }
    let gone = status.chars().count().saturating_sub(line.chars().count());
    let mut text = format!("\r{line}{:gone$}", "");
    if line.is_empty() {
        text.push('\r');
    }
    put(&text);
    line.clone_into(&mut status);
}

/// Returns the characters that erase a status.
fn erased(status: &str) -> String {
    if status.is_empty() { String::new() } else { format!("\r{:width$}\r", "", width = status.chars().count()) }
}

fn put(text: &str) {
    // If standard error is closed, there is no place to report this.
    let _ = io::stderr().lock().write_all(text.as_bytes());
}

/// Prints a warning about the result.
pub fn warn(message: impl Display) {
    say(format_args!("warning: {message}"));
}

/// Prints the failure of a command or of one of its outputs.
pub fn fail(failure: &Failure) {
    say(format_args!("goblet: {failure}"));
}

/// Prints the whole result of a command.
///
/// # Errors
/// Standard output cannot be written to, for another reason than a closed pipe.
pub fn print(text: &str) -> Result<(), Failure> {
    show_status("");
    print_to(&mut io::stdout().lock(), text)
}

/// Prints a text of clap: help, version, or an error in the arguments. Returns the exit code.
pub fn print_of_clap(error: &clap::Error) -> u8 {
    if error.use_stderr() {
        let is_obeyed = |arg: &OsString| matches!(printable(&arg.to_string_lossy()), Cow::Owned(_));
        if std::env::args_os().any(|arg| is_obeyed(&arg)) {
            // The text has no colours, because their escape sequences could not be told from those of an
            // argument.
            say(error.render().to_string().trim_end());
        } else {
            let _ = error.print();
        }
        return 2;
    }
    match accepted(error.print()) {
        Ok(()) => 0,
        Err(failure) => {
            fail(&failure);
            failure.exit_code()
        }
    }
}

fn print_to(out: &mut dyn Write, text: &str) -> Result<(), Failure> {
    accepted(out.write_all(printable(text).as_bytes()).and_then(|()| out.flush()))
}

fn accepted(written: io::Result<()>) -> Result<(), Failure> {
    match written {
        Err(reason) if reason.kind() != ErrorKind::BrokenPipe => Err(Failure::Print(reason)),
        _ => Ok(()),
    }
}

/// Replaces the characters that a terminal interprets, except line ends and tabs. They are written as in
/// JSON: the escape character becomes `\u001b`.
fn printable(text: &str) -> Cow<'_, str> {
    let obeyed = |c: char| (c.is_control() && !matches!(c, '\n' | '\t')) || is_direction(c);
    if !text.contains(obeyed) {
        return text.into();
    }
    let mut safe = String::with_capacity(text.len());
    for c in text.chars() {
        if obeyed(c) {
            // Writing to a string cannot fail.
            let _ = write!(safe, "\\u{:04x}", u32::from(c));
        } else {
            safe.push(c);
        }
    }
    safe.into()
}

/// Returns whether a character changes the direction of the following text, so that a name could look like
/// another name.
fn is_direction(c: char) -> bool {
    matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A stream whose every write fails in a given way.
    struct Broken(ErrorKind);

    impl Write for Broken {
        fn write(&mut self, _: &[u8]) -> io::Result<usize> {
            Err(self.0.into())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn control_characters_are_printed_and_not_obeyed() {
        for (text, expected) in [
            ("plain: Kelch ü 杯\n\tok\n", "plain: Kelch ü 杯\n\tok\n"),
            ("\u{1b}]0;title\u{7}", "\\u001b]0;title\\u0007"),
            ("a\rb\u{8}c\0d\u{7f}e\u{9b}2Jf", "a\\u000db\\u0008c\\u0000d\\u007fe\\u009b2Jf"),
            ("\u{202e}gnp.x", "\\u202egnp.x"),
        ] {
            let mut out = Vec::new();
            print_to(&mut out, text).unwrap();
            assert_eq!(String::from_utf8(out).unwrap(), expected);
        }
    }

    #[test]
    fn json_stays_json() {
        let name = "\u{1b}[2J\u{9b}\u{7f}\r\n";
        let mut out = Vec::new();
        print_to(&mut out, &serde_json::to_string(name).unwrap()).unwrap();
        assert!(out.iter().all(|byte| (0x20..0x7f).contains(byte)), "{out:?}");
        assert_eq!(serde_json::from_slice::<String>(&out).unwrap(), name);
    }

    #[test]
    fn a_full_disk_fails_and_a_reader_that_is_gone_does_not() {
        print_to(&mut Broken(ErrorKind::BrokenPipe), "text").unwrap();
        let failure = print_to(&mut Broken(ErrorKind::StorageFull), "text").unwrap_err();
        assert_eq!(failure.exit_code(), 1);
        assert!(failure.to_string().starts_with("cannot write to standard output: "), "{failure}");
    }
}
