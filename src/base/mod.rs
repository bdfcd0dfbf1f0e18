//! Tools of every stage: reading files within a budget of memory, replacing files as a whole, checks for
//! memory, colour spaces, enums with names.

pub(crate) mod color;
pub(crate) mod host_memory;
pub mod input;
pub mod names;
pub(crate) mod output;
