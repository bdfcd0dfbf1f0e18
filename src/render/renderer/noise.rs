//! The estimate of an image's error.

use super::Renderer;
use crate::image::estimate::Estimate;
use crate::render::error::RenderError;
use crate::render::guide;
use crate::render::guide::guidance::Guide;
use crate::render::stage::Stage;
use crate::render::unsampled::{Noise, of_one_photon};

impl Renderer {
    /// Returns the estimated error of the image and the smallest error that is known. `estimate` is the
    /// result of [`Renderer::estimate`] for the iterations so far.
    ///
    /// # Errors
    /// The device fails.
    pub fn noise(&mut self, estimate: &Estimate) -> Result<Noise, RenderError> {
        let of_halves = estimate.relative_error();
        let photons = self.photons();
        if !self.settings.photons_matter || photons == 0 {
            return Ok(Noise { of_halves, of_one_photon: 0.0 });
        }
        let stage = Stage {
            device: &self.device,
            buffers: &self.buffers,
            settings: &self.settings,
            lights: &self.lights,
            observer: &self.observer,
            gives_up: &|| false,
        };
        // A resumed render has not measured its response yet, nor learned its guide. The result must not depend on when
        // the checkpoint was made.
        if self.progress.response.is_none() {
            self.passes.eye.measure(stage, &mut self.progress)?;
            if guide::is_missing(stage, &self.progress) {
                guide::learn(&mut self.passes.photon, stage, &mut self.progress)?;
            }
        }
        let response = self.progress.response.unwrap_or_default();
        let weight = self.progress.guide.as_ref().map_or(1.0, Guide::weight_of_seen);
        let flux = weight * self.settings.mean_power / photons as f64;
        Ok(Noise { of_halves, of_one_photon: of_one_photon(response, flux, self.settings.unit, estimate) })
    }

    /// Returns the relative error of the image so far: [`Noise::relative_error`]. `None` if it is unknown.
    ///
    /// # Errors
    /// The device fails.
    pub fn relative_error(&mut self) -> Result<Option<f64>, RenderError> {
        let estimate = self.estimate()?;
        Ok(self.noise(&estimate)?.relative_error())
    }
}
