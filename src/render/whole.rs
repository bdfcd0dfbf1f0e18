//! An iteration in one submission: the passes of `iteration.rs`, without pauses in which the device waits for the
//! host. Counts that later passes need stay on the device. The host reads all counts at the end.

use bytemuck::Zeroable;

use crate::kernels::Counters;
use crate::render::counters::{Counted, Tally, since};
use crate::render::error::RenderError;
use crate::render::guide;
use crate::render::passes::{LayerPasses, Passes};
use crate::render::progress::Progress;
use crate::render::sequence::IterationIndex;
use crate::render::stage::Stage;

/// Runs the next iteration in one submission, if that is wanted and possible. Returns whether it is finished; if not,
/// it has left no trace.
///
/// # Errors
/// The device fails, or the caller gives the iteration up.
pub fn run(passes: &Passes, on: Stage<'_>, progress: &mut Progress) -> Result<bool, RenderError> {
    let index = on.settings.sequence.index(progress.done);
    if !is_possible(passes, on, index, progress) {
        return Ok(false);
    }
    on.may_go_on()?;
    let (counted, saved) = submit(passes, on, index, progress)?;
    let last = saved.last().expect("every iteration counts");
    let overflows = u64::from(last.recorded.max(last.recorded_rough)) > on.buffers.photons.len();
    if overflows || last.interrupted > 0 || last.unfinished > 0 {
        begin_again(on, progress, overflows)?;
        return Ok(false);
    }
    let mut tally = Tally::default();
    let mut before = Counters::zeroed();
    for (pass, counters) in counted.into_iter().zip(saved) {
        // In a long round, a checkpoint already holds the counts of eye paths.
        if !matches!(pass, Counted::Eye) || index.step == 0 {
            tally.add(pass, &since(&before, &counters));
        }
        before = counters;
    }
    progress.tally.merge(&tally);
    progress.seen = Some(index.round);
    progress.finish(index);
    Ok(true)
}

/// Whether one submission can hold the next iteration. A tree takes the host to build, the first visible points are
/// measured before there are radii, and the host learns the guide.
fn is_possible(passes: &Passes, on: Stage<'_>, index: IterationIndex, progress: &Progress) -> bool {
    let is_first = progress.response.is_none() && index.round == on.settings.first_index().round;
    progress.schedule.is_whole(on.settings.wanted_photons())
        && progress.first_radius.is_some()
        && !is_first
        && !guide::is_missing(on, progress)
        && guide::are_lights_chosen(on, index, progress)
        && passes.lookup.grid().is_some()
        && !passes.eye.is_resumable()
        && !passes.photon.is_resumable()
        && !passes.layers.as_ref().is_some_and(LayerPasses::is_resumable)
}

/// Runs all passes. Returns those that count, and the counters after each of them, which no pass clears.
fn submit(
    passes: &Passes,
    on: Stage<'_>,
    index: IterationIndex,
    progress: &mut Progress,
) -> Result<(Vec<Counted>, Vec<Counters>), RenderError> {
    let Passes { eye, radius, photon, lookup, rough, update, layers } = passes;
    let counters = &on.buffers.counters;
    let mut counted = Vec::new();
    let mut frame = on.device.frame()?;
    frame.clear(counters);
    if let Some(layers) = layers {
        layers.record_clear(&mut frame);
    }
    if progress.seen != Some(index.round) {
        eye.record(on, index, &mut frame);
        frame.save(counters);
        counted.push(Counted::Eye);
        if let Some(layers) = layers {
            layers.record_surfaces(on, index, &mut frame);
        }
    }
    radius.record(on, index, progress, &mut frame);
    if let Some(grid) = lookup.grid().filter(|_| on.settings.wanted_photons() > 0) {
        photon.record(on, index, progress, &mut frame);
        frame.save(counters);
        counted.push(Counted::Photon);
        grid.record_build(on, on.buffers.photons.len(), &mut frame);
        if let Some(rough) = rough {
            let radii = progress.rough_radii(on.settings, index);
            rough.record_build(on, on.buffers.photons.len(), &radii, &mut frame);
            rough.record_gather(on, &radii, &mut frame);
        }
        grid.record_gather(on, &mut frame);
        frame.save(counters);
        counted.push(Counted::Gathering);
    }
    update.record(on, index, layers.as_ref(), progress, &mut frame);
    frame.save(counters);
    counted.push(Counted::Update);
    Ok((counted, frame.run_saved()?))
}

/// Clears what an unfinished iteration has left. The update pass has added nothing to the image.
fn begin_again(on: Stage<'_>, progress: &mut Progress, overflows: bool) -> Result<(), RenderError> {
    if overflows {
        progress.schedule.overflowed();
    }
    progress.schedule.pause_whole();
    progress.seen = None;
    let mut frame = on.device.frame()?;
    on.buffers.clear_flux(&mut frame);
    Ok(frame.run()?)
}
