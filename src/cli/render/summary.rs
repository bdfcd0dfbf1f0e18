//! What is said at the end of a render: its summary, and how to go on after a stop.

use std::ffi::{OsStr, OsString};
use std::path::Path;
use std::time::Duration;

use super::RenderArgs;
use super::progress::Begin;
use crate::cli::stats::percent;
use crate::cli::status::duration;
use crate::render::guide::guidance::Finding;
use crate::render::renderer::Renderer;
use crate::render::unsampled::Noise;

/// Returns the summary of a render in one line: iterations, time, error, and the share of photons that reach what is seen.
pub fn summary(renderer: &Renderer, begin: &Begin, time: Duration, noise: &Noise) -> String {
    let (all, time) = (renderer.iterations(), duration(time.as_secs_f64()));
    let mut parts = vec![match begin.iterations {
        0 => format!("{} in {time}", iterations(all)),
        before => format!("{}, of them {} in {time}", iterations(all), all - before),
    }];
    parts.extend(noise.relative_error().map(|error| format!("error {:.2} %", 100.0 * error)));
    parts.extend(seen(renderer));
    parts.join(", ")
}

fn iterations(count: u32) -> String {
    if count == 1 { "1 iteration".to_owned() } else { format!("{count} iterations") }
}

/// Returns the share of photons that bring light to what is seen, as the pilot has found it. Without a pilot, the number
/// of records on surfaces, seen or not; `None` if there are no photons.
fn seen(renderer: &Renderer) -> Option<String> {
    let tally = renderer.tally();
    if tally.emitted == 0 {
        return None;
    }
    match renderer.guide().map(|guide| (guide.finding, guide.reached)) {
        Some((Finding::Guided | Finding::NotWorthwhile | Finding::NothingFound, [_, share])) => {
            Some(format!("{} of photons reach what is seen", percent(share)))
        }
        Some((Finding::PhotonsDoNotMatter, _)) => None,
        _ => Some(format!("{:.2} records per photon", tally.recorded as f64 / tally.emitted as f64)),
    }
}

/// Returns what to say after a stop. `saved` is the checkpoint that has all iterations, if there is one.
pub fn stopped(args: &RenderArgs, count: u32, saved: Option<&Path>) -> String {
    let stopped = format!("stopped after {}", iterations(count));
    match saved {
        Some(path) => format!("{stopped}; resume with: {}", resuming(std::env::args_os(), path.as_os_str())),
        None if args.checkpoint.is_some() => stopped,
        None => format!("{stopped}; with --checkpoint FILE, another command can resume them"),
    }
}

/// Returns the command that goes on from a checkpoint: the words of the one that was stopped, with `--resume`.
fn resuming(words: impl IntoIterator<Item = OsString>, checkpoint: &OsStr) -> String {
    const RESUME: &str = "--resume";
    let mut command = Vec::new();
    let mut words = words.into_iter();
    let mut rest = Vec::new();
    while let Some(word) = words.next() {
        if word == "--" {
            // Only names of files follow.
            rest.push(word);
            rest.extend(words.by_ref());
        } else if word == RESUME {
            words.next();
        } else if !word.to_string_lossy().starts_with("--resume=") {
            command.push(word);
        }
    }
    command.extend([RESUME.into(), checkpoint.to_owned()]);
    command.extend(rest);
    command.iter().map(|word| quoted(&word.to_string_lossy())).collect::<Vec<_>>().join(" ")
}

/// Writes a word so that a shell reads it as it is.
fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "_-+=:,./@%".contains(c) || (cfg!(windows) && c == '\\');
    if !word.is_empty() && word.chars().all(is_plain) {
        word.to_owned()
    } else if cfg!(windows) {
        format!("\"{word}\"")
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn command(words: &[&str], checkpoint: &str) -> String {
        resuming(words.iter().map(OsString::from), checkpoint.as_ref())
    }

    #[test]
    fn a_command_goes_on_from_the_last_checkpoint_and_no_other() {
        for (words, expected) in [
            (
                &["goblet", "render", "a.pbrt", "--checkpoint", "c"][..],
                "goblet render a.pbrt --checkpoint c --resume c",
            ),
            (&["goblet", "render", "--resume", "old", "a.pbrt"], "goblet render a.pbrt --resume c"),
            (&["goblet", "render", "--resume=old", "a.pbrt"], "goblet render a.pbrt --resume c"),
            (&["goblet", "render", "--alpha", "1", "--", "--resume"], "goblet render --alpha 1 --resume c -- --resume"),
        ] {
            assert_eq!(command(words, "c"), expected);
        }
    }

    #[cfg(unix)]
    #[test]
    fn words_are_quoted_for_a_shell() {
        assert_eq!(
            command(&["./goblet", "render", "my scene.pbrt", "", "it's", "$HOME;*"], "Kelch ü"),
            "./goblet render 'my scene.pbrt' '' 'it'\\''s' '$HOME;*' --resume 'Kelch ü'"
        );
    }
}
