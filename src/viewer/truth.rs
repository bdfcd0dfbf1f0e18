//! The pictures that tests expect in the window: those of a renderer with the same target.

use std::sync::{Arc, LazyLock};

use goblet_host::Device;

use super::quantity::Picture;
use super::session::Session;
use super::tests::SCENE;
use crate::render::device::{DeviceOptions, open_device};
use crate::render::options::Options;
use crate::render::renderer::Renderer;
use crate::scene::{Camera, Scene};

/// The pictures that the window should show.
pub struct Truth {
    scene: Scene,
    renderer: Renderer,
    /// The camera and the options of the image that the renderer has.
    last: Option<(Camera, Options)>,
}

/// Without validation layers, which the devices of the render threads have.
static DEVICE: LazyLock<Arc<Device>> = LazyLock::new(|| Arc::new(open_device(&DeviceOptions::default()).unwrap()));

impl Truth {
    /// Returns the pictures of the tests' scene.
    pub fn new() -> Self {
        let scene = Scene::parse(SCENE, "scene.pbrt", ".").unwrap();
        let renderer = Renderer::new(Arc::clone(&DEVICE), &scene, &Options::default()).unwrap();
        Self { scene, renderer, last: None }
    }

    /// Returns the picture and the saved image after this number of iterations of the session's target.
    pub fn after(&mut self, iterations: u32, session: &Session) -> (Picture, Vec<[f32; 3]>) {
        let contribution = session.quantity.contribution();
        let scene = Scene { camera: *session.control.camera(), ..self.scene.clone() };
        let layers = session.options.layers.with(session.quantity.layers());
        let options = Options { contribution, layers, ..session.options.clone() };
        // Tests ask for the same image several times. It is rendered once.
        let last = Some((scene.camera, options.clone()));
        if self.last != last || self.renderer.iterations() > iterations {
            if !self.renderer.restart(&scene, &options).unwrap() {
                let of_layers = self.last.as_ref().is_none_or(|(_, last)| last.layers != options.layers);
                assert!(of_layers, "the same kernels");
                self.renderer = Renderer::new(Arc::clone(&DEVICE), &scene, &options).unwrap();
            }
            self.last = last;
        }
        while self.renderer.iterations() < iterations {
            self.renderer.step().unwrap();
        }
        let estimate = self.renderer.estimate().unwrap();
        (session.quantity.picture(&estimate), estimate.image().pixels)
    }
}
