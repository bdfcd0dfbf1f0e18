//! Renders that are stopped, killed, resumed, cut into shards and merged, against one that is
//! left alone: the same to the last bit.

mod counters;
mod files;
mod refusals;
mod resume;
mod shards;
mod stops;

use std::sync::Arc;

use goblet::image::film::Image;
use goblet::render::checkpoint::Checkpoint;
use goblet::scene::Scene;
use goblet::{Options, Renderer};
use goblet_host::Device;

use crate::support;
use crate::support::command::{self, SCENE};

/// How a test renders.
struct Case {
    name: &'static str,
    scene: String,
    options: Options,
}

impl Case {
    fn new(name: &'static str, options: Options) -> Self {
        Self { name, scene: SCENE.to_owned(), options }
    }

    /// With radii that follow the footprints of pixels.
    fn with_automatic_radius(self) -> Self {
        Self { scene: command::scene(" \"float radius\" 0.5\nW", "\nW"), ..self }
    }

    /// With a lamp inside glass that splits light, so that sums are below 0 in places.
    fn with_dispersion(self) -> Self {
        let glass = "Material \"dielectric\" \"spectrum eta\" \"glass-F11\"";
        let scene = self.scene.replace("Material \"dielectric\"", glass).replace("[ 0 1.5 -1 ]", "[ 0 .4 0 ]");
        // Colours are not means over many wavelengths where discs are small.
        Self { scene, options: Options { radius: Some(0.05), ..self.options }, ..self }
    }

    fn renderer(&self, device: &Arc<Device>) -> Renderer {
        let scene = Scene::parse(&self.scene, "scene.pbrt", support::root()).expect("a scene");
        Renderer::new(Arc::clone(device), &scene, &self.options).expect("a renderer")
    }
}

/// Renders up to `iterations`.
fn advance(renderer: &mut Renderer, iterations: u32) {
    while renderer.iterations() < iterations {
        renderer.step().expect("an iteration");
    }
}

/// A checkpoint as a file gives it back.
fn save(renderer: &Renderer) -> Checkpoint {
    through_file(&renderer.checkpoint("scene.pbrt").expect("a checkpoint"))
}

fn through_file(checkpoint: &Checkpoint) -> Checkpoint {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("x.checkpoint");
    checkpoint.write(&path).expect("a file");
    let back = Checkpoint::read(&path).expect("a checkpoint");
    assert_eq!(back, *checkpoint);
    back
}

fn bits(image: &Image) -> Vec<[u32; 3]> {
    image.pixels.iter().map(|pixel| pixel.map(f32::to_bits)).collect()
}

fn energy(image: &Image) -> f64 {
    support::mean(image).iter().sum()
}
