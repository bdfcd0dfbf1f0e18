//! The layers of `src/`, and circles between files of `src/` and `host/src/`.
//!
//! A file depends on a file whose items it names, in a `use` or in a path. Dependencies between
//! folders of `src/` go down by [`LAYERS`]. Dependencies between files form no circle, unless the
//! `mod.rs` of their folder lists the circle with a reason ([`circles`]).

mod circles;
mod modules;
mod optional;

use std::path::Path;

use circles::Listed;
use modules::{Arrow, Crate};

/// The folders of `src/`, the lowest first: each may use itself and those before it. `lib.rs` and
/// `main.rs` may use all.
const LAYERS: [&str; 10] =
    ["kernels", "base", "geometry", "image", "scene", "gpu_scene", "render", "study", "cli", "viewer"];

/// Reads a crate of this repository, by the folder of its `lib.rs`.
fn read(folder: &str) -> Crate {
    Crate::read(Path::new(env!("CARGO_MANIFEST_DIR")), folder)
}

/// The position of a file's folder in [`LAYERS`]; `None` for `lib.rs` and `main.rs`.
fn layer(file: &str) -> Option<usize> {
    let name = file.trim_start_matches("src/").split('/').next().unwrap_or_default();
    let name = name.trim_end_matches(".rs");
    if ["lib", "main"].contains(&name) {
        return None;
    }
    let layer = LAYERS.iter().position(|layer| *layer == name);
    Some(
        layer.unwrap_or_else(|| panic!("{file}: `{name}` is not in the table of layers of tests/architecture/main.rs")),
    )
}

/// A message for each arrow from a lower to a higher layer.
fn upward(arrows: &[Arrow]) -> Vec<String> {
    let rises = |arrow: &&Arrow| layer(&arrow.from).is_some_and(|from| layer(&arrow.to).is_none_or(|to| to > from));
    let message = |arrow: &Arrow| {
        let Arrow { from, line, path, to, .. } = arrow;
        let name = |file: &str| layer(file).map_or("the crate's root", |layer| LAYERS[layer]);
        format!("{from}:{line}: `{path}` is in {to}: {} is a lower layer than {}", name(from), name(to))
    };
    arrows.iter().filter(rises).map(message).collect()
}

fn assert_none(what: &str, messages: &[String]) {
    assert!(messages.is_empty(), "{what}:\n{}", messages.join("\n"));
}

#[test]
fn every_arrow_between_layers_goes_down() {
    let arrows = read("src").arrows();
    assert!(arrows.len() > 500, "only {} arrows are found", arrows.len());
    assert_none("arrows that go up", &upward(&arrows));
}

#[test]
fn files_form_no_circle_that_is_not_listed_with_a_reason() {
    let (mut unlisted, mut stale) = (Vec::new(), Vec::new());
    for folder in ["src", "host/src"] {
        let source = read(folder);
        // Nothing depends on unit tests, so they close no circle.
        let arrows: Vec<Arrow> = source.arrows().into_iter().filter(|arrow| !arrow.is_test).collect();
        let listed: Vec<Listed> = source.files().flat_map(|(file, text)| circles::listed(file, text)).collect();
        unlisted.extend(circles::unlisted(&arrows, &listed));
        stale.extend(circles::stale(&arrows, &listed));
    }
    assert_none("circles of files", &unlisted);
    assert_none("lists of circles that are none", &stale);
}

/// So the library compiles without features; tests/full.sh compiles it.
#[test]
fn optional_crates_are_named_by_the_code_of_their_features_alone() {
    let crates = ["src", "host/src"].map(read);
    let files: Vec<(&str, &str)> = crates.iter().flat_map(Crate::files).collect();
    assert_none("optional crates", &optional::strayed(Path::new(env!("CARGO_MANIFEST_DIR")), &files));
}

/// A crate of four files, in which each way to name an item occurs.
fn sample() -> Crate {
    let files = [
        ("src/lib.rs", "pub mod base; pub mod cli; pub use base::Low;"),
        ("src/base/mod.rs", "pub mod color; pub struct Low; pub use color::mix;"),
        (
            "src/base/color.rs",
            "//! Not an arrow: [`crate::cli::run`].\n\
             pub(in crate::base) fn mix() { let _ = \"crate::cli::run\"; }\n\
             fn up() { crate::cli::run(super::Low) }",
        ),
        (
            "src/cli.rs",
            "use crate::{Low, base::{self, mix as blend}};\n\
             pub fn run(_: Low) { base::color::mix(); blend(); }\n\
             #[cfg(test)]\nmod tests { use super::run; use crate::base::color; fn f() { color::mix() } }",
        ),
    ];
    Crate::parse("src", files.map(|(name, text)| (name.to_owned(), text.to_owned())).into())
}

#[test]
fn an_arrow_leads_to_the_file_that_defines_the_item() {
    let arrows = sample().arrows();
    let found: Vec<_> = arrows.iter().map(|a| (&*a.from, a.line, &*a.to, a.is_test)).collect();
    let expected = [
        ("src/base/color.rs", 3, "src/base/mod.rs", false),
        ("src/base/color.rs", 3, "src/cli.rs", false),
        ("src/cli.rs", 1, "src/base/color.rs", false),
        ("src/cli.rs", 1, "src/base/mod.rs", false),
        ("src/cli.rs", 2, "src/base/color.rs", false),
        ("src/cli.rs", 4, "src/base/color.rs", true),
    ];
    assert_eq!(found, expected, "{arrows:#?}");
}

#[test]
fn an_arrow_that_goes_up_is_named_with_file_and_line() {
    let expected = "src/base/color.rs:3: `crate::cli::run` is in src/cli.rs: base is a lower layer than cli";
    assert_eq!(upward(&sample().arrows()), [expected]);
}

#[test]
fn a_circle_is_named_arrow_by_arrow_unless_it_is_listed() {
    let arrow = |from: &str, to: &str| Arrow {
        from: format!("src/base/{from}"),
        line: 7,
        path: "super::x".into(),
        to: format!("src/base/{to}"),
        is_test: false,
    };
    let arrows = [arrow("a.rs", "b.rs"), arrow("b.rs", "c.rs"), arrow("c.rs", "a.rs"), arrow("c.rs", "d.rs")];
    let messages = circles::unlisted(&arrows, &[]);
    let expected = "src/base/a.rs <-> src/base/b.rs <-> src/base/c.rs\n    \
                    src/base/a.rs:7 `super::x` is in src/base/b.rs\n    \
                    src/base/b.rs:7 `super::x` is in src/base/c.rs\n    \
                    src/base/c.rs:7 `super::x` is in src/base/a.rs";
    assert_eq!(messages, [expected]);
    let listed = |line: &str| circles::listed("src/base/mod.rs", line);
    // Two files of a circle of three are not the circle.
    assert_eq!(circles::unlisted(&arrows, &listed("// Circle: a.rs <-> b.rs: they are one.")).len(), 1);
    let whole = listed("// Circle: a.rs <-> b.rs <-> c.rs: they are one.");
    assert!(circles::unlisted(&arrows, &whole).is_empty());
    assert!(circles::stale(&arrows, &whole).is_empty());
    assert_eq!(circles::stale(&arrows, &listed("// Circle: a.rs <-> d.rs: they are one.")).len(), 1);
    assert!(std::panic::catch_unwind(|| listed("// Circle: a.rs <-> b.rs:")).is_err(), "no reason");
}
