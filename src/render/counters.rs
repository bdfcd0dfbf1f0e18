//! Counts of how photon paths and eye paths ended.

use serde::{Deserialize, Serialize};

use crate::kernels::Counters;

/// Counts over any number of iterations. Each emitted photon path ends exactly once: deposited + absorbed +
/// escaped + truncated + lost in glass + dropped = emitted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Tally {
    /// Photon paths that were emitted.
    pub emitted: u64,
    /// Photons that were recorded on diffuse surfaces, or on rough ones; a path may record several.
    pub recorded: u64,
    /// Photon paths that were absorbed at a surface that records photons.
    pub deposited: u64,
    /// Photon paths that were absorbed at a specular surface.
    pub absorbed: u64,
    /// Photon paths that left the scene.
    pub escaped: u64,
    /// Photon paths that reached the maximum depth, or that the driver could not follow up to this depth.
    pub truncated: u64,
    /// The photon paths among `truncated`, and the eye paths, that the driver could not follow: the driver
    /// limits the loops of a kernel, and one segment of such a path needs more rounds.
    #[serde(default)]
    pub cut: ByPass,
    /// Photon and eye paths that did not leave a dielectric.
    pub lost_in_glass: u64,
    /// The eye paths among `lost_in_glass`.
    pub eye_lost_in_glass: u64,
    /// Photon and eye paths that met an opaque surface while in a dielectric: 0 unless an object stands in
    /// glass or water. In a closed room, paths that missed the exit from a dielectric end this way.
    pub immersed: u64,
    /// Paths that were dropped because a value was not finite, and pixels that lost an iteration for this
    /// reason.
    pub non_finite: ByPass,
    /// Sums of photons, and terms of pixels in an iteration, that were too large for their integers.
    pub saturated: ByPass,
}

/// Counts by the pass of an iteration that counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ByPass {
    /// Eye paths, counted by the eye pass.
    pub eye: u64,
    /// Photon paths, counted by the photon pass.
    pub photon: u64,
    /// Sums of photons, counted by the pass that adds photons to visible points.
    pub gathering: u64,
    /// Pixels, counted by the pass that adds an iteration to the image.
    pub update: u64,
}

/// A pass that counts.
#[derive(Clone, Copy, Debug)]
pub enum Counted {
    Eye,
    Photon,
    Gathering,
    Update,
}

impl ByPass {
    fn of(pass: Counted, count: u32) -> Self {
        let mut counts = Self::default();
        let place = match pass {
            Counted::Eye => &mut counts.eye,
            Counted::Photon => &mut counts.photon,
            Counted::Gathering => &mut counts.gathering,
            Counted::Update => &mut counts.update,
        };
        *place = count.into();
        counts
    }

    fn merge(&mut self, other: &Self) {
        self.eye = self.eye.saturating_add(other.eye);
        self.photon = self.photon.saturating_add(other.photon);
        self.gathering = self.gathering.saturating_add(other.gathering);
        self.update = self.update.saturating_add(other.update);
    }

    /// Returns the counts that are not 0, with the names of their passes.
    pub fn found(&self) -> impl Iterator<Item = (&'static str, u64)> {
        let Self { eye, photon, gathering, update } = *self;
        let counts = [("eye", eye), ("photon", photon), ("gathering", gathering), ("update", update)];
        counts.into_iter().filter(|(_, count)| *count > 0)
    }
}

/// Returns what was counted between two states of the counters that nothing has cleared in between.
pub(crate) fn since(before: &Counters, after: &Counters) -> Counters {
    let [before, after]: [&[u32]; 2] =
        [before, after].map(|counters| bytemuck::cast_slice(std::slice::from_ref(counters)));
    let counts: Vec<u32> = after.iter().zip(before).map(|(after, before)| after.wrapping_sub(*before)).collect();
    bytemuck::pod_read_unaligned(bytemuck::cast_slice(&counts))
}

impl Tally {
    /// Adds the counters of the device after a pass.
    pub(crate) fn add(&mut self, pass: Counted, counters: &Counters) {
        self.merge(&Self {
            emitted: counters.emitted.into(),
            recorded: u64::from(counters.recorded) + u64::from(counters.recorded_rough),
            deposited: counters.deposited.into(),
            absorbed: counters.absorbed.into(),
            escaped: counters.escaped.into(),
            truncated: counters.truncated.into(),
            cut: ByPass::of(pass, counters.cut),
            lost_in_glass: u64::from(counters.lost_in_glass) + u64::from(counters.eye_lost_in_glass),
            eye_lost_in_glass: counters.eye_lost_in_glass.into(),
            immersed: counters.immersed.into(),
            non_finite: ByPass::of(pass, counters.non_finite),
            saturated: ByPass::of(pass, counters.saturated),
        });
    }

    /// Adds other counts. The sums saturate, because counts from a file may have any value.
    pub fn merge(&mut self, other: &Self) {
        let add = |count: &mut u64, more: u64| *count = count.saturating_add(more);
        add(&mut self.emitted, other.emitted);
        add(&mut self.recorded, other.recorded);
        add(&mut self.deposited, other.deposited);
        add(&mut self.absorbed, other.absorbed);
        add(&mut self.escaped, other.escaped);
        add(&mut self.truncated, other.truncated);
        self.cut.merge(&other.cut);
        add(&mut self.lost_in_glass, other.lost_in_glass);
        add(&mut self.eye_lost_in_glass, other.eye_lost_in_glass);
        add(&mut self.immersed, other.immersed);
        self.non_finite.merge(&other.non_finite);
        self.saturated.merge(&other.saturated);
    }
}
