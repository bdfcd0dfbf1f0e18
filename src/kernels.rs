//! The GPU's structs and kernels, as the build script reflects them from `shaders/`.
#![allow(missing_docs, reason = "the GLSL documents its fields; comments are not reflected")]

include!(concat!(env!("OUT_DIR"), "/kernels.rs"));
