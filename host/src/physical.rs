//! Physical devices: their properties, memory, and limits.

use std::ffi::c_char;

use ash::{ext, vk};

use crate::floats;
use crate::machine;
use crate::subgroups::Subgroups;

/// The Vulkan version that every device must have.
pub(crate) const API_VERSION: u32 = vk::API_VERSION_1_2;

/// The least limits of a device that can run a program.
#[derive(Clone, Copy, Debug, Default)]
pub struct Requirements {
    /// What is bound to one kernel where texels are in images.
    pub in_images: BindingCounts,
    /// What is bound to one kernel where texels are in buffers.
    pub in_buffers: BindingCounts,
    /// What texels are to be in. `None` leaves it to the device.
    pub arrays: Option<ArrayKind>,
    /// Texels in a row of a storage image.
    pub texels_per_row: u32,
    /// Bytes of push constants.
    pub push_constant_bytes: u32,
    /// Descriptor sets bound at once.
    pub descriptor_sets: u32,
    /// Invocations in one workgroup.
    pub workgroup_size: u32,
}

/// Numbers of bindings.
#[derive(Clone, Copy, Debug, Default)]
pub struct BindingCounts {
    /// Of storage buffers.
    pub storage_buffers: u32,
    /// Of storage images.
    pub images: u32,
}

/// What texels are in. Software devices load from images many times faster than from buffers. GPUs load from
/// buffers as fast, and many bind few images.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ArrayKind {
    /// Each array is in an image.
    Images,
    /// Each array is in a storage buffer; arrays of a group share one.
    Buffers,
}

/// The kind of a device, in order of preference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum DeviceKind {
    /// A graphics card with memory of its own.
    Discrete,
    /// A GPU that shares memory with the CPU.
    Integrated,
    /// A GPU that a hypervisor passes through.
    Virtual,
    /// A software device, such as lavapipe.
    Cpu,
    /// Another kind.
    Other,
}

/// One line of the list of devices.
#[derive(Clone, Debug)]
pub struct DeviceInfo {
    /// Its position in the list, which stays the same as long as the drivers do.
    pub index: usize,
    /// The device's own name.
    pub name: String,
    /// Driver name and version.
    pub driver: String,
    /// Kind of device.
    pub kind: DeviceKind,
    /// Its memory at the time of the list.
    pub memory: DeviceMemory,
    /// The largest storage buffer that can be bound, in bytes.
    pub max_buffer_bytes: u64,
    /// The largest number of rows of an image.
    pub max_image_rows: u32,
    /// What texels are in on this device.
    pub arrays: ArrayKind,
    /// The reason for that.
    pub arrays_reason: String,
    /// Its subgroups.
    pub subgroups: Subgroups,
    /// Whether kernels ask that infinities, NaN and signed zeros are kept: on GPUs that can be asked.
    pub keeps_infinities: bool,
    /// The reason why it cannot be used; `None` if it can.
    pub unfit: Option<String>,
}

/// The memory of a device: that of the heap from which buffers and texels are allocated.
///
/// A software device allocates from the machine's memory. Both numbers are then the machine's, where the
/// system tells them (on Linux).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DeviceMemory {
    /// Bytes of the heap, used or not.
    pub total_bytes: u64,
    /// Bytes that this process could still allocate at the time of the query, by `VK_EXT_memory_budget`.
    /// A driver without that extension does not tell: then these are all bytes of the heap, and what is
    /// allocated is to be subtracted ([`Device::allocated_bytes`](crate::Device::allocated_bytes)).
    pub free_bytes: u64,
}

pub(crate) fn describe(
    instance: &ash::Instance,
    physical: vk::PhysicalDevice,
    requirements: &Requirements,
) -> DeviceInfo {
    let mut driver = vk::PhysicalDeviceDriverProperties::default();
    let mut properties = vk::PhysicalDeviceProperties2::default().push_next(&mut driver);
    // SAFETY: `physical` belongs to `instance`, whose version 1.2 has this function.
    unsafe { instance.get_physical_device_properties2(physical, &mut properties) };
    let properties = properties.properties;
    let kind = match properties.device_type {
        vk::PhysicalDeviceType::DISCRETE_GPU => DeviceKind::Discrete,
        vk::PhysicalDeviceType::INTEGRATED_GPU => DeviceKind::Integrated,
        vk::PhysicalDeviceType::VIRTUAL_GPU => DeviceKind::Virtual,
        vk::PhysicalDeviceType::CPU => DeviceKind::Cpu,
        _ => DeviceKind::Other,
    };
    let driver = format!("{} {}", text(&driver.driver_name), text(&driver.driver_info));
    let (arrays, arrays_reason) = choose_arrays(kind, &properties.limits, requirements);
    DeviceInfo {
        index: 0,
        name: text(&properties.device_name),
        driver: driver.trim().to_owned(),
        kind,
        memory: memory(instance, physical, kind),
        max_buffer_bytes: u64::from(properties.limits.max_storage_buffer_range),
        subgroups: Subgroups::of(
            instance,
            physical,
            has_extension(instance, physical, ext::subgroup_size_control::NAME),
        ),
        // On SwiftShader, kernels that ask for it take minutes to compile. All tests pass on CPU drivers without it.
        keeps_infinities: kind != DeviceKind::Cpu && floats::can_keep(instance, physical),
        max_image_rows: properties.limits.max_image_dimension2_d,
        arrays,
        arrays_reason,
        unfit: unfit(instance, physical, &properties, requirements, arrays),
    }
}

/// Returns a driver's text, which ends with a 0.
pub(crate) fn text(name: &[c_char]) -> String {
    let bytes: Vec<u8> = name.iter().take_while(|c| **c != 0).map(|c| c.cast_unsigned()).collect();
    String::from_utf8_lossy(&bytes).into_owned()
}

/// Returns what texels are in on a device, and the reason.
fn choose_arrays(
    kind: DeviceKind,
    limits: &vk::PhysicalDeviceLimits,
    requirements: &Requirements,
) -> (ArrayKind, String) {
    if let Some(arrays) = requirements.arrays {
        return (arrays, "as asked for".into());
    }
    match (kind, missing(limits, &array_needs(requirements, ArrayKind::Images))) {
        (DeviceKind::Cpu, None) => (ArrayKind::Images, "CPUs load from images faster than from buffers".into()),
        (DeviceKind::Cpu, Some(lack)) => (ArrayKind::Buffers, format!("{lack} for images")),
        _ => (ArrayKind::Buffers, "GPUs load from buffers as fast as from images".into()),
    }
}

/// A limit: what it is of, the device's, and the least that is needed.
type Need = (&'static str, fn(&vk::PhysicalDeviceLimits) -> u32, u32);

/// Returns the limits on which a kind of arrays depends.
fn array_needs(requirements: &Requirements, arrays: ArrayKind) -> [Need; 3] {
    let (counts, row) = match arrays {
        ArrayKind::Images => (requirements.in_images, requirements.texels_per_row),
        ArrayKind::Buffers => (requirements.in_buffers, 0),
    };
    [
        ("storage buffers per stage", |limits| limits.max_per_stage_descriptor_storage_buffers, counts.storage_buffers),
        ("storage images per stage", |limits| limits.max_per_stage_descriptor_storage_images, counts.images),
        ("texels in a row", |limits| limits.max_image_dimension2_d, row),
    ]
}

/// Returns what a device lacks.
fn missing(limits: &vk::PhysicalDeviceLimits, needs: &[Need]) -> Option<String> {
    let needs = needs.iter().map(|(what, has, needed)| (what, has(limits), *needed));
    let lack = needs.into_iter().find(|(_, has, needed)| has < needed);
    lack.map(|(what, has, needed)| format!("it has {has} {what}, and {needed} are needed"))
}

/// Returns the reason why a device cannot run the program; `None` if it can.
fn unfit(
    instance: &ash::Instance,
    physical: vk::PhysicalDevice,
    properties: &vk::PhysicalDeviceProperties,
    requirements: &Requirements,
    arrays: ArrayKind,
) -> Option<String> {
    let needs: [Need; 3] = [
        ("bytes of push constants", |limits| limits.max_push_constants_size, requirements.push_constant_bytes),
        ("descriptor sets", |limits| limits.max_bound_descriptor_sets, requirements.descriptor_sets),
        ("invocations per workgroup", |limits| limits.max_compute_work_group_invocations, requirements.workgroup_size),
    ];
    if properties.api_version < API_VERSION {
        return Some("it has no Vulkan 1.2".into());
    }
    if compute_family(instance, physical).is_none() {
        return Some("it has no compute queue".into());
    }
    let limits = &properties.limits;
    missing(limits, &array_needs(requirements, arrays)).or_else(|| missing(limits, &needs))
}

/// Returns the index and the number of timestamp bits of the first queue family that computes and does not draw,
/// or else of the first that computes: a queue of its own leaves the screen to others.
pub(crate) fn compute_family(instance: &ash::Instance, physical: vk::PhysicalDevice) -> Option<(u32, u32)> {
    // SAFETY: `physical` belongs to `instance`.
    let families = unsafe { instance.get_physical_device_queue_family_properties(physical) };
    let computes = |family: &vk::QueueFamilyProperties| family.queue_flags.contains(vk::QueueFlags::COMPUTE);
    let draws = |family: &vk::QueueFamilyProperties| family.queue_flags.contains(vk::QueueFlags::GRAPHICS);
    let alone = families.iter().position(|family| computes(family) && !draws(family));
    let index = alone.or_else(|| families.iter().position(computes))?;
    Some((u32::try_from(index).ok()?, families[index].timestamp_valid_bits))
}

/// Asks a device how much memory it has, and how much of that is free.
pub(crate) fn memory(instance: &ash::Instance, physical: vk::PhysicalDevice, kind: DeviceKind) -> DeviceMemory {
    let mut budgets = vk::PhysicalDeviceMemoryBudgetPropertiesEXT::default();
    let mut properties = vk::PhysicalDeviceMemoryProperties2::default();
    let has_budgets = has_extension(instance, physical, ext::memory_budget::NAME);
    if has_budgets {
        properties = properties.push_next(&mut budgets);
    }
    // SAFETY: `physical` belongs to `instance`, whose version 1.2 has this function, and has the
    // extension of what is chained.
    unsafe { instance.get_physical_device_memory_properties2(physical, &mut properties) };
    let properties = properties.memory_properties;
    let heap = local_heap(&properties);
    let total = properties.memory_heaps[heap].size;
    let budget = has_budgets.then(|| budgets.heap_budget[heap].saturating_sub(budgets.heap_usage[heap]));
    let heap = DeviceMemory { total_bytes: total, free_bytes: budget.unwrap_or(total).min(total) };
    match (kind, machine::total_memory(), machine::available_memory()) {
        // The heap that a software device reports can be larger than what is free.
        (DeviceKind::Cpu, Some(total_bytes), Some(free_bytes)) => DeviceMemory { total_bytes, free_bytes },
        _ => heap,
    }
}

/// Returns the heap of the first device-local memory type. Vulkan lists types with fewer properties first,
/// so that this is not the smaller heap that is also visible to the host.
fn local_heap(memory: &vk::PhysicalDeviceMemoryProperties) -> usize {
    let local = |kind: &&vk::MemoryType| kind.property_flags.contains(vk::MemoryPropertyFlags::DEVICE_LOCAL);
    memory.memory_types_as_slice().iter().find(local).map_or(0, |kind| kind.heap_index as usize)
}

/// Returns whether a device has an extension; false if it fails to list its extensions.
pub(crate) fn has_extension(instance: &ash::Instance, physical: vk::PhysicalDevice, name: &std::ffi::CStr) -> bool {
    // SAFETY: `physical` belongs to `instance`.
    let extensions = unsafe { instance.enumerate_device_extension_properties(physical) }.unwrap_or_default();
    extensions.iter().any(|extension| extension.extension_name_as_c_str() == Ok(name))
}
