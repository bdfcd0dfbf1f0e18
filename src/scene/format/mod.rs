//! The pbrt-v4 text format: tokens, parameters, the types that goblet knows, errors with a place.

pub(in crate::scene) mod error;
pub(in crate::scene) mod files;
pub(in crate::scene) mod instead;
pub(in crate::scene) mod kind;
pub(in crate::scene) mod lexer;
pub(in crate::scene) mod params;
pub(in crate::scene) mod registry;
pub(in crate::scene) mod version3;
