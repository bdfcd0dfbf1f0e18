//! The subcommands `goblet completions` and `goblet man`. They generate their texts from the definition of
//! the command line.

use clap::{Args, CommandFactory};
use clap_complete::Shell;
use clap_mangen::Man;

use super::{Cli, Failure, terminal};

/// Arguments of `goblet completions`.
#[derive(Args, Clone, Copy, Debug)]
pub struct CompletionsArgs {
    /// The shell
    #[arg(value_name = "SHELL", value_enum)]
    pub shell: Shell,
}

/// Arguments of `goblet man`.
#[derive(Args, Clone, Debug)]
pub struct ManArgs {
    /// The command to describe [default: all commands, on one page]
    #[arg(value_name = "COMMAND")]
    pub command: Option<String>,
}

/// Prints the completion script for a shell.
///
/// # Errors
/// Standard output cannot be written to.
pub fn completions(args: &CompletionsArgs) -> Result<(), Failure> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "goblet", &mut script);
    terminal::print(&String::from_utf8_lossy(&script))
}

/// Prints the manual page of a command, or of all commands, in roff.
///
/// # Errors
/// There is no such command, or standard output cannot be written to.
pub fn man(args: &ManArgs) -> Result<(), Failure> {
    let mut all = Cli::command();
    all.build();
    let page = match &args.command {
        Some(name) => {
            let one = all.get_subcommands().find(|command| command.get_name() == name);
            let one = one.ok_or_else(|| Failure::NoCommand { name: name.clone(), known: names(&all).join(", ") })?;
            page(&Man::new(renamed(one)))
        }
        None => whole(&all),
    };
    terminal::print(&String::from_utf8_lossy(&page.map_err(Failure::Print)?))
}

/// Returns the names of the commands, in the order of the help.
fn names(all: &clap::Command) -> Vec<&str> {
    all.get_subcommands().map(clap::Command::get_name).collect()
}

/// Returns the command with the name of its manual page.
fn renamed(command: &clap::Command) -> clap::Command {
    command.clone().display_name(format!("goblet-{}", command.get_name()))
}

fn page(man: &Man) -> std::io::Result<Vec<u8>> {
    let mut roff = Vec::new();
    man.render(&mut roff)?;
    Ok(roff)
}

/// Returns a page for the whole program: its own page, followed by a section for each command.
fn whole(all: &clap::Command) -> std::io::Result<Vec<u8>> {
    let mut roff = page(&Man::new(all.clone()))?;
    for command in all.get_subcommands().filter(|command| command.get_name() != "help") {
        roff.extend(format!(".SH \"GOBLET {}\"\n", command.get_name().to_uppercase()).bytes());
        let man = Man::new(command.clone());
        let mut parts = Vec::new();
        man.render_synopsis_section(&mut parts)?;
        man.render_description_section(&mut parts)?;
        man.render_options_section(&mut parts)?;
        // The sections of a command become subsections of its section.
        let parts = String::from_utf8_lossy(&parts);
        let lines = parts.lines().map(|line| line.strip_prefix(".SH ").map_or_else(|| line.to_owned(), subsection));
        roff.extend(lines.flat_map(|line| line.into_bytes().into_iter().chain([b'\n'])));
    }
    Ok(roff)
}

fn subsection(title: &str) -> String {
    format!(".SS {title}")
}
