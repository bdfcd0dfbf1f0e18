//! A recording of passes that run in order.

use ash::vk;
use bytemuck::Pod;

use crate::buffer::Buffer;
use crate::error::Result;
use crate::guard::Guards;
use crate::kernel::Pass;
use crate::recording::{READBACK_BYTES, Recorder, Recording};
use crate::texels::{Part, Storage, Texels};

/// Workgroups along one axis that every device can dispatch.
const MAX_GROUPS: u64 = 65535;

/// Passes and clears that run in order. Each sees the writes of those before it.
pub struct Frame<'a> {
    recording: Recording<'a>,
    guards: Option<&'a Guards>,
    /// Bytes that were saved.
    saved: u64,
}

impl<'a> Frame<'a> {
    pub(crate) fn new(recorder: Recorder<'a>, guards: Option<&'a Guards>) -> Result<Self> {
        Ok(Self { recording: recorder.begin()?, guards, saved: 0 })
    }

    /// Runs a pass with at least `invocations` invocations. Kernels get their index by `invocation_index()`,
    /// and return if it is past the end.
    pub fn dispatch<Push: Pod>(&mut self, pass: &Pass<Push>, push: Push, invocations: u64) {
        let groups = invocations.div_ceil(u64::from(pass.workgroup_size)).max(1);
        let rows = groups.div_ceil(MAX_GROUPS);
        let columns = groups.div_ceil(rows);
        // SAFETY: the numbers are within the limits of every device.
        self.record(pass, push, |vulkan, commands| unsafe {
            vulkan.cmd_dispatch(commands, columns as u32, rows as u32, 1);
        });
    }

    /// Runs a pass with as many workgroups as three words say, `offset` bytes behind the start of a buffer, when the
    /// device gets there. A kernel has written them: at most [`MAX_GROUPS`] each. Panics if they are not in the buffer.
    pub fn dispatch_indirect<Push: Pod, T: Pod>(
        &mut self,
        pass: &Pass<Push>,
        push: Push,
        sizes: &Buffer<T>,
        offset: usize,
    ) {
        let end = offset as u64 + size_of::<vk::DispatchIndirectCommand>() as u64;
        assert!(offset.is_multiple_of(4) && end <= sizes.raw().bytes, "{offset} in buffer {}", sizes.name());
        let handle = sizes.raw().handle;
        // SAFETY: the words are inside the buffer, which outlives the run.
        self.record(pass, push, |vulkan, commands| unsafe {
            vulkan.cmd_dispatch_indirect(commands, handle, offset as u64);
        });
    }

    /// Records a pass, which `dispatch` dispatches.
    fn record<Push: Pod>(
        &mut self,
        pass: &Pass<Push>,
        push: Push,
        dispatch: impl FnOnce(&ash::Device, vk::CommandBuffer),
    ) {
        let number = self.recording.passes.len();
        let vulkan = &self.recording.recorder.device.raw;
        let timer = &self.recording.recorder.timer;
        let (commands, stage) = (self.recording.commands, vk::PipelineStageFlags::COMPUTE_SHADER);
        // SAFETY: the pass and its buffers outlive the frame's run, which the borrow of
        // the device and the wait in `run` ensure; sizes are within the device's limits.
        unsafe {
            vulkan.cmd_fill_buffer(commands, timer.marker.handle, 0, 4, number as u32);
            vulkan.cmd_bind_pipeline(commands, vk::PipelineBindPoint::COMPUTE, pass.pipeline());
            if !pass.sets.is_empty() {
                let point = vk::PipelineBindPoint::COMPUTE;
                vulkan.cmd_bind_descriptor_sets(commands, point, pass.layout.pipeline, 0, &pass.sets, &[]);
            }
            if size_of::<Push>() > 0 {
                let bytes = bytemuck::bytes_of(&push);
                vulkan.cmd_push_constants(commands, pass.layout.pipeline, vk::ShaderStageFlags::COMPUTE, 0, bytes);
            }
            if timer.has(number) {
                vulkan.cmd_write_timestamp(commands, stage, timer.queries, 2 * number as u32);
            }
            dispatch(vulkan, commands);
            if timer.has(number) {
                vulkan.cmd_write_timestamp(commands, stage, timer.queries, 2 * number as u32 + 1);
            }
        }
        self.recording.passes.push(pass.name);
        self.recording.barrier();
    }

    /// Fills a buffer with zeros.
    pub fn clear<T: Pod>(&mut self, buffer: &Buffer<T>) {
        self.clear_first(buffer, buffer.len());
    }

    /// Fills the first `count` elements of a buffer with zeros. Panics if it has fewer.
    pub fn clear_first<T: Pod>(&mut self, buffer: &Buffer<T>, count: u64) {
        assert!(count <= buffer.len(), "buffer {} is too short", buffer.name());
        self.recording.fill(buffer.raw(), 0..count * size_of::<T>() as u64, 0);
    }

    /// Fills texels with zeros.
    pub fn clear_texels<T: Pod>(&mut self, texels: &Texels<T>) {
        match texels.storage() {
            Storage::Part(Part { buffer, first, bytes, .. }) => self.recording.fill(buffer, *first..first + bytes, 0),
            Storage::Image(image) => {
                self.recording.fill_image(image, [0; 4]);
                if let Some(guards) = self.guards {
                    guards.renew(&mut self.recording, image);
                }
            }
        }
    }

    /// Copies the elements of a buffer, as the commands so far have left them, to where [`Frame::run_saved`] returns
    /// them. Panics if a frame saves more than a few thousand bytes.
    pub fn save<T: Pod>(&mut self, buffer: &Buffer<T>) {
        let bytes = buffer.len() * size_of::<T>() as u64;
        assert!(self.saved + bytes <= READBACK_BYTES, "a frame saves too much: {}", buffer.name());
        let readback = self.recording.recorder.readback;
        self.recording.copy(buffer.raw(), 0, readback, self.saved, bytes);
        self.saved += bytes;
    }

    /// Submits the recording and waits until the device has finished it.
    ///
    /// # Errors
    /// The device is lost (the error names the pass that it ran), or out of memory.
    pub fn run(self) -> Result<()> {
        self.run_saved::<u8>().map(drop)
    }

    /// Does the same, and returns the elements that it has saved, in order. All must be of type `T`.
    ///
    /// # Errors
    /// As [`Frame::run`].
    pub fn run_saved<T: Pod>(self) -> Result<Vec<T>> {
        let Self { recording, guards, saved } = self;
        recording.run()?;
        let mut elements = vec![T::zeroed(); saved as usize / size_of::<T>()];
        let (recorder, passes) = (recording.recorder, recording.passes.clone());
        recorder.readback.map_read(bytemuck::cast_slice_mut(&mut elements));
        drop(recording);
        if let Some(guards) = guards.filter(|_| !passes.is_empty()) {
            guards.check(recorder, &passes)?;
        }
        Ok(elements)
    }
}
