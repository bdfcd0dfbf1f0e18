//! Scene text in, packed arrays out.

mod reading;
mod texture;
