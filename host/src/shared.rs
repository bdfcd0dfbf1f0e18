//! The Vulkan handles of a device, which all its parts hold.

use std::sync::atomic::AtomicU64;

use ash::vk;

use crate::instance::Instance;
use crate::physical::DeviceInfo;
use crate::pipeline::Pipelines;

/// A Vulkan device with its queue and command pool. Buffers, texels, passes and the timer hold it,
/// so that it is destroyed after them.
pub(crate) struct DeviceShared {
    pub raw: ash::Device,
    pub physical: vk::PhysicalDevice,
    pub info: DeviceInfo,
    /// Texels in a row of each image.
    pub texels_per_row: u32,
    pub queue: vk::Queue,
    pub command_pool: vk::CommandPool,
    pub memory: vk::PhysicalDeviceMemoryProperties,
    /// Nanoseconds of a timestamp's unit; `None` if the queue has no timestamps.
    pub nanoseconds_per_tick: Option<f32>,
    /// Kernels that have been compiled.
    pub pipelines: Pipelines,
    /// Bytes of device memory that buffers and texels hold now.
    pub allocated: AtomicU64,
    /// Kept alive until the device is destroyed.
    pub instance: Instance,
}

impl Drop for DeviceShared {
    fn drop(&mut self) {
        // SAFETY: buffers, passes and the timer hold this; they are gone; destroying a null
        // handle does nothing.
        unsafe {
            self.pipelines.destroy(&self.raw);
            self.raw.destroy_command_pool(self.command_pool, None);
            self.raw.destroy_device(None);
        }
    }
}
