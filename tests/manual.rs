//! Completions and manual pages, of every option that there is.

#[path = "support/command.rs"]
mod command;

use std::io::Write;
use std::process::{Command, Stdio};

use clap::CommandFactory;
use command::Bench;
use goblet::cli::Cli;

/// What a command prints, which it must.
fn printed(arguments: &[&str]) -> String {
    let run = Bench::new().run(arguments);
    assert!(run.code == 0 && run.stderr.is_empty(), "{run:?}");
    run.stdout
}

/// Subcommands, each with its long options.
fn options() -> Vec<(String, Vec<String>)> {
    let mut command = Cli::command();
    command.build();
    let of = |command: &clap::Command| {
        command.get_arguments().filter_map(|argument| argument.get_long().map(str::to_owned)).collect()
    };
    let subcommands = command.get_subcommands().filter(|subcommand| subcommand.get_name() != "help");
    subcommands.map(|subcommand| (subcommand.get_name().to_owned(), of(subcommand))).collect()
}

#[test]
fn every_shell_has_completions_of_every_option() {
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = printed(&["completions", shell]);
        for (subcommand, options) in options() {
            assert!(script.contains(&subcommand), "{shell}: {subcommand}");
            for option in options {
                assert!(script.contains(&option), "{shell}: {subcommand} --{option}");
            }
        }
    }
    let run = Bench::new().run(&["completions", "tcsh"]);
    assert_eq!(run.code, 2, "{run:?}");
}

#[test]
fn bash_reads_its_completions() {
    let mut bash =
        Command::new("bash").args(["--norc", "-s"]).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    let question =
        "\nCOMP_WORDS=(goblet render --targ); COMP_CWORD=2; _goblet goblet --targ render; echo ${COMPREPLY[@]}\n";
    let script = printed(&["completions", "bash"]) + question;
    bash.stdin.take().unwrap().write_all(script.as_bytes()).unwrap();
    let output = bash.wait_with_output().unwrap();
    assert_eq!(String::from_utf8_lossy(&output.stdout), "--target-error\n");
}

/// Roff has a backslash before each hyphen.
#[test]
fn manual_pages_name_every_subcommand_and_option() {
    let page = printed(&["man"]);
    for (subcommand, options) in options() {
        let name = |text: &str| text.replace('-', "\\-");
        assert!(page.contains(&name(&format!("goblet-{subcommand}"))), "{subcommand}: {page}");
        let page = printed(&["man", &subcommand]);
        assert!(page.contains(".TH") && page.contains(&name(&format!("goblet {subcommand}"))), "{page}");
        for option in options {
            assert!(page.contains(&name(&format!("--{option}"))), "{subcommand} --{option}: {page}");
        }
    }
    let run = Bench::new().run(&["man", "nothing"]);
    assert!(run.code == 2 && run.stderr.contains("render"), "{run:?}");
}
