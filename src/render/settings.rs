//! The settings of a render that its iterations read.

use glam::DMat3;

use crate::image::film::{Window, balanced_luminance};
use crate::image::layers::LayerForm;
use crate::render::frame::Frame;
use crate::render::guide::guidance::Guidance;
use crate::render::options::Contribution;
use crate::render::radius::RadiusSchedule;
use crate::render::sequence::{IterationIndex, Sequence, Shard};

/// Settings of a render, constant over its iterations.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// Width and height of the image in pixels.
    pub resolution: [u32; 2],
    /// The position of the pixels in the full image of the camera.
    pub window: Window,
    /// Photons per iteration.
    pub photons: u64,
    /// Eye paths per pixel and iteration.
    pub eye_paths: u32,
    /// Whether photons begin where they bring light to what is seen.
    pub guidance: Guidance,
    /// Share of an iteration's photons that a pixel keeps (Hachisuka 2008, eq. 5).
    pub alpha: f64,
    /// The schedule by which radii shrink.
    pub radius_schedule: RadiusSchedule,
    /// Width of a pixel at distance 1, or at any distance if rays are parallel; render units.
    pub pixel_width: f64,
    /// Whether the rays of the camera are parallel.
    pub is_parallel: bool,
    /// Radius of a visible point at distance 1, if radii follow the footprints of pixels; render units.
    pub radius_per_length: f64,
    /// The sequence of iterations.
    pub sequence: Sequence,
    /// Mean flux of a photon times the number of photons, W.
    pub mean_power: f64,
    /// Unit of the sums before exposure, W/(m² sr).
    pub unit: f64,
    /// The white balance of the image: a matrix on linear RGB in the sRGB primaries; `None` if the film has none.
    pub white_balance: Option<DMat3>,
    /// The part of the light that the image shows.
    pub contribution: Contribution,
    /// Whether the scene has a light with power, and a surface that its photons can meet.
    pub has_photons: bool,
    /// Whether photons may contribute light that eye paths do not.
    pub photons_matter: bool,
    /// The form of the layers' sums.
    pub layers: LayerForm,
    /// The camera as files describe it; `None` if a number of it is too large for a file.
    pub frame: Option<Frame>,
}

impl Settings {
    /// Returns the factor of the radius within which the colors of wavelengths are averaged
    /// (`shaders/include/spectrum/wavelength.glsl`), at an iteration of all shards, counted from 0. It shrinks as radii do.
    pub fn color_shrink(&self, iteration: u64) -> f64 {
        (iteration as f64 + 1.0).powf(0.5 * (self.alpha - 1.0))
    }

    /// Returns the number of photons to emit per iteration: 0 if photons cannot contribute, or if the image
    /// shows direct light only.
    pub fn wanted_photons(&self) -> u64 {
        if self.has_photons && self.contribution != Contribution::Direct { self.photons } else { 0 }
    }

    /// Returns the mean flux of a photon over pi and the unit of the sums.
    pub fn flux_scale(&self) -> f64 {
        self.mean_power / (self.photons as f64 * std::f64::consts::PI * self.unit)
    }

    /// Returns the weights of the radiance's red, green and blue in the luminance of the image.
    pub fn luminance(&self) -> [f64; 3] {
        balanced_luminance(self.white_balance)
    }

    /// Returns the place of the first iteration of all shards.
    pub fn first_index(&self) -> IterationIndex {
        Sequence { shard: Shard::WHOLE, ..self.sequence }.index(0)
    }

    /// Returns the place of an iteration among those that share the pixels' statistics, from 0: those of a round if
    /// that has more than one, else all.
    pub fn step(&self, index: IterationIndex) -> u64 {
        if self.sequence.round_length > 1 { u64::from(index.step) } else { index.iteration }
    }

    /// Returns the number of pixels of the image.
    pub fn pixels(&self) -> u64 {
        self.resolution.map(u64::from).iter().product()
    }
}
