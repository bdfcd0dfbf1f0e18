//! The Vulkan compute layer of goblet. It knows Vulkan and no physics.
//!
//! An [`Instance`] lists devices; [`Instance::open`] makes a [`Device`]; the device
//! makes [`Buffer`]s, [`Texels`] (arrays that kernels read faster) and [`Pass`]es (a
//! compiled kernel with its arrays bound) and records them into a [`Frame`], which runs
//! them in order.
//!
//! Synchronisation: one global memory barrier after every command of a frame, and
//! [`Frame::run`] returns when the device has finished. All `unsafe` of the project
//! is in this crate.

mod buffer;
mod device;
mod error;
mod frame;
mod guard;
mod instance;
mod kernel;
mod memory;
#[cfg(feature = "present")]
mod present;
#[cfg(unix)]
mod signal;
mod specialize;
mod texels;
mod timing;

pub use buffer::Buffer;
pub use device::Device;
pub use error::{Error, Result};
pub use frame::Frame;
pub use instance::{DeviceInfo, DeviceKind, Instance, Requirements};
pub use kernel::{Binding, Code, Compiling, Kernel, Pass, SpecializationValues};
pub use memory::machine_memory;
#[cfg(feature = "present")]
pub use present::{Interface, Screen};
#[cfg(unix)]
pub use signal::is_ignored;
pub use texels::Texels;
