//! Opens a device that can render.

use std::path::Path;

use goblet_host::{Device, DeviceInfo, Instance};

use crate::kernels::{DeviceFeatures, REQUIREMENTS};

/// Which device to open, and how.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DeviceOptions<'a> {
    /// The index of the device in `goblet devices`, or part of its name; `None` is the first device
    /// that can render.
    pub selector: Option<&'a str>,
    /// Whether the Vulkan validation layers check every call. [`Device::validation_messages`] has
    /// their messages.
    pub validation: bool,
    /// A folder for compiled kernels, where the driver gives them away: a later device reads them there. They
    /// are written when the device is dropped. Nothing fails if this is not possible. `None` writes nothing.
    pub cache: Option<&'a Path>,
}

/// Opens a device.
///
/// # Errors
/// There is no such device, it lacks a feature that goblet needs, or the validation layers are wanted
/// and not installed.
pub fn open_device(options: &DeviceOptions<'_>) -> goblet_host::Result<Device> {
    Instance::new(options.validation)?.open(options.selector, &REQUIREMENTS, options.cache)
}

/// Returns what kernels with workgroups of this size are specialised to on a device.
pub fn device_features(device: &DeviceInfo, workgroup_size: u32) -> DeviceFeatures {
    let lanes = device.subgroups.lanes(workgroup_size);
    DeviceFeatures { knows_lanes: lanes.is_some(), lanes: lanes.unwrap_or(1) }
}
