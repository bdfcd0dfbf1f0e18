//! docs/support.md says what the parser says. To write it anew:
//! `GOBLET_WRITE_DOCS=1 cargo test --test support_table`.

use std::fmt::Write;
use std::path::Path;

use goblet::scene::{FAMILIES, ParamSpec, Support, TypeSpec};

const HEADING: &str = "\
# What is read of pbrt-v4

Every directive that has types, its types, and their parameters. This file is written by
`GOBLET_WRITE_DOCS=1 cargo test --test support_table`, from the tables that the parser
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

fn table() -> String {
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

#[test]
fn the_table_is_that_of_the_parser() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/support.md");
    let table = table();
    if std::env::var_os("GOBLET_WRITE_DOCS").is_some() {
        std::fs::write(&path, &table).unwrap();
    }
    let found = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(found == table, "docs/support.md is out of date: run GOBLET_WRITE_DOCS=1 cargo test --test support_table");
}
