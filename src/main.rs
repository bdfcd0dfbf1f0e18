//! The `goblet` command.
#![forbid(unsafe_code)]
#![deny(clippy::print_stdout, clippy::print_stderr)]

use std::process::ExitCode;

use clap::Parser;
use goblet::cli::render::{End, STOPPED};
use goblet::cli::{self, Cli, Command, terminal};

fn main() -> ExitCode {
    let code = |success| if success { ExitCode::SUCCESS } else { ExitCode::from(1) };
    let command = match Cli::try_parse() {
        Ok(cli) => cli.command,
        Err(error) => return ExitCode::from(terminal::print_of_clap(&error)),
    };
    let outcome = match command {
        Command::Render(args) => cli::render::run(&args).map(|end| match end {
            End::Done => ExitCode::SUCCESS,
            End::Stopped => ExitCode::from(STOPPED),
        }),
        #[cfg(feature = "view")]
        Command::View(args) => goblet::viewer::command::run(&args).map(|()| ExitCode::SUCCESS),
        Command::Merge(args) => cli::merge::run(&args).map(|()| ExitCode::SUCCESS),
        Command::Compare(args) => cli::compare::run(&args).map(code),
        #[cfg(feature = "study")]
        Command::Measure(args) => cli::measure::run(&args).map(|()| ExitCode::SUCCESS),
        #[cfg(feature = "study")]
        Command::Advise(args) => cli::advise::run(&args).map(|()| ExitCode::SUCCESS),
        Command::Tessellate(args) => cli::tessellate::run(&args).map(|()| ExitCode::SUCCESS),
        Command::Info(args) => cli::info::run(&args).map(|()| ExitCode::SUCCESS),
        Command::Devices(args) => cli::devices::run(args).map(|()| ExitCode::SUCCESS),
        Command::Completions(args) => cli::manual::completions(&args).map(|()| ExitCode::SUCCESS),
        Command::Man(args) => cli::manual::man(&args).map(|()| ExitCode::SUCCESS),
    };
    outcome.unwrap_or_else(|failure| {
        terminal::fail(&failure);
        ExitCode::from(failure.exit_code())
    })
}
