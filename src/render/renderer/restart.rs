//! A new render that reuses the hierarchy and the kernels of an earlier one.

use super::Renderer;
use crate::gpu_scene::camera::View;
use crate::render::error::RenderError;
use crate::render::options::{Options, Resolved};
use crate::scene::Scene;

impl Renderer {
    /// Starts the render again with another camera, film or options, without building or compiling anything.
    /// The image is the one that a new renderer gives. All other parts of the scene must be unchanged.
    /// Returns false and changes nothing if a new renderer is necessary: for other kernels, or for more
    /// pixels than this renderer has memory for. Numbers that a trial would choose ([`Options::auto`]) are the usual ones.
    ///
    /// # Errors
    /// An option is out of range, or the device fails.
    pub fn restart(&mut self, scene: &Scene, options: &Options) -> Result<bool, RenderError> {
        let (resolved, view) = self.base.resolve(scene, options)?;
        let compiled = self.base.compiled(&self.device, options, &resolved, &view);
        if compiled != self.compiled || !self.sizes.fit(resolved.resolution) {
            return Ok(false);
        }
        self.begin_again(scene, options, &resolved, &view)?;
        Ok(true)
    }

    /// Starts the render again with a view and options that need neither other kernels nor more memory.
    ///
    /// # Errors
    /// The device fails.
    pub(super) fn begin_again(
        &mut self,
        scene: &Scene,
        options: &Options,
        resolved: &Resolved,
        view: &View,
    ) -> Result<(), RenderError> {
        self.buffers.set_view(&self.device, view)?;
        self.buffers.clear(&self.device)?;
        if let Some(layers) = self.layers() {
            layers.clear(&self.device)?;
        }
        if self.progress.lights_are_learned {
            self.passes.photon.choose_lights(&self.device, &self.lights.direct)?;
        }
        self.identity.set_view(scene, view, options, resolved);
        self.settings = self.base.settings(scene, options, resolved, view);
        self.choice = None;
        self.exposure = scene.film.exposure;
        let paces = self.progress.schedule.paces;
        self.progress = self.base.progress(&self.device, options, resolved, view);
        if options.responsive {
            self.progress.schedule.paces = paces;
        }
        Ok(())
    }
}
