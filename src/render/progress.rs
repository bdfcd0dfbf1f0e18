//! The progress of a render: the state on the host that changes from iteration to iteration.

use crate::render::counters::Tally;
use crate::render::error::RenderError;
use crate::render::guide::guidance::Guide;
use crate::render::pacing::Schedule;
use crate::render::radius::{FirstRadius, GlobalShrink, RoughRadii};
use crate::render::sequence::IterationIndex;
use crate::render::settings::Settings;
use crate::render::stage::Stage;
use crate::render::unsampled::response;

/// The progress of a render.
#[derive(Clone, Debug)]
pub struct Progress {
    /// The number of finished iterations.
    pub done: u32,
    /// The number of finished iterations in each half: [`IterationIndex::half`].
    pub halves: [u64; 2],
    /// The initial radius of visible points; `None` until it is known.
    pub first_radius: Option<FirstRadius>,
    /// The [`response`] of the visible points of the first round of all shards; `None` until it is measured.
    pub response: Option<f64>,
    /// The density by which photons begin; `None` until a pilot has found it, or if none is wanted.
    pub guide: Option<Guide>,
    /// Whether next-event estimation on the device has the chances of lights that the guide has learned.
    pub lights_are_learned: bool,
    /// The round whose visible points are on the device.
    pub seen: Option<u32>,
    /// The factor by which the global schedule shrinks squared radii.
    pub shrink: GlobalShrink,
    /// The sizes of the next batches and dispatches.
    pub schedule: Schedule,
    /// Counts of how paths ended in the finished iterations.
    pub tally: Tally,
}

impl Progress {
    /// Measures the visible points of the first round of all shards, which must be on the device. Sets the
    /// initial radius to one that follows the footprints of pixels, unless it is known, and sets the
    /// response.
    ///
    /// # Errors
    /// The device fails.
    pub fn measure(&mut self, on: Stage<'_>) -> Result<(), RenderError> {
        let Settings { pixel_width, is_parallel, radius_per_length, .. } = *on.settings;
        let throughputs = on.device.read_first_texels(&on.buffers.visible_throughputs, on.settings.pixels())?;
        let rough_count = if on.buffers.rough_points.is_empty() { 0 } else { on.settings.pixels() };
        let rough_points = on.device.read_first_texels(&on.buffers.rough_points, rough_count)?;
        let lengths = throughputs.iter().map(|throughput| throughput[3]);
        let lengths = lengths.chain(rough_points.iter().map(|point| point.path_length));
        let radius = self.first_radius.get_or_insert_with(|| FirstRadius::from_footprints(radius_per_length, lengths));
        let (luminance, radius) = (on.settings.luminance(), radius.least.into());
        self.response = Some(response(throughputs.into_iter(), luminance, pixel_width, is_parallel, radius));
        Ok(())
    }

    /// Returns the radii of rough points in an iteration.
    pub fn rough_radii(&mut self, settings: &Settings, index: IterationIndex) -> RoughRadii {
        // A long round has its own rough points.
        let step = if settings.sequence.round_length > 1 { u64::from(index.step) } else { index.iteration };
        // The eye pass has set a radius, unless there is no point to give it to.
        RoughRadii::new(self.first_radius.unwrap_or_else(|| FirstRadius::constant(1.0)), self.shrink.at(step))
    }

    /// Counts an iteration as finished.
    pub fn finish(&mut self, index: IterationIndex) {
        self.done += 1;
        self.halves[index.half as usize] += 1;
    }
}
