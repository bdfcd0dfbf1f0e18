//! Whether photons are guided, and what a pilot has found.

use std::time::Duration;

use super::tree::Tree;
use crate::base::names::named;

/// The photons of a round of a pilot.
pub const PHOTONS_OF_ROUND: u64 = 1 << 13;

named! {
    /// Whether photons begin where they bring light to what is seen.
    pub enum Guidance = Auto {
        /// Where a pilot of a few photons finds that it lowers the error
        Auto: "auto",
        /// Always
        On: "on",
        /// Photons begin by the power of the lights alone
        Off: "off",
    }
}

/// Whether photons begin by a guide, and if not, why not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Finding {
    /// Photons begin by the guide.
    Guided,
    /// The pilot has found that a guide would not lower the error enough.
    NotWorthwhile,
    /// No photon of the pilot has told where light comes from that is seen.
    NothingFound,
    /// Photons bring no light to what may be seen, so that there is no pilot.
    PhotonsDoNotMatter,
    /// No diffuse surface is seen, on which photons could be gathered.
    NothingSeen,
    /// Rough surfaces gather light of photons, of which a pilot knows nothing.
    RoughSurfaces,
}

/// What a pilot has found.
#[derive(Clone, Debug)]
pub struct Guide {
    /// Whether photons begin by the density of the tree, and if not, why not.
    pub finding: Finding,
    /// The density that photons begin with.
    pub tree: Tree,
    /// The chance that next-event estimation picks each light; `None` if it is the one by power.
    pub direct: Option<Vec<f64>>,
    /// The factor by which the guide lowers the product of variance and time of photons, as far as the pilot tells; 1 if
    /// photons begin by the power of the lights alone.
    pub gain: f64,
    /// The share of photons that bring light to what is seen, without the guide and with it.
    pub reached: [f64; 2],
    /// The time that the pilot took, with that of the host to learn.
    pub time: Duration,
}

impl Guide {
    /// Returns the mean flux of photons that bring light to what is seen, over that of photons which begin by the power of
    /// the lights alone; at most 1.
    pub fn weight_of_seen(&self) -> f64 {
        let [without, with] = self.reached;
        if with > without { without / with } else { 1.0 }
    }

    /// Photons that begin, and lights that are chosen, by the power of the lights alone.
    pub fn none(finding: Finding) -> Self {
        Self { finding, tree: Tree::uniform(), direct: None, gain: 1.0, reached: [0.0; 2], time: Duration::ZERO }
    }
}
