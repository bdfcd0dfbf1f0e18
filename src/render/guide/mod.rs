//! Guided emission: more photons are emitted with the positions and directions that light visible surfaces.
//!
//! A photon is emitted by six random numbers, which choose its light, position and direction. Before the first iteration,
//! a pilot traces a few photons. The host reads their random numbers and their records, computes what each photon brings
//! to a sample of the visible points, and learns a density of the random numbers: [`tree`]. The kernels then warp the
//! random numbers of all photons by this density and divide the photons' flux by it (`shaders/include/light/guide.glsl`),
//! so that the expected image stays the same. A share of the photons is emitted as without a guide, so that every path
//! stays possible and no weight exceeds 1 over this share.
//!
//! The density depends on the scene, the options and the seed only. Every shard, and a resumed render, learns the same
//! density again from the visible points of the first round.
//!
//! Sources: Grittmann and others, "Efficient caustic rendering with lightweight photon mapping", 2018; Müller and others,
//! "Practical path guiding for efficient light-transport simulation", 2017; Rath and others, "Variance-aware path
//! guiding", 2020, for densities by squares; "EARS", 2022, for costs.

mod cell;
mod direct;
pub mod guidance;
pub mod lights;
mod pilot;
mod seen;
pub mod tree;

use std::time::Instant;

use guidance::{Finding, Guidance, Guide};
use pilot::Pilot;
use seen::Seen;
use tree::{Caution, MOST_LEAVES, Tree};

use crate::render::activity::Activity;
use crate::render::error::RenderError;
use crate::render::passes::PhotonPass;
use crate::render::progress::Progress;
use crate::render::sequence::IterationIndex;
use crate::render::stage::Stage;

/// The number of rounds of a pilot. Each round emits photons by the density that the rounds before it have learned. If
/// fewer than [`HITS_TO_END`] photons have brought light to visible surfaces, there are up to [`MOST_ROUNDS`].
const ROUNDS: u32 = 12;
const MOST_ROUNDS: u32 = 24;
const HITS_TO_END: usize = 512;
/// How much the density of a render relies on the pilot.
const CAUTION: Caution = Caution { uniform_share: 0.2, spread: 0.05, penalty: 3.0, leaves: MOST_LEAVES };
/// How much a round of the pilot relies on the rounds before it: one photon is enough to look for others around it.
const CAUTION_OF_PILOT: Caution = Caution { uniform_share: 0.2, spread: 0.05, penalty: 0.2, leaves: 256 };
/// The round after which `auto` ends a pilot that shows no gain. By then, [`HITS_TO_DOUBT`] photons must have brought
/// light to visible surfaces: the gain is estimated from two halves of these photons, and few photons estimate it badly.
const ROUND_OF_DOUBT: u32 = 4;
const HITS_TO_DOUBT: usize = 1024;
/// The least gain with which `auto` uses the guide: the product of variance and time without the guide, divided by the
/// product with it. It is above 1, because the gain is that of photons only and eye paths add to error and time.
const WORTHWHILE: f64 = 1.5;

/// Returns whether an iteration has to learn the guide first.
pub fn is_missing(on: Stage<'_>, progress: &Progress) -> bool {
    on.settings.guidance != Guidance::Off && on.settings.wanted_photons() > 0 && progress.guide.is_none()
}

/// Runs the pilot and learns the guide. The device must have the visible points of the first round.
///
/// # Errors
/// The device fails, or the caller gives the iteration up.
pub fn learn(photon: &mut PhotonPass, on: Stage<'_>, progress: &mut Progress) -> Result<(), RenderError> {
    let start = Instant::now();
    // A pilot does not know what its photons bring to rough surfaces.
    let is_blind = on.settings.guidance == Guidance::Auto && !on.buffers.rough_points.is_empty();
    let guide = match (on.settings.photons_matter, is_blind) {
        (false, _) => Guide::none(Finding::PhotonsDoNotMatter),
        (true, true) => Guide::none(Finding::RoughSurfaces),
        (true, false) => {
            on.observer.tell(Activity::Pilot);
            let found = find(photon, on, progress)?;
            on.observer.tell(Activity::Rendering);
            found
        }
    };
    on.device.write_texels(&on.buffers.guide_nodes, &guide.tree.nodes)?;
    progress.guide = Some(Guide { time: start.elapsed(), ..guide });
    Ok(())
}

/// Gives next-event estimation the probabilities of lights that the guide has learned. In the first round, they are
/// proportional to power, because the guide is learned from the visible points of this round.
///
/// # Errors
/// The device fails.
pub fn choose_lights(
    photon: &PhotonPass,
    on: Stage<'_>,
    index: IterationIndex,
    progress: &mut Progress,
) -> Result<(), RenderError> {
    if !are_lights_chosen(on, index, progress) {
        let learned = progress.guide.as_ref().and_then(|guide| guide.direct.as_ref());
        let chances = learned.filter(|_| !progress.lights_are_learned).unwrap_or(&on.lights.direct);
        photon.choose_lights(on.device, chances)?;
        progress.lights_are_learned = !progress.lights_are_learned;
    }
    Ok(())
}

/// Returns whether next-event estimation has the probabilities of lights that a round needs.
pub fn are_lights_chosen(on: Stage<'_>, index: IterationIndex, progress: &Progress) -> bool {
    let has_learned = progress.guide.as_ref().is_some_and(|guide| guide.direct.is_some());
    progress.lights_are_learned == (has_learned && index.round != on.settings.first_index().round)
}

fn find(photon: &mut PhotonPass, on: Stage<'_>, progress: &mut Progress) -> Result<Guide, RenderError> {
    let Some(first) = progress.first_radius else { return Ok(Guide::none(Finding::NothingSeen)) };
    let seen = Seen::on_device(on, first)?;
    if seen.is_empty() {
        return Ok(Guide::none(Finding::NothingSeen));
    }
    let power = on.settings.mean_power;
    let is_worthwhile = |gain| on.settings.guidance == Guidance::On || gain > WORTHWHILE;
    let mut pilot = Pilot::new();
    let mut samples = Vec::new();
    for round in 0..MOST_ROUNDS {
        if round >= ROUNDS && pilot.hits() >= HITS_TO_END {
            break;
        }
        let tree = Tree::learn(&samples, CAUTION_OF_PILOT);
        on.device.write_texels(&on.buffers.guide_nodes, &tree.nodes)?;
        pilot.follow(photon, on, round, progress)?;
        pilot.see(&seen, tree, on.lights);
        samples = pilot.samples(&seen, power);
        let is_in_doubt = round == ROUND_OF_DOUBT && pilot.hits() >= HITS_TO_DOUBT;
        if is_in_doubt && !is_worthwhile(tree::gain_of_halves(&samples, CAUTION)) {
            return Ok(pilot.found(&seen, &samples, None, on));
        }
    }
    let gain = tree::gain_of_halves(&samples, CAUTION);
    let guide = is_worthwhile(gain).then(|| (Tree::learn(&samples, CAUTION), gain));
    Ok(pilot.found(&seen, &samples, guide, on))
}
