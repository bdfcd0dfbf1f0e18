//! Renders: options, iterations, lookups, counters, checkpoints. [`renderer::Renderer`] is what
//! callers use, `iteration.rs` is the algorithm.

pub(crate) mod buffers;
pub mod checkpoint;
pub(crate) mod counters;
pub mod device;
pub(crate) mod identity;
mod iteration;
pub mod lookup;
pub mod options;
pub(crate) mod pacing;
mod path_pass;
pub(crate) mod radius;
pub(crate) mod renderer;
pub(crate) mod sequence;
pub(crate) mod unsampled;
