//! Tests of the packed arrays of scene texts.

mod reading;
mod texture;
