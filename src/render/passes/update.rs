//! The update pass: adds an iteration's image to the exact sums, and lets adaptive radii shrink,
//! `shaders/passes/update.comp`.

use bytemuck::Zeroable;
use goblet_host::{Device, Frame, Pass};

use super::layers::LayerPasses;
use crate::kernels::{Specialization, Update, UpdatePush};
use crate::render::buffers::Buffers;
use crate::render::counters::Counted;
use crate::render::error::RenderError;
use crate::render::options::Contribution;
use crate::render::progress::Progress;
use crate::render::radius::{RadiusSchedule, kept_of_sums};
use crate::render::sequence::IterationIndex;
use crate::render::stage::Stage;

/// The update pass.
pub struct UpdatePass(Pass<UpdatePush>);

impl UpdatePass {
    pub(super) fn new(
        device: &Device,
        buffers: &Buffers,
        specialization: &Specialization,
        workgroup_size: u32,
    ) -> goblet_host::Result<Self> {
        let Buffers { visible_radii2, visible_throughputs, visible_radiances, pixel_states, counters, .. } = buffers;
        let [sum_red, sum_green, sum_blue, sum_second] = &buffers.sums;
        let Buffers { flux_red, flux_green, flux_blue, flux_counts, .. } = buffers;
        let kernel = Update {
            visible_radii2,
            visible_throughputs,
            visible_radiances,
            pixel_states,
            sum_red,
            sum_green,
            sum_blue,
            sum_second,
            counters,
            flux_red,
            flux_green,
            flux_blue,
            flux_counts,
        };
        Ok(Self(device.pass(&kernel, specialization, workgroup_size)?))
    }

    pub(super) fn warm_up(&self, frame: &mut Frame<'_>) {
        frame.dispatch(&self.0, Zeroable::zeroed(), 1);
    }

    /// Adds the iteration to the image and to its layers.
    ///
    /// # Errors
    /// The device fails.
    pub fn run(
        &self,
        on: Stage<'_>,
        index: IterationIndex,
        layers: Option<&LayerPasses>,
        progress: &mut Progress,
    ) -> Result<(), RenderError> {
        let counters = on.run_counted(|frame| self.record(on, index, layers, progress, frame))?;
        progress.tally.add(Counted::Update, &counters);
        Ok(())
    }

    /// Records the commands that do so. The pass does nothing if the counters say that a pass before has not finished,
    /// or has recorded more photons than there is room for.
    pub fn record(
        &self,
        on: Stage<'_>,
        index: IterationIndex,
        layers: Option<&LayerPasses>,
        progress: &mut Progress,
        frame: &mut Frame<'_>,
    ) {
        let settings = on.settings;
        let alpha = match settings.radius_schedule {
            RadiusSchedule::Adaptive => settings.alpha,
            RadiusSchedule::Global | RadiusSchedule::Data => 1.0,
        };
        let rough_scale = (settings.flux_scale() / progress.rough_radii(settings, index).largest2()) as f32;
        let push = UpdatePush {
            luminance: settings.luminance().map(|weight| weight as f32),
            pixel_count: settings.pixels() as u32,
            alpha: alpha as f32,
            per_unit: (1.0 / settings.unit) as f32,
            flux_scale: settings.flux_scale() as f32,
            half_of_rounds: index.half,
            capacity: on.buffers.photons.len() as u32,
            rough_scale,
            kept: kept_of_sums(settings.step(index)),
            pad0: 0,
        };
        if settings.contribution == Contribution::Photons {
            frame.clear_texels(&on.buffers.visible_radiances);
        }
        if let Some(layers) = layers {
            layers.record_light(on, rough_scale, frame);
        }
        frame.dispatch(&self.0, push, settings.pixels());
        if let Some(layers) = layers {
            layers.record_sums(on, frame);
        }
    }
}
