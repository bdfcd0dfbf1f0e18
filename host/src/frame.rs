//! A recording of passes that run in order.

use ash::vk;
use bytemuck::Pod;

use crate::buffer::Buffer;
use crate::error::Result;
use crate::guard::Guards;
use crate::kernel::Pass;
use crate::recording::{Recorder, Recording};
use crate::texels::{Part, Storage, Texels};

/// Workgroups along one axis that every device can dispatch.
const MAX_GROUPS: u64 = 65535;

/// Passes and clears that run in order. Each sees the writes of those before it.
pub struct Frame<'a> {
    recording: Recording<'a>,
    guards: Option<&'a Guards>,
}

impl<'a> Frame<'a> {
    pub(crate) fn new(recorder: Recorder<'a>, guards: Option<&'a Guards>) -> Result<Self> {
        Ok(Self { recording: recorder.begin()?, guards })
    }

    /// Runs a pass with at least `invocations` invocations. Kernels get their index by `invocation_index()`,
    /// and return if it is past the end.
    pub fn dispatch<Push: Pod>(&mut self, pass: &Pass<Push>, push: Push, invocations: u64) {
        let groups = invocations.div_ceil(u64::from(pass.workgroup_size)).max(1);
        let rows = groups.div_ceil(MAX_GROUPS);
        let columns = groups.div_ceil(rows);
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
            vulkan.cmd_dispatch(commands, columns as u32, rows as u32, 1);
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

    /// Submits the recording and waits until the device has finished it.
    ///
    /// # Errors
    /// The device is lost (the error names the pass that it ran), or out of memory.
    pub fn run(self) -> Result<()> {
        let Some(guards) = self.guards else { return self.recording.submit() };
        let (recorder, passes) = (self.recording.recorder, self.recording.passes.clone());
        self.recording.submit()?;
        if passes.is_empty() { Ok(()) } else { guards.check(recorder, &passes) }
    }
}
