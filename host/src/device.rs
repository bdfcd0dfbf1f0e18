//! A device with its one compute queue.

use std::ffi::CStr;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::Duration;

use ash::vk;
use bytemuck::Pod;

use crate::buffer::{Buffer, RawBuffer};
use crate::error::{Context, Error, Result};
use crate::guard::{GUARD_BYTES, GUARD_ROWS, Guards};
use crate::instance::{DeviceInfo, Instance};
use crate::texels::RawTexels;
use crate::timing::Timer;
use crate::{Compiling, Frame, Kernel, Pass, Texels};

/// Bytes moved between host and device at once.
const STAGING_BYTES: u64 = 16 << 20;

pub(crate) struct DeviceShared {
    pub raw: ash::Device,
    pub info: DeviceInfo,
    pub texels_per_row: u32,
    pub queue: vk::Queue,
    pub command_pool: vk::CommandPool,
    pub memory: vk::PhysicalDeviceMemoryProperties,
    pub nanoseconds_per_tick: Option<f32>,
    pub allocated: AtomicU64,
    pub instance: Instance,
}

/// An open device: makes buffers, passes and frames. Threads may share it: they wait for each other's
/// frames, since there is one queue, one command pool and one set of timestamps. A thread must not ask
/// for a frame, nor read or write an array, while it has another frame: it would wait for itself.
pub struct Device {
    pub(crate) shared: Arc<DeviceShared>,
    /// Locked during a transfer, before `recording` is.
    staging: Mutex<RawBuffer>,
    pub(crate) timer: Timer,
    pub(crate) guards: Option<Guards>,
    /// Locked as long as there is a frame.
    pub(crate) recording: Mutex<()>,
}

impl Device {
    pub(crate) fn open(
        instance: Instance,
        physical: vk::PhysicalDevice,
        info: DeviceInfo,
        texels_per_row: u32,
    ) -> Result<Self> {
        let family = compute_family(&instance.shared.raw, physical)
            .ok_or_else(|| Error::Unfit { device: info.name.clone(), reason: "it has no compute queue".into() })?;
        Self::with_family(instance, physical, info, texels_per_row, family, &[])
    }

    /// A device whose queue is of the family with that index and so many timestamp bits.
    pub(crate) fn with_family(
        instance: Instance,
        physical: vk::PhysicalDevice,
        info: DeviceInfo,
        texels_per_row: u32,
        (family, timestamp_bits): (u32, u32),
        extensions: &[&CStr],
    ) -> Result<Self> {
        let vulkan = &instance.shared.raw;
        let extensions: Vec<_> = extensions.iter().map(|name| name.as_ptr()).collect();
        let queues = [vk::DeviceQueueCreateInfo::default().queue_family_index(family).queue_priorities(&[1.0])];
        let create = vk::DeviceCreateInfo::default().queue_create_infos(&queues).enabled_extension_names(&extensions);
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
        let mut shared = DeviceShared {
            nanoseconds_per_tick: (timestamp_bits > 0).then_some(properties.limits.timestamp_period),
            allocated: AtomicU64::new(0),
            raw,
            info,
            texels_per_row,
            queue,
            command_pool: vk::CommandPool::null(),
            memory,
            instance,
        };
        // SAFETY: the device has a queue of this family; destroyed with it.
        shared.command_pool = unsafe { shared.raw.create_command_pool(&pool, None) }.context("vkCreateCommandPool")?;
        let shared = Arc::new(shared);
        let staging = RawBuffer::host(&shared, "staging", STAGING_BYTES)?;
        let timer = Timer::new(&shared)?;
        Ok(Self { shared, staging: Mutex::new(staging), timer, guards: None, recording: Mutex::new(()) })
    }

    /// What the list of devices says of this one.
    pub fn info(&self) -> &DeviceInfo {
        &self.shared.info
    }

    /// What the validation layer has said so far; empty without validation.
    pub fn validation_messages(&self) -> Vec<String> {
        self.shared.instance.validation_messages()
    }

    /// Gives every array that is made from now on a guard zone that is full of this word; the
    /// array's own contents begin as it, too. For tests of kernels: each frame looks at all guard
    /// zones.
    ///
    /// # Errors
    /// Out of memory.
    pub fn guard(&mut self, word: u32) -> Result<()> {
        self.guards = Some(Guards::new(&self.shared, word)?);
        Ok(())
    }

    /// Arrays past whose end a kernel has written, with the passes of the frame after which that
    /// was found; empty without [`guard`](Self::guard).
    pub fn broken_guards(&self) -> Vec<String> {
        self.guards.as_ref().map(Guards::broken).unwrap_or_default()
    }

    /// A device-local buffer of `length` elements (at least one, since Vulkan binds
    /// no empty buffer), its contents undefined.
    ///
    /// # Errors
    /// Too large for one binding, or out of device memory.
    pub fn buffer<T: Pod>(&self, name: &'static str, length: u64) -> Result<Buffer<T>> {
        let guard = self.guards.as_ref().map_or(0, |_| GUARD_BYTES);
        let buffer = Buffer::new(&self.shared, name, length, guard)?;
        if let Some(guards) = &self.guards {
            guards.watch_buffer(self, buffer.raw())?;
        }
        Ok(buffer)
    }

    /// A buffer that holds `data`.
    ///
    /// # Errors
    /// As [`Device::buffer`], or the transfer fails.
    pub fn upload<T: Pod>(&self, name: &'static str, data: &[T]) -> Result<Buffer<T>> {
        let buffer = self.buffer(name, data.len() as u64)?;
        self.write(&buffer, data)?;
        Ok(buffer)
    }

    /// Overwrites the first elements of a buffer. Panics if `data` is longer than it.
    ///
    /// # Errors
    /// The transfer fails.
    pub fn write<T: Pod>(&self, buffer: &Buffer<T>, data: &[T]) -> Result<()> {
        assert!(data.len() as u64 <= buffer.len(), "buffer {} is too short", buffer.name());
        let bytes: &[u8] = bytemuck::cast_slice(data);
        let staging = lock(&self.staging);
        for (index, chunk) in bytes.chunks(STAGING_BYTES as usize).enumerate() {
            staging.map_write(chunk);
            let offset = index as u64 * STAGING_BYTES;
            let mut frame = self.frame()?;
            frame.copy(&staging, 0, buffer.raw(), offset, chunk.len() as u64);
            frame.run()?;
        }
        Ok(())
    }

    /// The contents of a buffer.
    ///
    /// # Errors
    /// The transfer fails.
    pub fn read<T: Pod>(&self, buffer: &Buffer<T>) -> Result<Vec<T>> {
        let mut data = vec![T::zeroed(); buffer.len() as usize];
        let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut data);
        let staging = lock(&self.staging);
        for (index, chunk) in bytes.chunks_mut(STAGING_BYTES as usize).enumerate() {
            let offset = index as u64 * STAGING_BYTES;
            let mut frame = self.frame()?;
            frame.copy(buffer.raw(), offset, &staging, 0, chunk.len() as u64);
            frame.run()?;
            staging.map_read(chunk);
        }
        Ok(data)
    }

    /// Texels for `length` elements (at least one), their contents undefined.
    ///
    /// # Errors
    /// Too large for one image, or out of device memory.
    pub fn texels<T: Pod>(&self, name: &'static str, length: u64) -> Result<Texels<T>> {
        let guard_rows = self.guards.as_ref().map_or(0, |_| GUARD_ROWS);
        let texels = Texels::new(&self.shared, name, length, guard_rows)?;
        let mut frame = self.frame()?;
        frame.transition(texels.raw(), vk::ImageLayout::UNDEFINED, vk::ImageLayout::GENERAL);
        frame.run()?;
        if let Some(guards) = &self.guards {
            guards.watch_texels(self, texels.raw())?;
        }
        Ok(texels)
    }

    /// Texels that hold `data`.
    ///
    /// # Errors
    /// As [`Device::texels`], or the transfer fails.
    pub fn upload_texels<T: Pod>(&self, name: &'static str, data: &[T]) -> Result<Texels<T>> {
        let texels = self.texels(name, data.len() as u64)?;
        self.write_texels(&texels, data)?;
        Ok(texels)
    }

    /// Overwrites the first elements of texels. Panics if `data` is longer than they are.
    ///
    /// # Errors
    /// The transfer fails.
    pub fn write_texels<T: Pod>(&self, texels: &Texels<T>, data: &[T]) -> Result<()> {
        assert!(data.len() as u64 <= texels.len(), "texels {} are too short", texels.name());
        let rows = staged_rows(texels.raw());
        let bytes: &[u8] = bytemuck::cast_slice(data);
        let staging = lock(&self.staging);
        for (index, chunk) in bytes.chunks((rows * texels.raw().row_bytes()) as usize).enumerate() {
            staging.map_write(chunk);
            let mut frame = self.frame()?;
            frame.copy_to_rows(&staging, texels.raw(), index as u64 * rows, chunk.len() as u64);
            frame.run()?;
        }
        Ok(())
    }

    /// The contents of texels.
    ///
    /// # Errors
    /// The transfer fails.
    pub fn read_texels<T: Pod>(&self, texels: &Texels<T>) -> Result<Vec<T>> {
        self.read_first_texels(texels, texels.len())
    }

    /// The first elements of texels. Panics if there are not so many.
    ///
    /// # Errors
    /// The transfer fails.
    pub fn read_first_texels<T: Pod>(&self, texels: &Texels<T>, count: u64) -> Result<Vec<T>> {
        assert!(count <= texels.len(), "texels {} are too short", texels.name());
        let mut data = vec![T::zeroed(); count as usize];
        let rows = staged_rows(texels.raw());
        let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut data);
        let staging = lock(&self.staging);
        for (index, chunk) in bytes.chunks_mut((rows * texels.raw().row_bytes()) as usize).enumerate() {
            let mut frame = self.frame()?;
            frame.copy_from_rows(texels.raw(), index as u64 * rows, &staging, chunk.len() as u64);
            frame.run()?;
            staging.map_read(chunk);
        }
        Ok(data)
    }

    /// Compiles a kernel for a workgroup size and binds its buffers, which the pass
    /// keeps alive.
    ///
    /// # Errors
    /// The kernel was not built for that size, or the driver refuses it.
    pub fn pass<K: Kernel>(
        &self,
        kernel: &K,
        specialization: &K::Specialization,
        workgroup_size: u32,
    ) -> Result<Pass<K::Push>> {
        Pass::new(&self.shared, kernel, specialization, workgroup_size)
    }

    /// The same, without waiting for the compiler.
    ///
    /// # Errors
    /// As [`Device::pass`].
    pub fn compile<K: Kernel>(
        &self,
        kernel: &K,
        specialization: &K::Specialization,
        workgroup_size: u32,
    ) -> Result<Compiling<K::Push>> {
        Compiling::new(&self.shared, kernel, specialization, workgroup_size)
    }

    /// An empty recording.
    ///
    /// # Errors
    /// Out of memory.
    pub fn frame(&self) -> Result<Frame<'_>> {
        Frame::new(self)
    }

    /// Device time by kernel name since the device was opened; empty where the
    /// device has no timestamps.
    pub fn pass_times(&self) -> Vec<(&'static str, Duration)> {
        self.timer.totals()
    }

    /// Bytes of device memory that buffers hold now.
    pub fn allocated_bytes(&self) -> u64 {
        self.shared.allocated.load(Ordering::Relaxed)
    }
}

/// Locks what has no state that a panic of another thread could leave broken.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}

/// Rows of texels that are moved at once.
fn staged_rows(texels: &RawTexels) -> u64 {
    (STAGING_BYTES / texels.row_bytes()).max(1)
}

impl Drop for DeviceShared {
    fn drop(&mut self) {
        // SAFETY: buffers, passes and the timer hold this; they are gone; destroying a null
        // handle does nothing.
        unsafe {
            self.raw.destroy_command_pool(self.command_pool, None);
            self.raw.destroy_device(None);
        }
    }
}

/// The first queue family that computes, and its timestamp bits.
pub(crate) fn compute_family(instance: &ash::Instance, physical: vk::PhysicalDevice) -> Option<(u32, u32)> {
    // SAFETY: `physical` belongs to `instance`.
    let families = unsafe { instance.get_physical_device_queue_family_properties(physical) };
    let index = families.iter().position(|family| family.queue_flags.contains(vk::QueueFlags::COMPUTE))?;
    Some((u32::try_from(index).ok()?, families[index].timestamp_valid_bits))
}

/// Bytes of the largest device-local heap.
pub(crate) fn local_memory(instance: &ash::Instance, physical: vk::PhysicalDevice) -> u64 {
    // SAFETY: `physical` belongs to `instance`.
    let memory = unsafe { instance.get_physical_device_memory_properties(physical) };
    let heaps = memory.memory_heaps_as_slice().iter();
    heaps.filter(|heap| heap.flags.contains(vk::MemoryHeapFlags::DEVICE_LOCAL)).map(|heap| heap.size).max().unwrap_or(0)
}
