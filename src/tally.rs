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
    /// Paths that reached the maximum depth.
    pub truncated: u64,
    /// Photon and eye paths that found no way out of a dielectric.
    pub lost_in_glass: u64,
    /// The eye paths among them.
    pub eye_lost_in_glass: u64,
    /// Photon and eye paths that met an opaque surface while in a dielectric: 0 unless
    /// something stands in glass or water. In a closed room, this is where lost ones end.
    pub immersed: u64,
    /// Paths dropped because a value was not finite.
    pub non_finite: u64,
    /// Deposits that did not fit the fixed-point sum.
    pub saturated: u64,
}

impl Tally {
    /// Adds what the device counted.
    pub fn add(&mut self, counters: &Counters) {
        self.merge(&Self {
            emitted: counters.emitted.into(),
            recorded: counters.recorded.into(),
            deposited: counters.deposited.into(),
            absorbed: counters.absorbed.into(),
            escaped: counters.escaped.into(),
            truncated: counters.truncated.into(),
            lost_in_glass: u64::from(counters.lost_in_glass) + u64::from(counters.eye_lost_in_glass),
            eye_lost_in_glass: counters.eye_lost_in_glass.into(),
            immersed: counters.immersed.into(),
            non_finite: counters.non_finite.into(),
            saturated: counters.saturated.into(),
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
        add(&mut self.lost_in_glass, other.lost_in_glass);
        add(&mut self.eye_lost_in_glass, other.eye_lost_in_glass);
        add(&mut self.immersed, other.immersed);
        add(&mut self.non_finite, other.non_finite);
        add(&mut self.saturated, other.saturated);
    }
}
