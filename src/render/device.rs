//! Opens a device that can render.

use std::path::Path;

use goblet_host::{ArrayKind, Device, DeviceInfo, Instance, Requirements};

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
    /// What the arrays that kernels load from are in. `None` is what the device loads from faster. It changes no
    /// byte of an image.
    pub arrays: Option<ArrayKind>,
}

/// Opens a device.
///
/// # Errors
/// There is no such device, it lacks a feature that goblet needs, or the validation layers are wanted
/// and not installed.
pub fn open_device(options: &DeviceOptions<'_>) -> goblet_host::Result<Device> {
    let requirements = Requirements { arrays: options.arrays, ..REQUIREMENTS };
    Instance::new(options.validation)?.open(options.selector, &requirements, options.cache)
}

/// Returns what kernels with workgroups of this size are specialised to on a device.
pub fn device_features(device: &DeviceInfo, workgroup_size: u32) -> DeviceFeatures {
    let lanes = device.subgroups.lanes(workgroup_size);
    DeviceFeatures {
        // As arrays are in buffers on GPUs. A driver of a CPU has memory alone, and runs what is in a loop in every round.
        few_registers: device.arrays == ArrayKind::Buffers,
        knows_lanes: lanes.is_some(),
        lanes: lanes.unwrap_or(1),
    }
}

#[cfg(test)]
mod tests {
    use goblet_host::BindingCounts;

    use super::*;

    /// What MoltenVK and SwiftShader bind, with room for the sorts of arrays to come.
    #[test]
    fn kernels_with_arrays_in_buffers_bind_few_buffers_and_no_image() {
        let BindingCounts { storage_buffers, images } = REQUIREMENTS.in_buffers;
        assert!(storage_buffers <= 12 && images == 0, "{storage_buffers} storage buffers and {images} images");
    }
}
