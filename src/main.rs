//! The `goblet` command.
#![forbid(unsafe_code)]

use std::process::ExitCode;

use clap::Parser;
use goblet::cli::{self, Cli, Command};

fn main() -> ExitCode {
    let outcome = match Cli::parse().command {
        Command::Render(args) => cli::render::run(&args).map(|()| true),
        Command::Compare(args) => cli::compare::run(&args).map_err(cli::Failure::from),
        Command::Tessellate(args) => cli::tessellate::run(&args).map(|()| true),
        Command::Devices(_) => cli::devices::run().map(|()| true),
    };
    match outcome {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(1),
        Err(failure) => {
            eprintln!("goblet: {failure}");
            ExitCode::from(failure.exit_code())
        }
    }
}
