//! Quantities of each pixel that are read from the device after an iteration.

use super::Renderer;
use crate::render::error::RenderError;
use crate::render::guide::guidance::Guide;

impl Renderer {
    /// Returns the length of each pixel's eye path to its visible point in the last iteration, in scene
    /// units; 0 for pixels without a visible point.
    ///
    /// # Errors
    /// The device fails.
    pub fn path_lengths(&self) -> Result<Vec<f32>, RenderError> {
        let throughputs = self.device.read_first_texels(&self.buffers.visible_throughputs, self.settings.pixels())?;
        let scale = self.base.space.scale;
        Ok(throughputs.into_iter().map(|throughput| (f64::from(throughput[3]) / scale) as f32).collect())
    }

    /// Returns the result of the pilot for guided emission; `None` before the first iteration, or without a pilot.
    pub fn guide(&self) -> Option<&Guide> {
        self.progress.guide.as_ref()
    }

    /// Returns whether glass splits light by wavelength.
    pub fn splits_light(&self) -> bool {
        self.base.material_features.has_dispersion
    }

    /// Returns whether iterations trace photons. They do not if only direct light is wanted, or if no light reaches a
    /// surface.
    pub fn follows_photons(&self) -> bool {
        self.settings.wanted_photons() > 0
    }
}
