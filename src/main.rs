//! The `goblet` command.
#![forbid(unsafe_code)]

use std::process::ExitCode;

use clap::Parser;
use goblet::cli::render::{End, STOPPED};
use goblet::cli::{self, Cli, Command};

fn main() -> ExitCode {
    let code = |success| if success { ExitCode::SUCCESS } else { ExitCode::from(1) };
    let outcome = match Cli::parse().command {
        Command::Render(args) => cli::render::run(&args).map(|end| match end {
            End::Done => ExitCode::SUCCESS,
            End::Stopped => ExitCode::from(STOPPED),
        }),
        #[cfg(feature = "view")]
        Command::View(args) => cli::view::run(&args).map(|()| ExitCode::SUCCESS),
        Command::Merge(args) => cli::merge::run(&args).map(|()| ExitCode::SUCCESS),
        Command::Compare(args) => cli::compare::run(&args).map(code).map_err(cli::Failure::from),
        Command::Measure(args) => cli::measure::run(&args).map(|()| ExitCode::SUCCESS),
        Command::Advise(args) => cli::advise::run(&args).map(|()| ExitCode::SUCCESS),
        Command::Tessellate(args) => cli::tessellate::run(&args).map(|()| ExitCode::SUCCESS),
        Command::Info(args) => cli::info::run(&args).map(|()| ExitCode::SUCCESS),
        Command::Devices(_) => cli::devices::run().map(|()| ExitCode::SUCCESS),
    };
    outcome.unwrap_or_else(|failure| {
        eprintln!("goblet: {failure}");
        ExitCode::from(failure.exit_code())
    })
}
