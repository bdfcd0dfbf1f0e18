//! A recording of passes that run in order.

use std::sync::MutexGuard;

use ash::vk;
use bytemuck::Pod;

use crate::buffer::RawBuffer;
use crate::device::lock;
use crate::error::{Context, Error, Result};
use crate::texels::{RawTexels, WHOLE};
use crate::timing::MAX_TIMED;
use crate::{Buffer, Device, Pass, Texels};

/// Every device has at least this many workgroups along one axis.
const MAX_GROUPS: u64 = 65535;

/// Commands in order, each seeing the writes of those before it.
pub struct Frame<'a> {
    device: &'a Device,
    commands: vk::CommandBuffer,
    fence: vk::Fence,
    passes: Vec<&'static str>,
    /// Dropped last, when the commands are freed: command pool, queue and timer are this frame's.
    _recording: MutexGuard<'a, ()>,
}

impl<'a> Frame<'a> {
    pub(crate) fn new(device: &'a Device) -> Result<Self> {
        let recording = lock(&device.recording);
        let vulkan = &device.shared.raw;
        let allocate =
            vk::CommandBufferAllocateInfo::default().command_pool(device.shared.command_pool).command_buffer_count(1);
        let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the frame frees what it allocates here; no other thread has a frame of this device.
        unsafe {
            let commands = vulkan.allocate_command_buffers(&allocate).context("vkAllocateCommandBuffers")?[0];
            let mut frame =
                Self { device, commands, fence: vk::Fence::null(), passes: Vec::new(), _recording: recording };
            frame.fence = vulkan.create_fence(&vk::FenceCreateInfo::default(), None).context("vkCreateFence")?;
            vulkan.begin_command_buffer(commands, &begin).context("vkBeginCommandBuffer")?;
            if device.timer.has(0) {
                vulkan.cmd_reset_query_pool(commands, device.timer.queries, 0, 2 * MAX_TIMED);
            }
            Ok(frame)
        }
    }

    /// Runs at least `invocations` invocations of a pass; kernels find their number by
    /// `invocation_index()` and return when it is past the end.
    pub fn dispatch<Push: Pod>(&mut self, pass: &Pass<Push>, push: Push, invocations: u64) {
        let groups = invocations.div_ceil(u64::from(pass.workgroup_size)).max(1);
        let rows = groups.div_ceil(MAX_GROUPS);
        let columns = groups.div_ceil(rows);
        let number = self.passes.len();
        let vulkan = &self.device.shared.raw;
        let timer = &self.device.timer;
        let (commands, stage) = (self.commands, vk::PipelineStageFlags::COMPUTE_SHADER);
        // SAFETY: the pass and its buffers outlive the frame's run, which the borrow of
        // the device and the wait in `run` ensure; sizes are within the device's limits.
        unsafe {
            vulkan.cmd_fill_buffer(commands, timer.marker.handle, 0, 4, number as u32);
            vulkan.cmd_bind_pipeline(commands, vk::PipelineBindPoint::COMPUTE, pass.pipeline);
            if !pass.sets.is_empty() {
                let point = vk::PipelineBindPoint::COMPUTE;
                vulkan.cmd_bind_descriptor_sets(commands, point, pass.layout, 0, &pass.sets, &[]);
            }
            if size_of::<Push>() > 0 {
                let bytes = bytemuck::bytes_of(&push);
                vulkan.cmd_push_constants(commands, pass.layout, vk::ShaderStageFlags::COMPUTE, 0, bytes);
            }
            if timer.has(number) {
                vulkan.cmd_write_timestamp(commands, stage, timer.queries, 2 * number as u32);
            }
            vulkan.cmd_dispatch(commands, columns as u32, rows as u32, 1);
            if timer.has(number) {
                vulkan.cmd_write_timestamp(commands, stage, timer.queries, 2 * number as u32 + 1);
            }
        }
        self.passes.push(pass.name);
        self.barrier();
    }

    /// Fills a buffer with zeros.
    pub fn clear<T: Pod>(&mut self, buffer: &Buffer<T>) {
        self.clear_first(buffer, buffer.len());
    }

    /// Fills the first elements of a buffer with zeros. Panics if it has not so many.
    pub fn clear_first<T: Pod>(&mut self, buffer: &Buffer<T>, count: u64) {
        assert!(count <= buffer.len(), "buffer {} is too short", buffer.name());
        let bytes = count * size_of::<T>() as u64;
        if bytes == 0 {
            return;
        }
        // SAFETY: the buffer outlives the run and is long enough; elements are whole words.
        unsafe {
            self.device.shared.raw.cmd_fill_buffer(self.commands, buffer.raw().handle, 0, bytes, 0);
        }
        self.barrier();
    }

    /// Copies bytes between buffers.
    pub(crate) fn copy(&mut self, from: &RawBuffer, from_offset: u64, to: &RawBuffer, to_offset: u64, bytes: u64) {
        if bytes == 0 {
            return;
        }
        let region = [vk::BufferCopy { src_offset: from_offset, dst_offset: to_offset, size: bytes }];
        // SAFETY: both ranges are inside their buffers, which outlive the run.
        unsafe { self.device.shared.raw.cmd_copy_buffer(self.commands, from.handle, to.handle, &region) };
        self.barrier();
    }

    /// Fills a buffer and its guard zone with a word.
    pub(crate) fn fill(&mut self, buffer: &RawBuffer, word: u32) {
        // SAFETY: the buffer outlives the run.
        unsafe {
            self.device.shared.raw.cmd_fill_buffer(self.commands, buffer.handle, 0, vk::WHOLE_SIZE, word);
        }
        self.barrier();
    }

    /// Fills texels with zeros.
    pub fn clear_texels<T: Pod>(&mut self, texels: &Texels<T>) {
        self.fill_texels(texels.raw(), [0; 4]);
        if let Some(guards) = &self.device.guards {
            guards.renew(self, texels.raw());
        }
    }

    /// Fills all of an image.
    pub(crate) fn fill_texels(&mut self, texels: &RawTexels, words: [u32; 4]) {
        let color = vk::ClearColorValue { uint32: words };
        self.transfer(texels, vk::ImageLayout::TRANSFER_DST_OPTIMAL, |vulkan, commands, layout| {
            // SAFETY: the image outlives the run and is in this layout.
            unsafe { vulkan.cmd_clear_color_image(commands, texels.image, layout, &color, &[WHOLE]) };
        });
    }

    /// Copies the first bytes of a buffer to texels from a row on.
    pub(crate) fn copy_to_rows(&mut self, from: &RawBuffer, to: &RawTexels, first_row: u64, bytes: u64) {
        self.copy_to_regions(from, to, &to.regions(first_row, bytes));
    }

    /// Copies the first bytes of a buffer to regions of an image.
    pub(crate) fn copy_to_regions(&mut self, from: &RawBuffer, to: &RawTexels, regions: &[vk::BufferImageCopy]) {
        self.transfer(to, vk::ImageLayout::TRANSFER_DST_OPTIMAL, |vulkan, commands, layout| {
            // SAFETY: both places are inside what they are in, which outlives the run.
            unsafe { vulkan.cmd_copy_buffer_to_image(commands, from.handle, to.image, layout, regions) };
        });
    }

    /// Copies texels from a row on to the first bytes of a buffer.
    pub(crate) fn copy_from_rows(&mut self, from: &RawTexels, first_row: u64, to: &RawBuffer, bytes: u64) {
        self.copy_from_regions(from, to, &from.regions(first_row, bytes));
    }

    /// Copies regions of an image to the first bytes of a buffer.
    pub(crate) fn copy_from_regions(&mut self, from: &RawTexels, to: &RawBuffer, regions: &[vk::BufferImageCopy]) {
        self.transfer(from, vk::ImageLayout::TRANSFER_SRC_OPTIMAL, |vulkan, commands, layout| {
            // SAFETY: both places are inside what they are in, which outlives the run.
            unsafe { vulkan.cmd_copy_image_to_buffer(commands, from.image, layout, to.handle, regions) };
        });
        self.barrier();
    }

    /// Records a transfer that needs texels in another layout.
    fn transfer(
        &mut self,
        texels: &RawTexels,
        layout: vk::ImageLayout,
        record: impl FnOnce(&ash::Device, vk::CommandBuffer, vk::ImageLayout),
    ) {
        self.transition(texels, vk::ImageLayout::GENERAL, layout);
        record(&self.device.shared.raw, self.commands, layout);
        self.transition(texels, layout, vk::ImageLayout::GENERAL);
    }

    /// Gives texels another layout, after all commands before and before all after.
    pub(crate) fn transition(&mut self, texels: &RawTexels, from: vk::ImageLayout, to: vk::ImageLayout) {
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
        let vulkan = &self.device.shared.raw;
        // SAFETY: the frame is being recorded; the image is in the layout `from`.
        unsafe { vulkan.cmd_pipeline_barrier(self.commands, all, all, none, &[], &[], &barrier) };
    }

    /// Submits the recording and waits until the device has finished it.
    ///
    /// # Errors
    /// The device is lost (the error names the pass it ran), or out of memory.
    pub fn run(self) -> Result<()> {
        let device = self.device;
        let passes = if device.guards.is_some() { self.passes.clone() } else { Vec::new() };
        self.submit()?;
        match &device.guards {
            Some(guards) if !passes.is_empty() => guards.check(device, &passes),
            _ => Ok(()),
        }
    }

    /// The same without a look at guard zones.
    pub(crate) fn submit(self) -> Result<()> {
        let shared = &self.device.shared;
        let commands = [self.commands];
        let submit = [vk::SubmitInfo::default().command_buffers(&commands)];
        // SAFETY: the recording is complete and submitted once.
        let finished = unsafe {
            shared.raw.end_command_buffer(self.commands).context("vkEndCommandBuffer")?;
            shared
                .raw
                .queue_submit(shared.queue, &submit, self.fence)
                .and_then(|()| shared.raw.wait_for_fences(&[self.fence], true, u64::MAX))
        };
        match finished {
            Ok(()) => self.device.timer.collect(&self.passes),
            Err(vk::Result::ERROR_DEVICE_LOST) => Err(Error::DeviceLost { pass: self.running() }),
            Err(result) => Err(Error::Vulkan { call: "running a frame", result }),
        }
    }

    /// One global barrier: simple, and not measurably slower than finer ones here.
    fn barrier(&self) {
        let stages = vk::PipelineStageFlags::COMPUTE_SHADER | vk::PipelineStageFlags::TRANSFER;
        let access = vk::AccessFlags::SHADER_READ
            | vk::AccessFlags::SHADER_WRITE
            | vk::AccessFlags::TRANSFER_READ
            | vk::AccessFlags::TRANSFER_WRITE;
        let barrier =
            [vk::MemoryBarrier::default().src_access_mask(access).dst_access_mask(access | vk::AccessFlags::HOST_READ)];
        let (commands, none) = (self.commands, vk::DependencyFlags::empty());
        let after = stages | vk::PipelineStageFlags::HOST;
        // SAFETY: the frame is being recorded.
        unsafe { self.device.shared.raw.cmd_pipeline_barrier(commands, stages, after, none, &barrier, &[], &[]) };
    }

    /// The pass that the device began last.
    fn running(&self) -> String {
        let mut number = [0; 4];
        self.device.timer.marker.map_read(&mut number);
        let name = self.passes.get(u32::from_ne_bytes(number) as usize);
        name.map_or_else(|| "transfer".to_owned(), |name| (*name).to_owned())
    }
}

impl Drop for Frame<'_> {
    fn drop(&mut self) {
        let shared = &self.device.shared;
        // SAFETY: `run` has waited for the device; a frame that was not run, or whose
        // device is lost, has nothing in flight; destroying a null handle does nothing.
        unsafe {
            shared.raw.destroy_fence(self.fence, None);
            shared.raw.free_command_buffers(shared.command_pool, &[self.commands]);
        }
    }
}
