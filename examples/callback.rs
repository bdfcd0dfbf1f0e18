//! Calls a function after each iteration, which ends the render:
//! `cargo run --release --example callback -- SCENE RELATIVE_ERROR IMAGE`

use std::env;
use std::error::Error;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;
use std::thread;

use goblet::image::file;
use goblet::image::film::Image;
use goblet::scene::Scene;
use goblet::{DeviceOptions, Options, RenderError, Renderer, open_device};

/// Renders until `after_each` says that it is enough.
fn render(
    mut renderer: Renderer,
    mut after_each: impl FnMut(&mut Renderer) -> Result<ControlFlow<()>, RenderError>,
) -> Result<Image, RenderError> {
    loop {
        renderer.step()?;
        if after_each(&mut renderer)?.is_break() {
            return renderer.resolve();
        }
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let [scene, error, image] = &arguments[..] else { return Err("expected SCENE RELATIVE_ERROR IMAGE".into()) };
    let scene = Scene::load(scene)?;
    let wanted: f64 = error.parse()?;
    let device = Arc::new(open_device(&DeviceOptions::default())?);
    let renderer = Renderer::new(device, &scene, &Options::default())?;

    // A renderer may move to another thread.
    let worker = thread::spawn(move || {
        render(renderer, |renderer| {
            let error = renderer.relative_error()?;
            println!("iteration {}, {} photons, error {error:.4?}", renderer.iterations(), renderer.photons());
            let is_enough = error.is_some_and(|error| error <= wanted);
            Ok(if is_enough { ControlFlow::Break(()) } else { ControlFlow::Continue(()) })
        })
    });
    let rendered = worker.join().map_err(|_| "the thread that renders has failed")??;
    file::write(Path::new(image), &rendered, &[])?;
    Ok(())
}
