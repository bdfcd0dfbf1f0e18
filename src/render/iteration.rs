//! One iteration of progressive photon mapping (Hachisuka and others 2008, Hachisuka and
//! Jensen 2009, Knaus and Zwicker 2011): the passes, in the order in which the device runs them.
//! A pass has the name of its kernel in `shaders/passes/`.

use std::time::Instant;

use crate::render::error::RenderError;
use crate::render::guide;
use crate::render::passes::Passes;
use crate::render::progress::Progress;
use crate::render::stage::Stage;
use crate::render::whole;

/// Runs the next iteration.
///
/// # Errors
/// The device fails, the driver cannot finish a pass, or the caller cancels the iteration.
pub fn run(passes: &mut Passes, on: Stage<'_>, progress: &mut Progress) -> Result<(), RenderError> {
    let start = Instant::now();
    if !whole::run(passes, on, progress)? {
        in_pieces(passes, on, progress)?;
    }
    progress.schedule.observe_iteration(start.elapsed());
    Ok(())
}

/// Runs the next iteration pass by pass. The host reads the counters of each pass and chooses the sizes of dispatches.
fn in_pieces(passes: &mut Passes, on: Stage<'_>, progress: &mut Progress) -> Result<(), RenderError> {
    let Passes { eye, radius, photon, lookup, rough, update, layers } = passes;
    let index = on.settings.sequence.index(progress.done);
    if guide::is_missing(on, progress) && index.round != on.settings.first_index().round {
        // The guide is learned from the visible points of the first round, in every shard and in a resumed render too.
        eye.measure(on, progress)?;
        guide::learn(photon, on, progress)?;
    }

    // Eye paths run from each pixel to its visible point. The iterations of a round share them.
    let is_new_round = progress.seen != Some(index.round);
    if is_new_round {
        guide::choose_lights(photon, on, index, progress)?;
        eye.run(on, index, progress)?;
        if let Some(layers) = layers {
            layers.meet_surfaces(on, index, progress)?; // surface_layers, if a layer needs the first surface
        }
    }

    // A pilot learns with which positions and directions photons light the visible surfaces.
    if guide::is_missing(on, progress) {
        guide::learn(photon, on, progress)?;
    }

    // Each visible point gets its radius for this iteration.
    radius.run(on, index, progress)?;
    lookup.index_points(on, is_new_round)?; // tree_fill; nothing for a grid

    // Photons run in batches, whose records fit in the record buffer.
    if let Some(layers) = layers {
        layers.clear_caustics(on)?;
    }
    let photons = on.settings.wanted_photons();
    let mut first = 0;
    while first < photons {
        let end = progress.schedule.end(first, photons);
        // Emit and trace photons. Record each hit of a diffuse surface, and each hit of a rough surface by light that
        // no eye path can find.
        let Some(recorded) = photon.run(on, index, first..end, progress)? else {
            continue; // The records did not fit: the schedule now has smaller batches.
        };
        // Sort the records into cells. Then each visible point sums the photons within its radius.
        lookup.index_photons(on, recorded.diffuse)?; // grid_count, grid_reserve, grid_fill; nothing for a tree
        let radii = progress.rough_radii(on.settings, index);
        if let Some(rough) = rough {
            rough.build(on, recorded.rough, &radii)?; // the same passes for the records on rough surfaces
        }
        lookup.gather(on, recorded.diffuse, progress)?; // gather_grid or gather_tree
        if let Some(rough) = rough {
            rough.gather(on, &radii, progress)?; // gather_rough
        }
        first = end;
    }

    // Add the iteration's image to the mean, and shrink the radii.
    update.run(on, index, layers.as_ref(), progress)?; // light_layers, update, layer_sums
    progress.finish(index);
    Ok(())
}
