//! Completions and the manual page: whole, well-formed, and of the command line as it is.

use std::process::Command as Process;

use clap::{Command, CommandFactory};
use goblet::cli::Cli;

use crate::support::command::{Bench, Run};

/// The commands, built, but for clap's own.
fn commands() -> Vec<Command> {
    let mut all = Cli::command();
    all.build();
    all.get_subcommands().filter(|command| command.get_name() != "help").cloned().collect()
}

/// As in `--radius`.
fn options(command: &Command) -> Vec<String> {
    command.get_arguments().filter_map(|arg| arg.get_long()).map(|long| format!("--{long}")).collect()
}

fn printed(arguments: &[&str]) -> String {
    let Run { code, stdout, stderr } = Bench::new().run(arguments);
    assert_eq!((code, stderr.as_str()), (0, ""), "{arguments:?}");
    stdout
}

#[test]
fn completions_know_every_command_and_option() {
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let script = printed(&["completions", shell]);
        for command in commands() {
            assert!(script.contains(command.get_name()), "{shell}: {}", command.get_name());
            for option in options(&command) {
                // Fish has them without dashes.
                assert!(script.contains(option.trim_start_matches('-')), "{shell}: {option}");
            }
        }
    }
    Bench::new().run(&["completions", "csh"]).assert_refused("csh", 2, &["csh", "bash"]);
}

/// What bash itself completes with the script.
#[cfg(unix)]
#[test]
fn bash_completes() {
    let bench = Bench::new();
    bench.write("goblet.bash", printed(&["completions", "bash"]));
    let script = "source goblet.bash; COMP_WORDS=(goblet render --check); COMP_CWORD=2; _goblet goblet --check render; \
                  echo \"${COMPREPLY[@]}\"";
    let bash = Process::new("bash").args(["-euc", script]).current_dir(bench.0.path()).output().unwrap();
    let run = Run::of(bash);
    assert_eq!((run.code, run.stdout.trim()), (0, "--checkpoint --checkpoint-every"), "{run:?}");
}

/// The text of a page, as a reader sees it.
fn text(roff: &str) -> String {
    ["\\fB", "\\fI", "\\fR", "\\-", "\\"]
        .iter()
        .fold(roff.to_owned(), |text, mark| text.replace(mark, if *mark == "\\-" { "-" } else { "" }))
}

/// Every line is text or a request that `man` knows.
fn assert_is_roff(page: &str) {
    let is_request = |line: &str| {
        let name = line.split(' ').next().unwrap_or_default();
        [".ie", ".el", ".TH", ".SH", ".SS", ".TP", ".RS", ".RE", ".PP", ".br", ".sp", ".IP", ".nf", ".fi"]
            .contains(&name)
    };
    for line in page.lines().filter(|line| line.starts_with(['.', '\''])) {
        assert!(is_request(line), "{line}");
    }
    assert_eq!(page.lines().filter(|line| line.starts_with(".TH")).count(), 1);
    assert_eq!(page.matches("\n.RS").count(), page.matches("\n.RE").count());
}

#[test]
fn the_manual_names_every_command_and_option() {
    let page = printed(&["man"]);
    assert_is_roff(&page);
    assert!(page.contains("\n.SH NAME\n") && page.contains("\n.SH SYNOPSIS\n"), "{page}");
    let sections: Vec<&str> = page.split("\n.SH ").collect();
    for command in commands() {
        let title = format!("\"GOBLET {}\"\n", command.get_name().to_uppercase());
        let section = sections.iter().find(|section| section.starts_with(&title));
        let section = text(section.unwrap_or_else(|| panic!("no section {title}")));
        let own = printed(&["man", command.get_name()]);
        assert_is_roff(&own);
        let own = text(&own);
        assert!(own.contains(&format!("goblet-{}", command.get_name())), "{own}");
        for option in options(&command) {
            assert!(section.contains(&option) && own.contains(&option), "{}: {option}", command.get_name());
        }
        // What the help says, the page says.
        let about = command.get_about().unwrap().to_string();
        let words = about.split_whitespace().next().unwrap();
        assert!(section.contains(words) && own.contains(words), "{}: {words}", command.get_name());
    }
    Bench::new().run(&["man", "rendre"]).assert_refused("rendre", 2, &["\"rendre\"", "render", "advise"]);
}
