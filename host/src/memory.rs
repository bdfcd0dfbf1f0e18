//! Device memory of one buffer or image.

use std::fs;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use ash::vk;

use crate::device::DeviceShared;
use crate::error::{Error, Result};

/// An allocation, freed on drop: after what is bound to it.
pub(crate) struct Memory {
    pub handle: vk::DeviceMemory,
    bytes: u64,
    device: Arc<DeviceShared>,
}

impl Memory {
    /// Memory for what is called `name` in messages.
    pub fn new(
        device: &Arc<DeviceShared>,
        name: &'static str,
        needs: vk::MemoryRequirements,
        properties: vk::MemoryPropertyFlags,
    ) -> Result<Self> {
        let bytes = needs.size;
        let held = device.allocated.load(Ordering::Relaxed);
        let out_of_memory =
            || Error::OutOfMemory { buffer: name.to_owned(), bytes, held, total: device.info.memory_bytes };
        // Of a software device too: memory that it promises and does not have ends the process.
        if held + bytes > device.info.memory_bytes {
            return Err(out_of_memory());
        }
        let index = memory_type(device, needs.memory_type_bits, properties).ok_or_else(out_of_memory)?;
        let allocate = vk::MemoryAllocateInfo::default().allocation_size(bytes).memory_type_index(index);
        // SAFETY: the memory type is one that its user allows.
        let handle = unsafe { device.raw.allocate_memory(&allocate, None) }.map_err(|_| out_of_memory())?;
        device.allocated.fetch_add(bytes, Ordering::Relaxed);
        Ok(Self { handle, bytes, device: Arc::clone(device) })
    }
}

impl Drop for Memory {
    fn drop(&mut self) {
        // SAFETY: frames wait for the device before they return, so nothing uses it.
        unsafe { self.device.raw.free_memory(self.handle, None) };
        self.device.allocated.fetch_sub(self.bytes, Ordering::Relaxed);
    }
}

/// The first memory type that a resource allows and that has the properties.
fn memory_type(device: &DeviceShared, allowed: u32, properties: vk::MemoryPropertyFlags) -> Option<u32> {
    let types = device.memory.memory_types_as_slice();
    (0..types.len() as u32)
        .find(|index| allowed & (1 << index) != 0 && types[*index as usize].property_flags.contains(properties))
}

/// Bytes of memory that the machine has, where that is known (on Linux).
pub fn machine_memory() -> Option<u64> {
    memory_info("MemTotal:")
}

/// Bytes of memory that a process could have now, where that is known (on Linux).
pub(crate) fn available_memory() -> Option<u64> {
    memory_info("MemAvailable:")
}

fn memory_info(key: &str) -> Option<u64> {
    let text = fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix(key))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
}
