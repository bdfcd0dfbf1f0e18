//! Compares initial radii with a reference: `cargo run --release --example study -- SCENE`
//!
//! Small radii are noisy, and large ones blur: the error of an image has a minimum between them.

use std::env;
use std::error::Error;
use std::sync::Arc;

use goblet::image::compare::compare;
use goblet::image::film::Image;
use goblet::scene::Scene;
use goblet::{Device, DeviceOptions, Options, RenderError, Renderer, open_device};

const ITERATIONS: u32 = 16;
/// Iterations of the reference.
const MANY: u32 = 20 * ITERATIONS;

fn render(device: &Arc<Device>, scene: &Scene, options: &Options, iterations: u32) -> Result<Image, RenderError> {
    let mut renderer = Renderer::new(Arc::clone(device), scene, options)?;
    for _ in 0..iterations {
        renderer.step()?;
    }
    renderer.resolve()
}

fn main() -> Result<(), Box<dyn Error>> {
    let scene = env::args().nth(1).unwrap_or_else(|| "scenes/cornell-caustic.pbrt".to_owned());
    let scene = Scene::load(scene)?;
    let device = Arc::new(open_device(&DeviceOptions::default())?);
    let common = Options { resolution: Some([128, 128]), photons: Some(50_000), ..Options::default() };

    // Another seed, so that the reference shares no noise with what is compared.
    let seed = Some(scene.integrator.seed.wrapping_add(1));
    let fine = Options { seed, radius_in_pixels: Some(1.0), ..common.clone() };
    let reference = render(&device, &scene, &fine, MANY)?;
    println!("radius, pixels   relative squared error   energy over the reference's");
    for pixels in [0.5, 1.0, 2.0, 4.0, 8.0, 16.0] {
        let options = Options { radius_in_pixels: Some(pixels), ..common.clone() };
        let image = render(&device, &scene, &options, ITERATIONS)?;
        let comparison = compare(&image, &reference)?;
        println!("{pixels:14}   {:22.5}   {:27.4}", comparison.relmse_trimmed, comparison.energy_ratio);
    }
    Ok(())
}
