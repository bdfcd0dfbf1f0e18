//! The Vulkan handles of a device, which all its parts hold.

use std::ffi::CStr;
use std::path::Path;
use std::sync::atomic::AtomicU64;

use ash::{ext, khr, vk};

use crate::error::{Context, Result};
use crate::instance::Instance;
use crate::layout::Layouts;
use crate::physical::{DeviceInfo, has_extension};
use crate::pipeline::Pipelines;
use crate::pipeline_cache::PipelineCache;

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
    /// Layouts of kernels.
    pub layouts: Layouts,
    /// How often commands were submitted.
    pub submissions: AtomicU64,
    /// Kept alive until the device is destroyed.
    pub instance: Instance,
}

impl DeviceShared {
    /// Opens a device with one queue of a family, given by its index and its number of timestamp bits. `cache` is
    /// the folder for the driver's compiled kernels.
    pub fn open(
        instance: Instance,
        physical: vk::PhysicalDevice,
        info: DeviceInfo,
        texels_per_row: u32,
        (family, timestamp_bits): (u32, u32),
        extensions: &[&CStr],
        cache: Option<&Path>,
    ) -> Result<Self> {
        let vulkan = &instance.shared.raw;
        let tells_statistics = extensions.contains(&khr::pipeline_executable_properties::NAME);
        let mut extensions: Vec<_> = extensions.iter().map(|name| name.as_ptr()).collect();
        let queues = [vk::DeviceQueueCreateInfo::default().queue_family_index(family).queue_priorities(&[1.0])];
        let mut subgroups = vk::PhysicalDeviceSubgroupSizeControlFeatures::default();
        let mut create = vk::DeviceCreateInfo::default().queue_create_infos(&queues);
        if info.subgroups.required.is_some() {
            extensions.push(ext::subgroup_size_control::NAME.as_ptr());
            subgroups = subgroups.subgroup_size_control(true).compute_full_subgroups(true);
            create = create.push_next(&mut subgroups);
        }
        let mut statistics = vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR::default();
        if tells_statistics {
            statistics = statistics.pipeline_executable_info(true);
            create = create.push_next(&mut statistics);
        }
        // A layer over another system's devices, such as MoltenVK, wants to hear that its limits are known.
        if has_extension(vulkan, physical, khr::portability_subset::NAME) {
            extensions.push(khr::portability_subset::NAME.as_ptr());
        }
        create = create.enabled_extension_names(&extensions);
        // SAFETY: `physical` belongs to this instance, which the device keeps alive.
        let raw = unsafe { vulkan.create_device(physical, &create, None) }.context("vkCreateDevice")?;
        let pool = vk::CommandPoolCreateInfo::default()
            .queue_family_index(family)
            .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER);
        // SAFETY: the device was just made with one queue of this family.
        let (queue, properties, memory) = unsafe {
            (
                raw.get_device_queue(family, 0),
                vulkan.get_physical_device_properties(physical),
                vulkan.get_physical_device_memory_properties(physical),
            )
        };
        let mut shared = Self {
            nanoseconds_per_tick: (timestamp_bits > 0).then_some(properties.limits.timestamp_period),
            pipelines: Pipelines::new(PipelineCache::open(&raw, &properties, cache)),
            allocated: AtomicU64::new(0),
            layouts: Layouts::default(),
            submissions: AtomicU64::new(0),
            raw,
            physical,
            info,
            texels_per_row,
            queue,
            command_pool: vk::CommandPool::null(),
            memory,
            instance,
        };
        // SAFETY: the device has a queue of this family; destroyed with it.
        shared.command_pool = unsafe { shared.raw.create_command_pool(&pool, None) }.context("vkCreateCommandPool")?;
        Ok(shared)
    }
}

impl Drop for DeviceShared {
    fn drop(&mut self) {
        // SAFETY: buffers, passes and the timer hold this; they are gone; destroying a null
        // handle does nothing.
        unsafe {
            self.pipelines.destroy(&self.raw);
            self.layouts.destroy(&self.raw);
            self.raw.destroy_command_pool(self.command_pool, None);
            self.raw.destroy_device(None);
        }
    }
}
