//! The scene format: no text makes a panic, and the documents list what the parser reads.

mod instead;
mod measured;
mod mutations;
#[path = "../support/mod.rs"]
mod support;
mod support_table;
