//! Checks that `docs/options.md` agrees with the table of options. To write the page again:
//! `GOBLET_WRITE_DOCS=1 cargo test --lib options_page`.

use std::fmt::Write;
use std::path::Path;

use clap::{Arg, CommandFactory};

use crate::cli::Cli;
use crate::render::options::table::{Kind, OPTIONS, RenderOption};

const HEADING: &str = "\
# Options of `goblet render` and `goblet view`

This file is written by `GOBLET_WRITE_DOCS=1 cargo test --lib options_page`, from the definitions
that the command line itself uses.

`goblet measure --vary` can vary the options with an asterisk. `--resume` and `goblet merge` need the same
values of all options that change the image. A whole number can have an exponent, as in `5e8`.
[glossary.md](glossary.md) explains the terms, [settings.md](settings.md) which values to choose.
";

const OTHERS: &str = "
## Files, checkpoints and the device

None of these options changes the image of an iteration. `--shard` selects the iterations that are rendered.

| option | what it does | default |
| --- | --- | --- |
";

/// Returns the text for a cell of a table: one line, with escaped bars.
fn cell(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ").replace('|', "\\|")
}

fn values(option: &RenderOption) -> String {
    match &option.kind {
        Kind::Named { names, .. } => {
            let line = |(name, line): &(&str, &str)| match line.trim() {
                "" => format!("`{name}`"),
                line => format!("`{name}`: {line}"),
            };
            names.iter().map(line).collect::<Vec<_>>().join("<br>")
        }
        kind => kind.expected(),
    }
}

fn row(option: &RenderOption) -> String {
    let RenderOption { name, placeholder, help, more, unit, .. } = option;
    let knob = if option.is_knob { " *" } else { "" };
    let effect = if option.changes_image() { "yes" } else { "" };
    let default = option.default_text();
    let help = if more.is_empty() { (*help).to_owned() } else { format!("{help}. {more}") };
    let cells = [&help, &values(option), *unit, &default, effect].map(cell);
    format!("| `--{name} {}`{knob} | {} |\n", cell(placeholder), cells.join(" | "))
}

/// Returns the rows of the arguments of `goblet render` that are not in the table of options.
fn others() -> String {
    let mut all = Cli::command();
    all.build();
    let render = all.find_subcommand("render").expect("the command");
    let is_other = |arg: &&Arg| arg.get_long().is_some_and(|long| long != "help" && !is_in_table(long));
    render.get_arguments().filter(is_other).map(other_row).collect()
}

fn is_in_table(name: &str) -> bool {
    OPTIONS.iter().any(|option| option.name == name)
}

fn other_row(arg: &Arg) -> String {
    let value = match arg.get_value_names() {
        Some(names) if arg.get_action().takes_values() => format!(" {}", cell(&names[0])),
        _ => String::new(),
    };
    let help = arg.get_long_help().or(arg.get_help()).map(ToString::to_string).unwrap_or_default();
    // The first paragraph of the help has no full stop at its end.
    let help = help.split("\n\n").map(|part| part.trim_end_matches('.')).collect::<Vec<_>>().join(". ");
    let defaults = arg.get_default_values().iter().filter(|_| arg.get_action().takes_values());
    let default: Vec<_> = defaults.map(|value| value.to_string_lossy()).collect();
    let name = arg.get_long().unwrap_or_default();
    format!("| `--{name}{value}` | {} | {} |\n", cell(&help), default.join(" "))
}

fn page() -> String {
    let mut text = HEADING.to_owned();
    let mut group = "";
    for option in OPTIONS {
        if option.group != group {
            group = option.group;
            write!(
                text,
                "\n## {group}\n\n| option | what it does | values | unit | default | changes the image |\n\
                 | --- | --- | --- | --- | --- | --- |\n"
            )
            .unwrap();
        }
        text += &row(option);
    }
    text + OTHERS + &others()
}

#[test]
fn the_page_of_options_is_that_of_the_table() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/options.md");
    let page = page();
    if std::env::var_os("GOBLET_WRITE_DOCS").is_some() {
        std::fs::write(&path, &page).unwrap();
    }
    let found = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(found == page, "docs/options.md is out of date: run GOBLET_WRITE_DOCS=1 cargo test --lib options_page");
}
