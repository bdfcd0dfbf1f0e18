//! The photon pass: emits and traces photons, and records where they meet diffuse surfaces,
//! `shaders/passes/photon.comp`.

use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

use bytemuck::Zeroable;
use goblet_host::{Device, Frame, Pass};

use super::path::{PathKernels, PathPass, Start};
use crate::gpu_scene::alias;
use crate::kernels::PhotonPush;
use crate::render::counters::Counted;
use crate::render::error::RenderError;
use crate::render::progress::Progress;
use crate::render::radius::RadiusSchedule;
use crate::render::sequence::IterationIndex;
use crate::render::stage::Stage;

/// The number of photons that a batch has recorded.
#[derive(Clone, Copy, Debug)]
pub struct Recorded {
    /// On diffuse surfaces.
    pub diffuse: u32,
    /// On rough surfaces.
    pub rough: u32,
}

/// The stream of the first round of a pilot. A round of iterations has fewer streams.
const PILOT_STREAM: u32 = 1 << 31;

/// The photon pass.
pub struct PhotonPass {
    pass: PathPass<PhotonPush>,
    kernels: Arc<PathKernels>,
}

impl PhotonPass {
    pub(super) fn new(pass: Pass<PhotonPush>, kernels: Arc<PathKernels>) -> Self {
        Self { pass: PathPass::new(pass, kernels.workgroup_size), kernels }
    }

    pub(super) fn warm_up(&self, frame: &mut Frame<'_>) {
        frame.dispatch(self.pass.plain(), Zeroable::zeroed(), 1);
    }

    /// Traces the photons of a batch, by their numbers in the iteration. Returns the number of
    /// records, or `None` if the record buffer has no room for them; then the schedule has
    /// smaller batches.
    ///
    /// # Errors
    /// The device fails, or the caller gives the iteration up.
    pub fn run(
        &mut self,
        on: Stage<'_>,
        index: IterationIndex,
        batch: Range<u64>,
        progress: &mut Progress,
    ) -> Result<Option<Recorded>, RenderError> {
        let count = batch.end - batch.start;
        let per_invocation = progress.schedule.per_invocation();
        let start = Instant::now();
        let resumable = || self.kernels.photon(on.device, on.buffers, true)?.finish();
        let invocations = count.div_ceil(per_invocation);
        let color_radius = color_radius(on, index, progress);
        let push = |start| PhotonPush { color_radius, ..push(on, index, &batch, per_invocation, start) };
        let counters = self.pass.run(on, invocations, &mut progress.schedule.paces.photon, resumable, push)?;
        if u64::from(counters.recorded.max(counters.recorded_rough)) > on.buffers.photons.len()
            && progress.schedule.overflowed()
        {
            return Ok(None);
        }
        progress.schedule.observe(count, start.elapsed());
        progress.tally.add(Counted::Photon, &counters);
        Ok(Some(Recorded { diffuse: counters.recorded, rough: counters.recorded_rough }))
    }

    /// Traces photons of a round of a pilot, whose records and numbers then are on the device. Returns the number of
    /// records, or `None` if the record buffer has no room for them. The records of a single path always fit. No
    /// iteration has the same photons.
    ///
    /// # Errors
    /// The device fails, or the caller gives the iteration up.
    pub fn run_pilot(
        &mut self,
        on: Stage<'_>,
        round: u32,
        batch: Range<u64>,
        progress: &mut Progress,
    ) -> Result<Option<u32>, RenderError> {
        let per_invocation = progress.schedule.per_invocation();
        let resumable = || self.kernels.photon(on.device, on.buffers, true)?.finish();
        let invocations = (batch.end - batch.start).div_ceil(per_invocation);
        let push = |start| PhotonPush {
            stream: PILOT_STREAM + round,
            is_pilot: 1,
            ..push_of_batch(on, &batch, per_invocation, start)
        };
        let counters = self.pass.run(on, invocations, &mut progress.schedule.paces.photon, resumable, push)?;
        Ok((u64::from(counters.recorded) <= on.buffers.photons.len()).then_some(counters.recorded))
    }

    /// Gives next-event estimation the chances of lights. The renderer has a guide.
    ///
    /// # Errors
    /// The device fails.
    pub fn choose_lights(&self, device: &Device, chances: &[f64]) -> goblet_host::Result<()> {
        device.write_texels(self.kernels.scene.bindings().direct_table, &alias::table_with_chances(chances))
    }

    /// Records the commands that trace all photons of an iteration in one dispatch.
    pub fn record(&self, on: Stage<'_>, index: IterationIndex, progress: &Progress, frame: &mut Frame<'_>) {
        let batch = 0..on.settings.wanted_photons();
        let per_invocation = progress.schedule.per_invocation();
        let color_radius = color_radius(on, index, progress);
        let push = PhotonPush { color_radius, ..push(on, index, &batch, per_invocation, Start::AT_FIRST) };
        frame.dispatch(self.pass.plain(), push, batch.end.div_ceil(per_invocation));
    }

    /// Whether the driver cannot follow all paths in one dispatch.
    pub fn is_resumable(&self) -> bool {
        self.pass.is_resumable()
    }
}

/// The radius within which the colors of wavelengths are averaged, in render units: that of most discs.
fn color_radius(on: Stage<'_>, index: IterationIndex, progress: &Progress) -> f32 {
    let first = progress.first_radius.map_or(0.0, |first| first.middle());
    (first * on.settings.color_shrink(index.iteration)) as f32
}

/// The push constants of a dispatch over a batch.
fn push(on: Stage<'_>, index: IterationIndex, batch: &Range<u64>, per_invocation: u64, start: Start) -> PhotonPush {
    // A disc that found many photons is smaller in the next iteration, in which a sequence
    // that spreads its points evenly has fewer for it: the image would get darker. So the
    // iterations that share visible points, and whose radii depend on earlier ones, have a
    // sequence each.
    let (stream, iterations_before) = match on.settings.radius_schedule {
        RadiusSchedule::Adaptive | RadiusSchedule::Data => (index.step, index.turn.into()),
        RadiusSchedule::Global => (0, index.iteration_of_half),
    };
    let before = on.settings.photons.wrapping_mul(iterations_before);
    PhotonPush {
        before_low: before as u32,
        before_high: (before >> 32) as u32,
        half_of_rounds: index.half,
        stream,
        ..push_of_batch(on, batch, per_invocation, start)
    }
}

/// The push constants of a dispatch over a batch of the first photons of a stream.
fn push_of_batch(
    on: Stage<'_>,
    batch: &Range<u64>,
    per_invocation: u64,
    Start { offset, resumed, spread }: Start,
) -> PhotonPush {
    PhotonPush {
        first: batch.start as u32,
        end: batch.end as u32,
        stride: (batch.end - batch.start).div_ceil(per_invocation) as u32,
        capacity: on.buffers.photons.len() as u32,
        offset,
        resumed,
        spread,
        ..Zeroable::zeroed()
    }
}
