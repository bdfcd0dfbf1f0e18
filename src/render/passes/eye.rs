//! The eye pass: paths from each pixel to its visible point, `shaders/passes/eye.comp`.

use std::sync::Arc;

use bytemuck::Zeroable;
use goblet_host::{Frame, Pass};

use super::path::{PathKernels, PathPass, Start};
use crate::kernels::EyePush;
use crate::render::buffers::invocations_by_tile;
use crate::render::counters::{Counted, Tally};
use crate::render::error::RenderError;
use crate::render::pacing::Schedule;
use crate::render::progress::Progress;
use crate::render::sequence::IterationIndex;
use crate::render::stage::Stage;

/// The eye pass.
pub struct EyePass {
    pass: PathPass<EyePush>,
    kernels: Arc<PathKernels>,
}

impl EyePass {
    pub(super) fn new(pass: Pass<EyePush>, kernels: Arc<PathKernels>) -> Self {
        Self { pass: PathPass::new(pass, kernels.workgroup_size), kernels }
    }

    pub(super) fn warm_up(&self, frame: &mut Frame<'_>) {
        frame.dispatch(self.pass.plain(), Zeroable::zeroed(), 1);
    }

    /// Finds the visible points of a round. Where no option gives the radius that visible points
    /// start with, it follows from the first of all rounds, so that every shard has the same.
    ///
    /// # Errors
    /// The device fails, or the caller gives the iteration up.
    pub fn run(&mut self, on: Stage<'_>, index: IterationIndex, progress: &mut Progress) -> Result<(), RenderError> {
        let first = on.settings.first_index();
        if progress.first_radius.is_none() && index.round != first.round {
            self.measure(on, progress)?;
        }
        let seen = self.trace(on, index, &mut progress.schedule)?;
        if progress.response.is_none() && index.round == first.round {
            progress.measure(on)?;
        }
        if index.step == 0 {
            // Else a checkpoint already holds these counts.
            progress.tally.merge(&seen);
        }
        progress.seen = Some(index.round);
        Ok(())
    }

    /// Traces the eye paths of the first of all rounds, whose visible points then are on the
    /// device, and measures them.
    ///
    /// # Errors
    /// As [`EyePass::run`].
    pub fn measure(&mut self, on: Stage<'_>, progress: &mut Progress) -> Result<(), RenderError> {
        progress.seen = None;
        self.trace(on, on.settings.first_index(), &mut progress.schedule)?;
        progress.measure(on)
    }

    /// Traces all eye paths of a round.
    fn trace(&mut self, on: Stage<'_>, index: IterationIndex, schedule: &mut Schedule) -> Result<Tally, RenderError> {
        let invocations = invocations_by_tile(on.settings.resolution);
        let resumable = || self.kernels.eye(on.device, on.buffers, true)?.finish();
        let push = |start| Self::push(on, index, start);
        let counters = self.pass.run(on, invocations, &mut schedule.paces.eye, resumable, push)?;
        let mut tally = Tally::default();
        tally.add(Counted::Eye, &counters);
        Ok(tally)
    }

    /// Records the commands that trace all eye paths of a round in one dispatch.
    pub fn record(&self, on: Stage<'_>, index: IterationIndex, frame: &mut Frame<'_>) {
        let invocations = invocations_by_tile(on.settings.resolution);
        frame.dispatch(self.pass.plain(), Self::push(on, index, Start::AT_FIRST), invocations);
    }

    /// Whether the driver cannot follow all paths in one dispatch.
    pub fn is_resumable(&self) -> bool {
        self.pass.is_resumable()
    }

    fn push(on: Stage<'_>, index: IterationIndex, Start { offset, resumed, spread }: Start) -> EyePush {
        let IterationIndex { turn, half: half_of_rounds, iteration, step, .. } = index;
        let radius = on.settings.radius_per_length * on.settings.color_shrink(iteration - u64::from(step));
        let [color_radius, color_radius_per_length] =
            if on.settings.is_parallel { [radius, 0.0] } else { [0.0, radius] };
        EyePush {
            turn,
            half_of_rounds,
            paths: on.settings.eye_paths,
            offset,
            resumed,
            spread,
            color_radius: color_radius as f32,
            color_radius_per_length: color_radius_per_length as f32,
        }
    }
}
