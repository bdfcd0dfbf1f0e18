//! The kernels of `tests/kernels/`, as the build script describes them.
#![allow(missing_docs, reason = "fields of structs that a test fills and reads say enough")]

include!(concat!(env!("OUT_DIR"), "/kernels.rs"));
