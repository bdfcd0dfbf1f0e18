//! Commands that a device runs in order: transfers, barriers, submission.

use std::ops::Range;
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use ash::vk;

use crate::buffer::RawBuffer;
use crate::error::{Context, Error, Result};
use crate::image::{RawImage, WHOLE};
use crate::shared::DeviceShared;
use crate::timing::{MAX_TIMED, Timer};

/// The parts of a device that recordings use.
#[derive(Clone, Copy)]
pub(crate) struct Recorder<'a> {
    pub device: &'a Arc<DeviceShared>,
    pub timer: &'a Timer,
    /// Host memory for what a frame reads back.
    pub readback: &'a RawBuffer,
    /// Locked as long as there is a recording: it uses command pool, queue, timer and readback memory alone.
    pub recording: &'a Mutex<()>,
}

/// Bytes that one frame can read back.
pub(crate) const READBACK_BYTES: u64 = 4096;

/// Locks a mutex, also after a panic of another thread: what it guards has no state that a panic
/// could leave broken.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Commands that run in order. Each sees the writes of those before it.
pub(crate) struct Recording<'a> {
    pub recorder: Recorder<'a>,
    pub commands: vk::CommandBuffer,
    /// Signalled when the device has run the commands.
    fence: vk::Fence,
    /// The kernels that are dispatched, in order.
    pub passes: Vec<&'static str>,
    /// Dropped last, when the commands are freed.
    _lock: MutexGuard<'a, ()>,
}

impl<'a> Recorder<'a> {
    /// Begins an empty recording.
    pub fn begin(self) -> Result<Recording<'a>> {
        let lock = lock(self.recording);
        let vulkan = &self.device.raw;
        let allocate =
            vk::CommandBufferAllocateInfo::default().command_pool(self.device.command_pool).command_buffer_count(1);
        let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the recording frees what is allocated here; no other thread records.
        unsafe {
            let commands = vulkan.allocate_command_buffers(&allocate).context("vkAllocateCommandBuffers")?[0];
            let fence = vk::Fence::null();
            let mut recording = Recording { recorder: self, commands, fence, passes: Vec::new(), _lock: lock };
            recording.fence = vulkan.create_fence(&vk::FenceCreateInfo::default(), None).context("vkCreateFence")?;
            vulkan.begin_command_buffer(commands, &begin).context("vkBeginCommandBuffer")?;
            if self.timer.has(0) {
                vulkan.cmd_reset_query_pool(commands, self.timer.queries, 0, 2 * MAX_TIMED);
            }
            Ok(recording)
        }
    }
}

impl Recording<'_> {
    /// Copies bytes between buffers.
    pub fn copy(&mut self, from: &RawBuffer, from_offset: u64, to: &RawBuffer, to_offset: u64, bytes: u64) {
        if bytes == 0 {
            return;
        }
        let region = [vk::BufferCopy { src_offset: from_offset, dst_offset: to_offset, size: bytes }];
        // SAFETY: both ranges are inside their buffers, which outlive the run.
        unsafe { self.recorder.device.raw.cmd_copy_buffer(self.commands, from.handle, to.handle, &region) };
        self.barrier();
    }

    /// Fills a range of a buffer, whole words and inside it, with a word.
    pub fn fill(&mut self, buffer: &RawBuffer, range: Range<u64>, word: u32) {
        let bytes = range.end - range.start;
        if bytes == 0 {
            return;
        }
        // SAFETY: the range is inside the buffer, which outlives the run.
        unsafe { self.recorder.device.raw.cmd_fill_buffer(self.commands, buffer.handle, range.start, bytes, word) };
        self.barrier();
    }

    /// Fills all of an image with four words a texel, or the first of them.
    pub fn fill_image(&mut self, image: &RawImage, words: [u32; 4]) {
        let color = vk::ClearColorValue { uint32: words };
        self.transfer(image, vk::ImageLayout::TRANSFER_DST_OPTIMAL, |vulkan, commands, layout| {
            // SAFETY: the image outlives the run and is in this layout.
            unsafe { vulkan.cmd_clear_color_image(commands, image.image, layout, &color, &[WHOLE]) };
        });
    }

    /// Copies the first `bytes` bytes of a buffer to texels, from a row on.
    pub fn copy_to_rows(&mut self, from: &RawBuffer, to: &RawImage, first_row: u64, bytes: u64) {
        self.copy_to_regions(from, to, &to.regions(first_row, bytes));
    }

    /// Copies the first bytes of a buffer to regions of an image.
    pub fn copy_to_regions(&mut self, from: &RawBuffer, to: &RawImage, regions: &[vk::BufferImageCopy]) {
        self.transfer(to, vk::ImageLayout::TRANSFER_DST_OPTIMAL, |vulkan, commands, layout| {
            // SAFETY: both places are inside what they are in, which outlives the run.
            unsafe { vulkan.cmd_copy_buffer_to_image(commands, from.handle, to.image, layout, regions) };
        });
    }

    /// Copies `bytes` bytes of texels, from a row on, to the start of a buffer.
    pub fn copy_from_rows(&mut self, from: &RawImage, first_row: u64, to: &RawBuffer, bytes: u64) {
        self.copy_from_regions(from, to, &from.regions(first_row, bytes));
    }

    /// Copies regions of an image to the first bytes of a buffer.
    pub fn copy_from_regions(&mut self, from: &RawImage, to: &RawBuffer, regions: &[vk::BufferImageCopy]) {
        self.transfer(from, vk::ImageLayout::TRANSFER_SRC_OPTIMAL, |vulkan, commands, layout| {
            // SAFETY: both places are inside what they are in, which outlives the run.
            unsafe { vulkan.cmd_copy_image_to_buffer(commands, from.image, layout, to.handle, regions) };
        });
        self.barrier();
    }

    /// Records a transfer for which texels need another layout.
    fn transfer(
        &mut self,
        texels: &RawImage,
        layout: vk::ImageLayout,
        record: impl FnOnce(&ash::Device, vk::CommandBuffer, vk::ImageLayout),
    ) {
        self.transition(texels, vk::ImageLayout::GENERAL, layout);
        record(&self.recorder.device.raw, self.commands, layout);
        self.transition(texels, layout, vk::ImageLayout::GENERAL);
    }

    /// Changes the layout of texels, between the commands before and those after.
    pub fn transition(&mut self, texels: &RawImage, from: vk::ImageLayout, to: vk::ImageLayout) {
        let access = vk::AccessFlags::MEMORY_READ | vk::AccessFlags::MEMORY_WRITE;
        let barrier = [vk::ImageMemoryBarrier::default()
            .src_access_mask(access)
            .dst_access_mask(access)
            .old_layout(from)
            .new_layout(to)
            .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .image(texels.image)
            .subresource_range(WHOLE)];
        let (all, none) = (vk::PipelineStageFlags::ALL_COMMANDS, vk::DependencyFlags::empty());
        let vulkan = &self.recorder.device.raw;
        // SAFETY: the frame is being recorded; the image is in the layout `from`.
        unsafe { vulkan.cmd_pipeline_barrier(self.commands, all, all, none, &[], &[], &barrier) };
    }

    /// Submits the commands and waits until the device has run them.
    ///
    /// # Errors
    /// The device is lost (the error names the pass that it ran), or out of memory.
    pub fn submit(self) -> Result<()> {
        self.run()
    }

    /// Does the same, and keeps the lock: what the commands have read back is still there. Call it once.
    ///
    /// # Errors
    /// As [`Recording::submit`].
    pub fn run(&self) -> Result<()> {
        let shared = self.recorder.device;
        let commands = [self.commands];
        let submit = [vk::SubmitInfo::default().command_buffers(&commands)];
        shared.submissions.fetch_add(1, Ordering::Relaxed);
        // SAFETY: the recording is complete and submitted once.
        let finished = unsafe {
            shared.raw.end_command_buffer(self.commands).context("vkEndCommandBuffer")?;
            shared
                .raw
                .queue_submit(shared.queue, &submit, self.fence)
                .and_then(|()| shared.raw.wait_for_fences(&[self.fence], true, u64::MAX))
        };
        match finished {
            Ok(()) => self.recorder.timer.collect(&self.passes),
            Err(vk::Result::ERROR_DEVICE_LOST) => Err(Error::DeviceLost { pass: self.running() }),
            Err(result) => Err(Error::Vulkan { call: "running a frame", result }),
        }
    }

    /// Records a global memory barrier. Finer barriers are not measurably faster here.
    pub fn barrier(&self) {
        let stages = vk::PipelineStageFlags::COMPUTE_SHADER | vk::PipelineStageFlags::TRANSFER;
        let access = vk::AccessFlags::SHADER_READ
            | vk::AccessFlags::SHADER_WRITE
            | vk::AccessFlags::TRANSFER_READ
            | vk::AccessFlags::TRANSFER_WRITE;
        let commands_and_host = vk::AccessFlags::INDIRECT_COMMAND_READ | vk::AccessFlags::HOST_READ;
        let barrier =
            [vk::MemoryBarrier::default().src_access_mask(access).dst_access_mask(access | commands_and_host)];
        let (commands, none) = (self.commands, vk::DependencyFlags::empty());
        let after = stages | vk::PipelineStageFlags::DRAW_INDIRECT | vk::PipelineStageFlags::HOST;
        // SAFETY: the frame is being recorded.
        unsafe { self.recorder.device.raw.cmd_pipeline_barrier(commands, stages, after, none, &barrier, &[], &[]) };
    }

    /// Returns the name of the pass that the device began last.
    fn running(&self) -> String {
        let mut number = [0; 4];
        self.recorder.timer.marker.map_read(&mut number);
        let name = self.passes.get(u32::from_ne_bytes(number) as usize);
        name.map_or_else(|| "transfer".to_owned(), |name| (*name).to_owned())
    }
}

impl Drop for Recording<'_> {
    fn drop(&mut self) {
        let shared = self.recorder.device;
        // SAFETY: `submit` has waited for the device; a recording that was not submitted, or whose
        // device is lost, has nothing in flight; destroying a null handle does nothing.
        unsafe {
            shared.raw.destroy_fence(self.fence, None);
            shared.raw.free_command_buffers(shared.command_pool, &[self.commands]);
        }
    }
}
