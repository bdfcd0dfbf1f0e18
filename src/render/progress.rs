//! How far a render is.

use crate::render::counters::Tally;
use crate::render::error::RenderError;
use crate::render::pacing::Schedule;
use crate::render::radius::{FirstRadius, GlobalShrink};
use crate::render::sequence::Place;
use crate::render::settings::Settings;
use crate::render::stage::Stage;
use crate::render::unsampled::response;

/// How far a render is.
#[derive(Clone, Debug)]
pub struct Progress {
    /// Iterations finished.
    pub done: u32,
    /// The same, by half: [`Place::half`].
    pub halves: [u64; 2],
    /// The radius that visible points start with, once it is known.
    pub first_radius: Option<FirstRadius>,
    /// Of the first of all rounds, once it is known: [`response`].
    pub response: Option<f64>,
    /// The round whose visible points are on the device.
    pub seen: Option<u32>,
    /// How much the global schedule has shrunk squared radii.
    pub shrink: GlobalShrink,
    /// How the next iteration's photons are cut into batches.
    pub schedule: Schedule,
    /// What happened so far.
    pub tally: Tally,
}

impl Progress {
    /// Learns from the visible points of the first of all rounds, which are on the device: the
    /// radius that follows the footprints of pixels, and how bright photons are there.
    pub fn measure(&mut self, on: Stage<'_>) -> Result<(), RenderError> {
        let Settings { pixel_width, is_parallel, radius_per_length, .. } = *on.settings;
        let throughputs = on.device.read_first_texels(&on.buffers.visible_throughputs, on.settings.pixels())?;
        let lengths = throughputs.iter().map(|throughput| throughput[3]);
        let radius = self.first_radius.get_or_insert_with(|| FirstRadius::from_footprints(radius_per_length, lengths));
        self.response = Some(response(throughputs.into_iter(), pixel_width, is_parallel, radius.least.into()));
        Ok(())
    }

    /// Counts an iteration as finished.
    pub fn finish(&mut self, place: Place) {
        self.done += 1;
        self.halves[place.half as usize] += 1;
    }
}
