//! Prints docs/support.md, from the tables that the parser uses:
//! `cargo run --example support_table > docs/support.md`

use std::fmt::Write;

use goblet::scene::{FAMILIES, ParamSpec, Support, TypeSpec};

const HEADING: &str = "\
# What is read of pbrt-v4

Every directive that has types, its types, and their parameters. This page is written by
`cargo run --example support_table > docs/support.md`, from the tables that the parser
itself uses.

- full: does what pbrt does, or says in a warning what it does instead.
- ignored: accepted; it cannot change the image.
- later: an error for now.

`goblet info SCENE` lists all that a scene asks for and goblet does not have.
";

fn word(support: Support) -> &'static str {
    match support {
        Support::Full => "full",
        Support::Ignored => "ignored",
        Support::Later => "later",
    }
}

fn parameter(param: &ParamSpec) -> String {
    let kinds: Vec<&str> = param.kinds.iter().map(|kind| kind.word()).collect();
    format!("`{}` ({})", param.name, kinds.join(", "))
}

/// The parameters of a type that have this support.
fn parameters(spec: &TypeSpec, support: Support) -> String {
    let names: Vec<String> = spec.parameters.iter().filter(|param| param.support == support).map(parameter).collect();
    names.join(", ")
}

/// The text of docs/support.md.
pub fn table() -> String {
    let mut text = HEADING.to_owned();
    for family in FAMILIES {
        let [full, ignored, later] = [Support::Full, Support::Ignored, Support::Later].map(word);
        write!(
            text,
            "\n## {}\n\n| type | | {full} | {ignored} | {later} |\n| --- | --- | --- | --- | --- |\n",
            family.directive
        )
        .unwrap();
        for spec in family.types {
            let [full, ignored, later] =
                [Support::Full, Support::Ignored, Support::Later].map(|support| parameters(spec, support));
            writeln!(text, "| `{}` | {} | {full} | {ignored} | {later} |", spec.name, word(spec.support)).unwrap();
        }
    }
    text
}

fn main() {
    print!("{}", table());
}
