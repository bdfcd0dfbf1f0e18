//! The Vulkan compute layer of goblet. It knows Vulkan and no physics.
//!
//! An [`Instance`] lists devices, and [`Instance::open`] opens a [`Device`]. The device makes
//! [`Buffer`]s, [`Texels`] (arrays in images or buffers, whichever the device reads faster) and [`Pass`]es
//! (compiled kernels with their arrays bound). A [`Frame`] records passes and runs them in order.
//!
//! Synchronisation: one global memory barrier follows every command of a frame, and [`Frame::run`] returns
//! when the device has finished. All `unsafe` code of the project is in this crate.

mod buffer;
mod device;
mod error;
mod floats;
mod frame;
mod group;
mod guard;
mod image;
mod instance;
mod kernel;
mod layout;
mod machine;
mod memory;
mod physical;
mod pipeline;
mod pipeline_cache;
#[cfg(feature = "present")]
mod present;
mod recording;
mod shared;
#[cfg(unix)]
mod signal;
mod specialize;
mod statistics;
mod subgroups;
mod texels;
mod timing;

pub use buffer::Buffer;
pub use device::Device;
pub use error::{Error, Result};
pub use frame::Frame;
pub use group::Group;
pub use instance::Instance;
pub use kernel::{Binding, Compiling, Kernel, Outline, Pass, SpecializationValues};
pub use layout::Place;
pub use machine::total_memory as machine_memory;
pub use physical::{ArrayKind, BindingCounts, DeviceInfo, DeviceKind, DeviceMemory, Requirements};
pub use pipeline::Code;
#[cfg(feature = "present")]
pub use present::{Interface, Screen};
#[cfg(unix)]
pub use signal::is_ignored;
pub use statistics::{Compiled, Compiler, Executable};
pub use subgroups::Subgroups;
pub use texels::{Extent, Texels};
