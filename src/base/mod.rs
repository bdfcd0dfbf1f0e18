//! Tools that all layers use: reading of files within a memory budget, replacement of files as a whole, checks
//! for memory, colour spaces, enums with names.

pub(crate) mod color;
pub(crate) mod host_memory;
pub mod input;
pub mod names;
pub(crate) mod output;
