//! The settings of a render that its iterations read.

use crate::image::film::Window;
use crate::render::options::Contribution;
use crate::render::radius::RadiusSchedule;
use crate::render::sequence::{Place, Sequence, Shard};

/// Settings of a render, constant over its iterations.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// Width and height of the image.
    pub resolution: [u32; 2],
    /// Where it lies in what the camera sees.
    pub window: Window,
    /// Photons to emit.
    pub photons: u64,
    /// Eye paths of a pixel.
    pub eye_paths: u32,
    /// Share of an iteration's photons that a pixel keeps (Hachisuka 2008, eq. 5).
    pub alpha: f64,
    /// Who decides how radii shrink.
    pub radius_schedule: RadiusSchedule,
    /// Width of a pixel at distance 1, or at any where rays are parallel; render units.
    pub pixel_width: f64,
    /// Rays of the camera are parallel.
    pub is_parallel: bool,
    /// Radius of a visible point at distance 1, where radii follow the footprints of pixels.
    pub radius_per_length: f64,
    /// The iterations.
    pub sequence: Sequence,
    /// Mean flux of a photon times the number of photons, W.
    pub mean_power: f64,
    /// Unit of the sums, W/(m² sr).
    pub unit: f64,
    /// Which light the image has.
    pub contribution: Contribution,
    /// Whether there is a light, and a surface for its photons to meet.
    pub has_photons: bool,
    /// Photons may bring light that eye paths do not.
    pub photons_matter: bool,
}

impl Settings {
    /// Photons to emit: none where they would bring nothing, or nobody wants to see it.
    pub fn wanted_photons(&self) -> u64 {
        if self.has_photons && self.contribution != Contribution::Direct { self.photons } else { 0 }
    }

    /// The first of all iterations, of whichever shard.
    pub fn first_place(&self) -> Place {
        Sequence { shard: Shard::WHOLE, ..self.sequence }.place(0)
    }

    /// Pixels of the image.
    pub fn pixels(&self) -> u64 {
        self.resolution.map(u64::from).iter().product()
    }
}
