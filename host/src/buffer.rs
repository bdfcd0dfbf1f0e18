//! Buffers with checked sizes.

use std::marker::PhantomData;
use std::sync::Arc;

use ash::vk;
use bytemuck::Pod;

use crate::error::{Context, Error, Result};
use crate::memory::Memory;
use crate::shared::DeviceShared;

/// An array of `T` in device memory.
pub struct Buffer<T> {
    raw: Arc<RawBuffer>,
    length: u64,
    element: PhantomData<T>,
}

impl<T: Pod> Buffer<T> {
    /// Allocates a buffer with a guard zone of `guard` bytes after its end.
    pub(crate) fn new(device: &Arc<DeviceShared>, name: &'static str, length: u64, guard: u64) -> Result<Self> {
        let bytes = length.max(1).saturating_mul(size_of::<T>() as u64);
        Ok(Self { raw: Arc::new(RawBuffer::bound(device, name, bytes, guard)?), length, element: PhantomData })
    }
}

impl<T> Buffer<T> {
    /// Returns the number of elements.
    pub fn len(&self) -> u64 {
        self.length
    }

    /// Returns whether it has no element.
    pub fn is_empty(&self) -> bool {
        self.length == 0
    }

    /// Returns its name in messages.
    pub fn name(&self) -> &'static str {
        self.raw.name
    }

    pub(crate) fn raw(&self) -> &Arc<RawBuffer> {
        &self.raw
    }
}

/// A buffer with memory of its own.
pub(crate) struct RawBuffer {
    pub name: &'static str,
    pub handle: vk::Buffer,
    pub bytes: u64,
    memory: Option<Memory>,
    /// Address of the host's mapping; null for device-local buffers.
    mapped: *mut u8,
    device: Arc<DeviceShared>,
}

// SAFETY: the mapped pointer is only used through `&self` methods of a `Device`, under one of its
// locks; the handles themselves are plain numbers.
unsafe impl Send for RawBuffer {}
// SAFETY: as above; `map_read` and `map_write` are called under a lock of the device only.
unsafe impl Sync for RawBuffer {}

impl RawBuffer {
    /// Allocates a buffer in device memory that kernels bind, with `guard` bytes after its end.
    pub fn bound(device: &Arc<DeviceShared>, name: &'static str, bytes: u64, guard: u64) -> Result<Self> {
        let limit = device.info.max_buffer_bytes;
        if bytes > limit {
            return Err(Error::BufferTooLarge { buffer: name.to_owned(), bytes, limit });
        }
        let transfers = vk::BufferUsageFlags::TRANSFER_SRC | vk::BufferUsageFlags::TRANSFER_DST;
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER | vk::BufferUsageFlags::INDIRECT_BUFFER | transfers;
        Self::new(device, name, bytes + guard, usage, [vk::MemoryPropertyFlags::DEVICE_LOCAL; 2])
    }

    /// Allocates a buffer in host memory, which stays mapped.
    pub fn host(device: &Arc<DeviceShared>, name: &'static str, bytes: u64) -> Result<Self> {
        let usage = vk::BufferUsageFlags::TRANSFER_SRC | vk::BufferUsageFlags::TRANSFER_DST;
        let visible = vk::MemoryPropertyFlags::HOST_VISIBLE | vk::MemoryPropertyFlags::HOST_COHERENT;
        // Without it, the memory may be one that the host writes fast and reads very slowly.
        let cached = visible | vk::MemoryPropertyFlags::HOST_CACHED;
        let mut buffer = Self::new(device, name, bytes, usage, [cached, visible])?;
        if let Some(memory) = &buffer.memory {
            // SAFETY: the memory is host visible and not mapped yet.
            let mapped =
                unsafe { device.raw.map_memory(memory.handle, 0, vk::WHOLE_SIZE, vk::MemoryMapFlags::empty()) };
            buffer.mapped = mapped.context("vkMapMemory")?.cast();
        }
        Ok(buffer)
    }

    fn new(
        device: &Arc<DeviceShared>,
        name: &'static str,
        bytes: u64,
        usage: vk::BufferUsageFlags,
        properties: [vk::MemoryPropertyFlags; 2],
    ) -> Result<Self> {
        let create = vk::BufferCreateInfo::default().size(bytes).usage(usage);
        // SAFETY: the size is positive; the buffer is destroyed on drop.
        let handle = unsafe { device.raw.create_buffer(&create, None) }.context("vkCreateBuffer")?;
        let mut buffer =
            Self { name, handle, bytes, memory: None, mapped: std::ptr::null_mut(), device: Arc::clone(device) };
        // SAFETY: the buffer was just made by this device.
        let needs = unsafe { device.raw.get_buffer_memory_requirements(handle) };
        let memory = Memory::new(device, name, needs, properties)?;
        // SAFETY: fresh memory of the required size, bound once.
        unsafe { device.raw.bind_buffer_memory(handle, memory.handle, 0) }.context("vkBindBufferMemory")?;
        buffer.memory = Some(memory);
        Ok(buffer)
    }

    /// Writes the first bytes of a host buffer. Panics if `data` is longer than it.
    pub fn map_write(&self, data: &[u8]) {
        assert!(!self.mapped.is_null() && data.len() as u64 <= self.bytes);
        // SAFETY: mapped, long enough, and no submission is in flight.
        unsafe { std::ptr::copy_nonoverlapping(data.as_ptr(), self.mapped, data.len()) };
    }

    /// Reads the first bytes of a host buffer. Panics if `data` is longer than it.
    pub fn map_read(&self, data: &mut [u8]) {
        assert!(!self.mapped.is_null() && data.len() as u64 <= self.bytes);
        // SAFETY: mapped, long enough, and no submission is in flight.
        unsafe { std::ptr::copy_nonoverlapping(self.mapped, data.as_mut_ptr(), data.len()) };
    }
}

impl Drop for RawBuffer {
    fn drop(&mut self) {
        // SAFETY: frames wait for the device before they return, so nothing uses it.
        unsafe { self.device.raw.destroy_buffer(self.handle, None) };
    }
}
