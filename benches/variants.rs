//! Measures every way to render the same image at equal time, and prints tables as
//! Markdown: `cargo bench --bench variants -- [SECONDS]`

#[path = "../tests/support/variants.rs"]
mod variants;

use std::env;
use std::error::Error;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use goblet::image::compare::{Comparison, compare};
use goblet::image::film::Image;
use goblet::scene::Scene;
use goblet::{DeviceOptions, LookupKind, Options, Renderer, open_device};
use goblet_host::Device;
use variants::Variant;

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// Scenes and their references. The wine cup's is goblet's own.
const SCENES: [[&str; 2]; 3] = [
    ["tests/reference/cornell-caustic.pbrt", "tests/reference/cornell-caustic.exr"],
    ["tests/reference/caustic-point.pbrt", "tests/reference/caustic-point.exr"],
    ["tests/reference/wine-cup.pbrt", "tests/reference/wine-cup.exr"],
];
const PHOTONS: u64 = 65_536;
/// Iterations of a round of progressive photon mapping.
const ROUND: u64 = 4;
/// Cells of other widths, in diameters of the largest disc.
const CELL_SCALES: [f64; 2] = [0.5, 2.0];
/// Ways take turns, every second time in the opposite order: what else the machine does then
/// slows all of them alike. Each has `TURNS` turns.
const TURNS: u32 = 8;

/// A way to render.
struct Way {
    name: String,
    options: Options,
}

fn main() -> Result<()> {
    let seconds: f64 = env::args().skip(1).find(|word| word != "--bench").map_or(Ok(8.0), |text| text.parse())?;
    let device = Arc::new(open_device(&DeviceOptions::default())?);
    println!("{}, {}", device.info().name, device.info().driver);
    println!("{PHOTONS} photons an iteration; {seconds} s for each way, in {TURNS} turns\n");
    for [path, reference] in SCENES {
        let scene = variants::boxed_scene(Path::new(path));
        let reference = variants::reference(Path::new(reference), 1);
        println!("{path}, {}x{}\n", reference.width, reference.height);
        println!("{}\n", measure_all(&device, &scene, &reference, seconds)?);
    }
    Ok(())
}

/// The 16 variants, and the default with the lookups that do not change the image.
fn ways(resolution: [u32; 2]) -> Vec<Way> {
    let base = Options { resolution: Some(resolution), photons: Some(PHOTONS), ..Options::default() };
    let variant = |variant: Variant| Way { name: variant.name(), options: variant.options(&base, ROUND) };
    let mut ways: Vec<Way> = Variant::all().into_iter().map(variant).collect();
    let options = Options { lookup: LookupKind::KdTree, ..base.clone() };
    ways.push(Way { name: "default, kd-tree".into(), options });
    for scale in CELL_SCALES {
        let options = Options { cell_scale: Some(scale), ..base.clone() };
        ways.push(Way { name: format!("default, cells of {scale}"), options });
    }
    ways
}

/// A table of all ways. Kernels are compiled before time counts.
fn measure_all(device: &Arc<Device>, scene: &Scene, reference: &Image, seconds: f64) -> Result<String> {
    let ways = ways([reference.width, reference.height]);
    let mut renders = Vec::new();
    for way in &ways {
        renders.push(Render { renderer: Renderer::new(Arc::clone(device), scene, &way.options)?, seconds: 0.0 });
    }
    for turn in 1..=TURNS {
        let until = seconds * f64::from(turn) / f64::from(TURNS);
        for i in 0..renders.len() {
            let i = if turn % 2 == 0 { i } else { ways.len() - 1 - i };
            renders[i].go_on(until)?;
        }
    }
    let mut table = String::from(
        "| way | ms/iteration | iterations | relMSE | mean energy | estimated error |\n\
         | --- | --- | --- | --- | --- | --- |",
    );
    for (way, render) in ways.iter().zip(&renders) {
        table += &format!("\n| {} {}", way.name, render.row(reference)?);
    }
    Ok(table)
}

/// A render, and the time that it has taken.
struct Render {
    renderer: Renderer,
    seconds: f64,
}

impl Render {
    fn go_on(&mut self, until: f64) -> Result<()> {
        while self.seconds < until {
            let start = Instant::now();
            self.renderer.step()?;
            self.seconds += start.elapsed().as_secs_f64();
        }
        Ok(())
    }

    /// The rest of a table's row.
    fn row(&self, reference: &Image) -> Result<String> {
        let iterations = self.renderer.iterations();
        let estimate = self.renderer.estimate()?;
        let Comparison { relmse_trimmed, energy_ratio_trimmed, .. } = compare(&estimate.image(), reference)?;
        let milliseconds = 1e3 * self.seconds / f64::from(iterations);
        // Nothing is known before two rounds are over.
        let error = estimate.relative_error().map_or("-".into(), |error| format!("{error:.4}"));
        Ok(format!("| {milliseconds:.1} | {iterations} | {relmse_trimmed:.5} | {energy_ratio_trimmed:.4} | {error} |"))
    }
}
