//! Renders a scene with the library: `cargo run --release --example render -- SCENE IMAGE...`

use std::env;
use std::error::Error;
use std::path::PathBuf;
use std::rc::Rc;

use goblet::image::file;
use goblet::scene::Scene;
use goblet::{Options, Renderer, open_device};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = env::args_os().skip(1).map(PathBuf::from);
    let scene = arguments.next().unwrap_or_else(|| "scenes/cornell-caustic.pbrt".into());
    let mut images: Vec<PathBuf> = arguments.collect();
    if images.is_empty() {
        images.push("cornell-caustic.png".into());
    }

    let scene = Scene::load(scene)?;
    for warning in &scene.warnings {
        eprintln!("warning: {warning}");
    }
    // The first device that fits, without validation.
    let device = Rc::new(open_device(None, false)?);
    println!("rendering on {}", device.info().name);

    // What is not said here is as the scene has it.
    let options = Options { photons: Some(100_000), ..Options::default() };
    let mut renderer = Renderer::new(device, &scene, &options)?;
    while renderer.iterations() < scene.integrator.iterations.min(16) {
        renderer.step()?;
    }
    println!("{} photons, of which {} were lost", renderer.photons(), renderer.tally().lost_in_glass);

    // Each step improves the image: it can be had after any of them.
    let image = renderer.resolve()?;
    for path in &images {
        file::write(path, &image, &[])?;
        println!("wrote {}", path.display());
    }
    Ok(())
}
