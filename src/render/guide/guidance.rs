//! The option that turns the guide on, and what a pilot has found. A guide directs the emission of photons.

use std::time::Duration;

use super::tree::Tree;
use crate::base::names::named;

/// Number of photons of one round of a pilot.
pub const PHOTONS_OF_ROUND: u64 = 1 << 13;

named! {
    /// Whether to emit more photons towards the surfaces that are visible.
    pub enum Guidance = Auto {
        /// If the pilot predicts less noise for the same time
        Auto: "auto",
        /// Even if the pilot predicts no gain
        On: "on",
        /// No pilot: photons are emitted in proportion to the power of the lights
        Off: "off",
    }
}

/// Whether a guide chooses how photons are emitted, and if not, why not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Finding {
    /// Photons are emitted by the guide.
    Guided,
    /// The pilot has found that a guide would not lower the error enough.
    NotWorthwhile,
    /// No photon of the pilot has brought light to a visible surface.
    NothingFound,
    /// Photons cannot bring light to any visible surface, so there is no pilot.
    PhotonsDoNotMatter,
    /// No visible surface is diffuse, so no photons are gathered.
    NothingSeen,
    /// Rough surfaces gather photons, and the pilot cannot tell what its photons bring to them.
    RoughSurfaces,
}

/// What a pilot has found.
#[derive(Clone, Debug)]
pub struct Guide {
    /// Whether photons are emitted by the density of the tree, and if not, why not.
    pub finding: Finding,
    /// The density of the random numbers with which photons are emitted.
    pub tree: Tree,
    /// The probability with which next-event estimation picks each light; `None` if it is proportional to power.
    pub direct: Option<Vec<f64>>,
    /// The factor by which the guide lowers the product of variance and time of the photons, as the pilot estimates it;
    /// 1 without a guide.
    pub gain: f64,
    /// The share of photons that bring light to visible surfaces, without the guide and with it.
    pub reached: [f64; 2],
    /// The time of the pilot, which includes the host's time to learn the density.
    pub time: Duration,
}

impl Guide {
    /// Returns the mean flux of the photons that bring light to visible surfaces, divided by the mean flux of a photon
    /// without a guide; at most 1.
    pub fn weight_of_seen(&self) -> f64 {
        let [without, with] = self.reached;
        if with > without { without / with } else { 1.0 }
    }

    /// Returns no guide: photons are emitted, and lights are picked, in proportion to the power of the lights.
    pub fn none(finding: Finding) -> Self {
        Self { finding, tree: Tree::uniform(), direct: None, gain: 1.0, reached: [0.0; 2], time: Duration::ZERO }
    }
}
