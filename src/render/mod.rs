//! Renders: options, iterations, lookups, counters, checkpoints. Callers use [`renderer::Renderer`]. The
//! algorithm is in `iteration.rs`.

pub mod activity;
pub mod aov;
pub(crate) mod buffers;
pub mod checkpoint;
pub(crate) mod counters;
pub mod counts;
pub mod device;
pub(crate) mod error;
pub mod frame;
pub mod guide;
pub(crate) mod identity;
mod iteration;
mod layers;
pub mod lookup;
pub(crate) mod memory;
pub mod metadata;
pub mod options;
pub(crate) mod pacing;
mod passes;
mod progress;
pub(crate) mod radius;
pub(crate) mod renderer;
pub(crate) mod sequence;
mod settings;
pub(crate) mod specialize;
mod stage;
pub(crate) mod unsampled;
mod whole;

pub use device::device_features;
pub use pacing::photons_per_invocation;
pub use passes::is_queue;
pub use specialize::specialized;
