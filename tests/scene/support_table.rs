//! docs/support.md lists what the parser reads.

#[path = "../../examples/support_table.rs"]
#[allow(dead_code, reason = "its main function prints the page")]
mod writer;

#[test]
fn the_page_of_support_is_that_of_the_parser() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/support.md");
    let found = std::fs::read_to_string(path).expect("docs/support.md");
    assert!(
        found == writer::table(),
        "docs/support.md is out of date: {}",
        "cargo run --example support_table > docs/support.md"
    );
}
