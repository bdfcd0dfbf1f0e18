//! What every stage may use: files that are read within a budget of memory, memory that is asked
//! for before it is used, colour spaces, enums with names.

pub(crate) mod color;
pub mod input;
pub mod names;
pub(crate) mod room;
