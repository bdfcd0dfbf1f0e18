//! Tools of every stage: reading files within a budget of memory, replacing files as a whole, checks for
//! memory, colour spaces, enums with names.

pub(crate) mod color;
pub mod input;
pub mod names;
pub(crate) mod output;
pub(crate) mod room;
