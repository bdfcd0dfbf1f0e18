//! A device with one compute queue.

use std::ffi::CStr;
use std::ops::Range;
use std::path::Path;
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use ash::vk;
use bytemuck::Pod;

use crate::buffer::{Buffer, RawBuffer};
use crate::error::{Error, Result};
use crate::frame::Frame;
use crate::group::{Group, Layout};
use crate::guard::{GUARD_BYTES, Guards};
use crate::image::{GUARD_ROWS, RawImage};
use crate::instance::Instance;
use crate::kernel::{Compiling, Kernel, Pass};
use crate::physical::{self, ArrayKind, DeviceInfo, DeviceMemory, Requirements, compute_family};
use crate::recording::{READBACK_BYTES, Recorder, lock};
use crate::shared::DeviceShared;
use crate::texels::{Extent, Part, Storage, Texels};
use crate::timing::Timer;

/// Size of the staging buffer: the bytes of a transfer between host and device.
const STAGING_BYTES: u64 = 16 << 20;

/// An open device: makes buffers, passes and frames. Threads may share it: they wait for each other's
/// frames, since there is one queue, one command pool and one set of timestamps. A thread must not ask
/// for a frame, nor read or write an array, while it has another frame: it would wait for itself.
pub struct Device {
    pub(crate) shared: Arc<DeviceShared>,
    /// Locked during a transfer, before `recording` is.
    staging: Mutex<RawBuffer>,
    timer: Timer,
    /// Used as long as `recording` is locked.
    readback: RawBuffer,
    guards: Option<Guards>,
    /// Locked as long as there is a recording.
    recording: Mutex<()>,
}

impl Instance {
    /// Opens the device that `selector` names by its index or by a part of its name; without a
    /// selector, the first one that has what `requirements` ask for. In the folder `cache` the driver keeps
    /// what it has compiled; without it, it is left to the driver whether it keeps anything.
    ///
    /// # Errors
    /// There is no such device, or it lacks something of `requirements`.
    pub fn open(&self, selector: Option<&str>, requirements: &Requirements, cache: Option<&Path>) -> Result<Device> {
        let (physical, info) = self.choose(selector, requirements)?;
        let family = compute_family(&self.shared.raw, physical)
            .ok_or_else(|| Error::Unfit { device: info.name.clone(), reason: "it has no compute queue".into() })?;
        Device::with_family(self.clone(), physical, info, requirements.texels_per_row, family, &[], cache)
    }
}

impl Device {
    /// Opens a device as [`DeviceShared::open`] does.
    pub(crate) fn with_family(
        instance: Instance,
        physical: vk::PhysicalDevice,
        info: DeviceInfo,
        texels_per_row: u32,
        family: (u32, u32),
        extensions: &[&CStr],
        cache: Option<&Path>,
    ) -> Result<Self> {
        let shared = DeviceShared::open(instance, physical, info, texels_per_row, family, extensions, cache)?;
        let shared = Arc::new(shared);
        let staging = RawBuffer::host(&shared, "staging", STAGING_BYTES)?;
        let timer = Timer::new(&shared)?;
        let readback = RawBuffer::host(&shared, "readback", READBACK_BYTES)?;
        Ok(Self { shared, staging: Mutex::new(staging), timer, readback, guards: None, recording: Mutex::new(()) })
    }

    /// Returns what the list of devices says of this one.
    pub fn info(&self) -> &DeviceInfo {
        &self.shared.info
    }

    /// Returns the messages of the validation layer so far; empty without validation.
    pub fn validation_messages(&self) -> Vec<String> {
        self.shared.instance.validation_messages()
    }

    /// Gives every array that is made from now on a guard zone filled with `word`; the array itself is
    /// filled with it, too. For tests of kernels: each frame checks all guard zones.
    ///
    /// # Errors
    /// Out of memory.
    pub fn guard(&mut self, word: u32) -> Result<()> {
        self.guards = Some(Guards::new(&self.shared, word)?);
        Ok(())
    }

    /// Returns a message for each array past whose end a kernel has written, with the passes of the frame
    /// that has done it; empty without [`guard`](Self::guard).
    pub fn broken_guards(&self) -> Vec<String> {
        self.guards.as_ref().map(Guards::broken).unwrap_or_default()
    }

    /// Allocates a device-local buffer of `length` elements, with undefined contents. An empty one has memory
    /// for one element, since Vulkan binds no empty buffer.
    ///
    /// # Errors
    /// Too large for one binding, or out of device memory.
    pub fn buffer<T: Pod>(&self, name: &'static str, length: u64) -> Result<Buffer<T>> {
        let buffer = Buffer::new(&self.shared, name, length, self.guard_bytes())?;
        self.watch(buffer.raw(), [(name, buffer.raw().bytes - self.guard_bytes())].into_iter())?;
        Ok(buffer)
    }

    /// Returns the bytes of a guard zone in a buffer.
    fn guard_bytes(&self) -> u64 {
        self.guards.as_ref().map_or(0, |_| GUARD_BYTES)
    }

    /// Fills a new buffer with the pattern and watches the guard zones after the ends of arrays in it.
    fn watch(&self, buffer: &Arc<RawBuffer>, ends: impl Iterator<Item = (&'static str, u64)>) -> Result<()> {
        match &self.guards {
            None => Ok(()),
            Some(guards) => {
                let zones = ends.map(|(name, end)| (name, end..end + GUARD_BYTES));
                guards.watch_buffer(self.recorder(), buffer, zones)
            }
        }
    }

    /// Allocates a buffer that holds `data`.
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
        self.write_bytes(buffer.raw(), 0, bytemuck::cast_slice(data))
    }

    /// Writes bytes to a place in a buffer.
    fn write_bytes(&self, buffer: &RawBuffer, first: u64, bytes: &[u8]) -> Result<()> {
        let staging = lock(&self.staging);
        for (index, chunk) in bytes.chunks(STAGING_BYTES as usize).enumerate() {
            staging.map_write(chunk);
            let offset = first + index as u64 * STAGING_BYTES;
            let mut recording = self.recorder().begin()?;
            recording.copy(&staging, 0, buffer, offset, chunk.len() as u64);
            recording.submit()?;
        }
        Ok(())
    }

    /// Returns the contents of a buffer.
    ///
    /// # Errors
    /// The transfer fails.
    pub fn read<T: Pod>(&self, buffer: &Buffer<T>) -> Result<Vec<T>> {
        let mut data = vec![T::zeroed(); buffer.len() as usize];
        self.read_bytes(buffer.raw(), 0, bytemuck::cast_slice_mut(&mut data))?;
        Ok(data)
    }

    /// Reads bytes from a place in a buffer.
    fn read_bytes(&self, buffer: &RawBuffer, first: u64, bytes: &mut [u8]) -> Result<()> {
        let staging = lock(&self.staging);
        for (index, chunk) in bytes.chunks_mut(STAGING_BYTES as usize).enumerate() {
            let offset = first + index as u64 * STAGING_BYTES;
            let mut recording = self.recorder().begin()?;
            recording.copy(buffer, offset, &staging, 0, chunk.len() as u64);
            recording.submit()?;
            staging.map_read(chunk);
        }
        Ok(())
    }

    /// Allocates texels for `length` elements, with undefined contents. Empty ones have memory for one
    /// element.
    ///
    /// # Errors
    /// Too large for one image or binding, or out of device memory.
    pub fn texels<T: Pod>(&self, name: &'static str, length: u64) -> Result<Texels<T>> {
        let extent = Extent::of::<T>(name, length);
        let storage = match self.shared.info.arrays {
            ArrayKind::Images => self.image(&extent)?,
            ArrayKind::Buffers => {
                let bytes = extent.bytes();
                let buffer = Arc::new(RawBuffer::bound(&self.shared, name, bytes, self.guard_bytes())?);
                self.watch(&buffer, [(name, bytes)].into_iter())?;
                Storage::Part(Part { buffer, first: 0, bytes, member: None })
            }
        };
        Ok(Texels::new(&extent, storage))
    }

    /// Allocates a group of texels, with undefined contents: kernels bind them together. Their elements are
    /// whole texels of four words.
    ///
    /// # Errors
    /// As [`Device::texels`]; where they are in buffers, all of a group are in one.
    pub fn group(&self, name: &'static str, extents: &[Extent]) -> Result<Group> {
        if self.shared.info.arrays == ArrayKind::Images {
            let images: Result<Vec<Storage>> = extents.iter().map(|extent| self.image(extent)).collect();
            return Ok(Group::new(extents.iter().copied().zip(images?)));
        }
        let layout = Layout::new(extents, self.guard_bytes());
        let buffer = Arc::new(RawBuffer::bound(&self.shared, name, layout.bytes, self.guard_bytes())?);
        let named = || extents.iter().zip(&layout.places);
        self.watch(&buffer, named().map(|(extent, place)| (extent.name, place.end)))?;
        self.write_bytes(&buffer, 0, bytemuck::cast_slice(&layout.table))?;
        let part = |member: usize, place: &Range<u64>| Part {
            buffer: Arc::clone(&buffer),
            first: place.start,
            bytes: place.end - place.start,
            member: Some(member as u32),
        };
        let parts = named().enumerate().map(|(i, (extent, place))| (*extent, Storage::Part(part(i, place))));
        Ok(Group::new(parts))
    }

    /// Allocates an image for texels.
    fn image(&self, extent: &Extent) -> Result<Storage> {
        let image = extent.image(&self.shared, self.guards.as_ref().map_or(0, |_| GUARD_ROWS))?;
        let mut recording = self.recorder().begin()?;
        recording.transition(&image, vk::ImageLayout::UNDEFINED, vk::ImageLayout::GENERAL);
        recording.submit()?;
        if let Some(guards) = &self.guards {
            guards.watch_image(self.recorder(), &image)?;
        }
        Ok(Storage::Image(image))
    }

    /// Allocates texels that hold `data`.
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
        let bytes: &[u8] = bytemuck::cast_slice(data);
        let image = match texels.storage() {
            Storage::Part(part) => return self.write_bytes(&part.buffer, part.first, bytes),
            Storage::Image(image) => image,
        };
        let rows = staged_rows(image);
        let staging = lock(&self.staging);
        for (index, chunk) in bytes.chunks((rows * image.row_bytes()) as usize).enumerate() {
            staging.map_write(chunk);
            let mut recording = self.recorder().begin()?;
            recording.copy_to_rows(&staging, image, index as u64 * rows, chunk.len() as u64);
            recording.submit()?;
        }
        Ok(())
    }

    /// Returns the contents of texels.
    ///
    /// # Errors
    /// The transfer fails.
    pub fn read_texels<T: Pod>(&self, texels: &Texels<T>) -> Result<Vec<T>> {
        self.read_first_texels(texels, texels.len())
    }

    /// Returns the first `count` elements of texels. Panics if there are fewer.
    ///
    /// # Errors
    /// The transfer fails.
    pub fn read_first_texels<T: Pod>(&self, texels: &Texels<T>, count: u64) -> Result<Vec<T>> {
        assert!(count <= texels.len(), "texels {} are too short", texels.name());
        let mut data = vec![T::zeroed(); count as usize];
        let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut data);
        let image = match texels.storage() {
            Storage::Part(part) => {
                self.read_bytes(&part.buffer, part.first, bytes)?;
                return Ok(data);
            }
            Storage::Image(image) => image,
        };
        let rows = staged_rows(image);
        let staging = lock(&self.staging);
        for (index, chunk) in bytes.chunks_mut((rows * image.row_bytes()) as usize).enumerate() {
            let mut recording = self.recorder().begin()?;
            recording.copy_from_rows(image, index as u64 * rows, &staging, chunk.len() as u64);
            recording.submit()?;
            staging.map_read(chunk);
        }
        Ok(data)
    }

    /// Compiles a kernel for a workgroup size, unless this device has done so before, and binds its arrays,
    /// which the pass keeps alive.
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

    /// Starts to compile a kernel as [`Device::pass`] does, without waiting for the compiler.
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

    /// Begins an empty recording.
    ///
    /// # Errors
    /// Out of memory.
    pub fn frame(&self) -> Result<Frame<'_>> {
        Frame::new(self.recorder(), self.guards.as_ref())
    }

    fn recorder(&self) -> Recorder<'_> {
        let Self { shared, timer, readback, recording, .. } = self;
        Recorder { device: shared, timer, readback, recording }
    }

    /// Returns how often the device was given commands since it was opened. The host has waited for each.
    pub fn submissions(&self) -> u64 {
        self.shared.submissions.load(Ordering::Relaxed)
    }

    /// Returns the device time by kernel since the device was opened; empty if the device has no
    /// timestamps.
    pub fn pass_times(&self) -> Vec<(&'static str, Duration)> {
        self.timer.totals()
    }

    /// Asks the device how much memory it has and how much of that is free now.
    pub fn memory(&self) -> DeviceMemory {
        let memory = physical::memory(&self.shared.instance.shared.raw, self.shared.physical, self.shared.info.kind);
        // Without VK_EXT_memory_budget, a GPU's driver does not count what this process holds.
        let unheld = memory.total_bytes.saturating_sub(self.allocated_bytes());
        DeviceMemory { free_bytes: memory.free_bytes.min(unheld), ..memory }
    }

    /// Returns the bytes of device memory that buffers and texels hold now.
    pub fn allocated_bytes(&self) -> u64 {
        self.shared.allocated.load(Ordering::Relaxed)
    }
}

/// Returns the rows of texels that fit into the staging buffer, at least one.
fn staged_rows(image: &RawImage) -> u64 {
    (STAGING_BYTES / image.row_bytes()).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_device_tells_its_memory_and_counts_what_is_allocated() {
        let requirements = Requirements { texels_per_row: 1024, ..Requirements::default() };
        let device = Instance::new(false).unwrap().open(None, &requirements, None).unwrap();
        let DeviceMemory { total_bytes, free_bytes } = device.memory();
        assert!(0 < free_bytes && free_bytes <= total_bytes, "{free_bytes} of {total_bytes}");
        let before = device.allocated_bytes();
        let buffer = device.buffer::<u32>("kept", 1 << 10).unwrap();
        assert!(device.allocated_bytes() >= before + 4096);
        drop(buffer);
        assert_eq!(device.allocated_bytes(), before);
    }

    #[test]
    fn a_group_that_is_larger_than_a_binding_is_refused_with_both_numbers() {
        let requirements = Requirements { arrays: Some(ArrayKind::Buffers), ..Requirements::default() };
        let device = Instance::new(false).unwrap().open(None, &requirements, None).unwrap();
        let limit = device.info().max_buffer_bytes;
        let half = Extent::of::<[u32; 4]>("half", limit / 32 + 1);
        let Err(Error::BufferTooLarge { buffer, bytes, limit: told }) = device.group("two halves", &[half; 2]) else {
            panic!("two halves fit");
        };
        assert_eq!((buffer.as_str(), bytes, told), ("two halves", 16 + 32 * (limit / 32 + 1), limit));
    }
}
