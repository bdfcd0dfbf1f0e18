//! Renders the reference of the wine cup anew, in some minutes: the mean of two renders in ways that
//! share as little as they can. `cargo bench --bench reference -- tests/reference/wine-cup.exr`

#[path = "../tests/support/variants.rs"]
mod variants;

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

use goblet::image::compare::compare;
use goblet::image::file;
use goblet::image::film::Image;
use goblet::{DeviceOptions, DirectLight, Integrator, Options, RadiusSchedule, Renderer, Sampler, open_device};
use goblet_host::Device;
use variants::Variant;

/// Iterations of each of the two renders.
const ITERATIONS: u32 = 368;
const WAYS: [Variant; 2] = [
    Variant {
        integrator: Integrator::Sppm,
        radius_schedule: RadiusSchedule::Global,
        direct: DirectLight::Nee,
        sampler: Sampler::Sobol,
    },
    Variant {
        integrator: Integrator::Ppm,
        radius_schedule: RadiusSchedule::Adaptive,
        direct: DirectLight::Photons,
        sampler: Sampler::Sobol,
    },
];

fn main() -> ExitCode {
    // Cargo adds `--bench`.
    let Some(output) = std::env::args_os().skip(1).find(|word| word != "--bench").map(PathBuf::from) else {
        eprintln!("usage: cargo bench --bench reference -- OUT.exr");
        return ExitCode::from(2);
    };
    match write(&output) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("reference: {error}");
            ExitCode::FAILURE
        }
    }
}

fn write(output: &Path) -> Result<(), Box<dyn Error>> {
    let device = Arc::new(open_device(&DeviceOptions::default())?);
    let [mut mean, other] = [render(&device, WAYS[0])?, render(&device, WAYS[1])?];
    println!("{:#?}", compare(&mean, &other)?);
    for (value, other) in mean.pixels.as_flattened_mut().iter_mut().zip(other.pixels.as_flattened()) {
        *value = 0.5 * (*value + other);
    }
    Ok(file::write(output, &mean, &[])?)
}

fn render(device: &Arc<Device>, variant: Variant) -> Result<Image, Box<dyn Error>> {
    let scene = variants::boxed_scene(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference/wine-cup.pbrt"));
    let base = Options {
        resolution: Some([96; 2]),
        photons: Some(65_536),
        radius: Some(0.02),
        seed: Some(77),
        ..Options::default()
    };
    let mut renderer = Renderer::new(Arc::clone(device), &scene, &variant.options(&base, 4))?;
    for _ in 0..ITERATIONS {
        renderer.step()?;
    }
    Ok(renderer.resolve()?)
}
