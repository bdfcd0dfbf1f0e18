//! `goblet completions` and `goblet man`: what the command line accepts, for shells and for
//! readers of manuals.

use std::io;

use clap::{Command, CommandFactory};
use clap_mangen::Man;

use super::{Cli, CompletionsArgs, Failure, ManArgs, terminal};

/// Prints the completions of a shell.
///
/// # Errors
/// They cannot be printed.
pub fn completions(args: CompletionsArgs) -> Result<(), Failure> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "goblet", &mut script);
    terminal::print(&String::from_utf8_lossy(&script))
}

/// Prints the manual page of the command, or of a subcommand, in roff.
///
/// # Errors
/// It cannot be printed.
pub fn page(args: &ManArgs) -> Result<(), Failure> {
    let mut roff = Vec::new();
    render(command(args.subcommand.as_deref()), &mut roff).map_err(Failure::Print)?;
    terminal::print(&String::from_utf8_lossy(&roff))
}

/// The command, or a subcommand with its whole name.
fn command(subcommand: Option<&str>) -> Command {
    let mut command = Cli::command();
    // This gives subcommands their whole names.
    command.build();
    let found = subcommand.and_then(|name| command.find_subcommand(name).cloned());
    found.map_or(command, |found| found.version(env!("CARGO_PKG_VERSION")))
}

fn render(command: Command, roff: &mut Vec<u8>) -> io::Result<()> {
    Man::new(command).manual("goblet manual").render(roff)
}
