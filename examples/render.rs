//! Renders a scene from a string to a buffer: `cargo run --release --example render -- [IMAGE]`

use std::env;
use std::error::Error;
use std::path::PathBuf;
use std::sync::Arc;

use goblet::glam::DVec3;
use goblet::image::file;
use goblet::scene::{Camera, Scene};
use goblet::{DeviceOptions, Options, Renderer, open_device};

/// A glass ball on a floor, under a small lamp.
const SCENE: &str = r#"
Integrator "sppm" "integer maxdepth" 10
WorldBegin
LightSource "point" "point3 from" [ 0 3 1 ] "rgb I" [ 8 8 8 ]
Material "diffuse" "rgb reflectance" [ 0.7 0.7 0.7 ]
Shape "disk" "float radius" 5 "float height" 0
Material "dielectric" "float eta" 1.5
Translate 0 0 0.6
Shape "sphere" "float radius" 0.5
"#;

const RESOLUTION: [u32; 2] = [320, 240];

fn main() -> Result<(), Box<dyn Error>> {
    let mut scene = Scene::parse(SCENE, "the scene of the example", ".")?;
    let (eye, target, up) = (DVec3::new(0.0, -4.0, 2.0), DVec3::new(0.0, 0.0, 0.4), DVec3::Z);
    let fov = 35f64.to_radians();
    scene.camera = Camera::looking_at(eye, target, up, fov, RESOLUTION).ok_or("not a camera")?;

    let device = Arc::new(open_device(&DeviceOptions::default())?);
    println!("rendering on {}", device.info().name);
    let options = Options { resolution: Some(RESOLUTION), photons: Some(100_000), ..Options::default() };
    let mut renderer = Renderer::new(device, &scene, &options)?;
    for _ in 0..16 {
        renderer.step()?;
    }

    // Linear RGB radiance of each pixel, row by row from the top.
    let image = renderer.resolve()?;
    let [_, _, blue] = image.pixels[image.pixels.len() / 2];
    println!("{}x{} pixels, blue of the middle one {blue:.4}", image.width, image.height);
    if let Some(path) = env::args_os().nth(1).map(PathBuf::from) {
        file::write(&path, &image, &[])?;
    }
    Ok(())
}
