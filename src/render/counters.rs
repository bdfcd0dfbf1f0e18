//! What happened to photons and eye paths.

use serde::{Deserialize, Serialize};

use crate::kernels::Counters;

/// Counts over any number of iterations. Each emitted photon path ended exactly once:
/// deposited + absorbed + escaped + truncated + lost in glass + dropped = emitted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Tally {
    /// Photon paths begun.
    pub emitted: u64,
    /// Photons stored on diffuse surfaces; a path may store several.
    pub recorded: u64,
    /// Paths absorbed at a surface that stores photons.
    pub deposited: u64,
    /// Paths absorbed at a specular surface.
    pub absorbed: u64,
    /// Paths that left the scene.
    pub escaped: u64,
    /// Paths that reached the maximum depth, or that the driver cannot follow to it.
    pub truncated: u64,
    /// Photon paths among those, and eye paths, that the driver cannot follow: it limits the
    /// loops of a kernel, and one segment of theirs needs more.
    #[serde(default)]
    pub cut: ByPass,
    /// Photon and eye paths that found no way out of a dielectric.
    pub lost_in_glass: u64,
    /// The eye paths among them.
    pub eye_lost_in_glass: u64,
    /// Photon and eye paths that met an opaque surface while in a dielectric: 0 unless
    /// something stands in glass or water. In a closed room, this is where lost ones end.
    pub immersed: u64,
    /// Paths dropped because a value was not finite, and pixels that lost an iteration so.
    pub non_finite: ByPass,
    /// Sums of photons, and pixels' terms of an iteration, that did not fit.
    pub saturated: ByPass,
}

/// Counts by the pass of an iteration that found them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ByPass {
    /// Eye paths.
    pub eye: u64,
    /// Photon paths.
    pub photon: u64,
    /// Photons that are added to visible points.
    pub gathering: u64,
    /// Pixels, as an iteration is added to the image.
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

    /// The counts that are not 0, with the names of their passes.
    pub fn found(&self) -> impl Iterator<Item = (&'static str, u64)> {
        let Self { eye, photon, gathering, update } = *self;
        let counts = [("eye", eye), ("photon", photon), ("gathering", gathering), ("update", update)];
        counts.into_iter().filter(|(_, count)| *count > 0)
    }
}

impl Tally {
    /// Adds what the device counted in a pass.
    pub(crate) fn add(&mut self, pass: Counted, counters: &Counters) {
        self.merge(&Self {
            emitted: counters.emitted.into(),
            recorded: counters.recorded.into(),
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

    /// Adds other counts. Those of a file may be anything.
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
