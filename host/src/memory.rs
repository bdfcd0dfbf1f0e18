//! The device memory of one buffer or image.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use ash::vk;

use crate::error::{Error, Result};
use crate::shared::DeviceShared;

/// An allocation of device memory, freed on drop. Its buffer or image must be destroyed before.
pub(crate) struct Memory {
    pub handle: vk::DeviceMemory,
    bytes: u64,
    device: Arc<DeviceShared>,
}

impl Memory {
    /// Allocates memory for a buffer or image that messages call `name`: with the properties `wanted` if there is
    /// any, else with those that are `needed`.
    pub fn new(
        device: &Arc<DeviceShared>,
        name: &'static str,
        needs: vk::MemoryRequirements,
        [wanted, needed]: [vk::MemoryPropertyFlags; 2],
    ) -> Result<Self> {
        let bytes = needs.size;
        let held = device.allocated.load(Ordering::Relaxed);
        let free = device.info.memory.free_bytes;
        let out_of_memory = || Error::OutOfMemory { buffer: name.to_owned(), bytes, held, free };
        // A software device grants more memory than there is; the system then ends the process.
        if held + bytes > free {
            return Err(out_of_memory());
        }
        let find = |properties| memory_type(device, needs.memory_type_bits, properties);
        let index = find(wanted).or_else(|| find(needed)).ok_or_else(out_of_memory)?;
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

/// Returns the index of the first memory type that a resource allows and that has the properties.
fn memory_type(device: &DeviceShared, allowed: u32, properties: vk::MemoryPropertyFlags) -> Option<u32> {
    let types = device.memory.memory_types_as_slice();
    (0..types.len() as u32)
        .find(|index| allowed & (1 << index) != 0 && types[*index as usize].property_flags.contains(properties))
}
