//! The radius pass: each visible point's radius in an iteration, `shaders/passes/radius.comp`.

use bytemuck::Zeroable;
use goblet_host::{Device, Frame, Pass};

use crate::kernels::{Radius, RadiusPush, Specialization};
use crate::render::buffers::Buffers;
use crate::render::error::RenderError;
use crate::render::progress::Progress;
use crate::render::radius::{FirstRadius, RadiusSchedule};
use crate::render::sequence::IterationIndex;
use crate::render::stage::Stage;

/// The radius pass.
pub struct RadiusPass(Pass<RadiusPush>);

impl RadiusPass {
    pub(super) fn new(
        device: &Device,
        buffers: &Buffers,
        specialization: &Specialization,
        workgroup_size: u32,
    ) -> goblet_host::Result<Self> {
        let Buffers { visible_radii2, visible_throughputs, pixel_states, max_radius2, .. } = buffers;
        let kernel = Radius { visible_radii2, visible_throughputs, pixel_states, max_radius2 };
        Ok(Self(device.pass(&kernel, specialization, workgroup_size)?))
    }

    pub(super) fn warm_up(&self, frame: &mut Frame<'_>) {
        frame.dispatch(&self.0, Zeroable::zeroed(), 1);
    }

    /// Gives visible points their radius for this iteration.
    ///
    /// # Errors
    /// The device fails.
    pub fn run(&self, on: Stage<'_>, index: IterationIndex, progress: &mut Progress) -> Result<(), RenderError> {
        let mut frame = on.device.frame()?;
        self.record(on, index, progress, &mut frame);
        Ok(frame.run()?)
    }

    /// Records the commands that do so.
    pub fn record(&self, on: Stage<'_>, index: IterationIndex, progress: &mut Progress, frame: &mut Frame<'_>) {
        let Stage { buffers, settings, .. } = on;
        // The eye pass has set one, unless there is no visible point to give it to.
        let first_radius = progress.first_radius.unwrap_or_else(|| FirstRadius::constant(1.0));
        let rounds_are_long = settings.sequence.round_length > 1;
        let step = settings.step(index);
        let shrink = match settings.radius_schedule {
            RadiusSchedule::Adaptive => 1.0,
            RadiusSchedule::Global | RadiusSchedule::Data => progress.shrink.at(step),
        };
        // A long round keeps statistics of its own visible points; rounds of one iteration share
        // the pixels' statistics.
        let begins = progress.done == 0 || (rounds_are_long && index.step == 0);
        let push = first_radius.push(settings.resolution, shrink, step, begins);
        frame.clear(&buffers.max_radius2);
        frame.dispatch(&self.0, push, settings.pixels());
    }
}
