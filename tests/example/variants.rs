//! Measures every way to render the same image at equal time, and prints the tables of
//! docs/variants.md: `cargo run --release --example variants -- [SECONDS]`

#[path = "../support/variants.rs"]
mod variants;

use std::env;
use std::error::Error;
use std::path::Path;
use std::rc::Rc;
use std::time::Instant;

use goblet::compare::{Comparison, compare};
use goblet::film::Image;
use goblet::scene::Scene;
use goblet::{LookupKind, Options, Renderer, open_device};
use goblet_host::Device;
use variants::Variant;

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// Scenes and their references. The wine cup's is goblet's own.
const SCENES: [[&str; 2]; 3] = [
    ["tests/reference/cornell-caustic.pbrt", "tests/reference/cornell-caustic.exr"],
    ["tests/reference/caustic-point.pbrt", "tests/reference/caustic-point.exr"],
    ["scenes/wine-cup.pbrt", "tests/variants/wine-cup.exr"],
];
const PHOTONS: u64 = 65_536;
/// Iterations of a round of progressive photon mapping.
const ROUND: u64 = 4;
/// Cells of other widths, in diameters of the largest disc.
const CELL_SCALES: [f64; 2] = [0.5, 2.0];
/// Each way is measured so often, every second time in the opposite order, so that a machine
/// that gets slower is fair to all.
const REPEATS: u32 = 2;

/// A way to render.
struct Way {
    name: String,
    options: Options,
}

/// What came of it, the mean over repeats.
#[derive(Clone, Copy, Default)]
struct Outcome {
    seconds_per_iteration: f64,
    iterations: f64,
    relmse: f64,
    energy: f64,
    estimated_error: f64,
}

fn main() -> Result<()> {
    let seconds: f64 = env::args().nth(1).map_or(Ok(8.0), |text| text.parse())?;
    let device = Rc::new(open_device(None, false)?);
    println!("{}, {}", device.info().name, device.info().driver);
    println!("{PHOTONS} photons an iteration; {seconds} s for each way, {REPEATS} times {} s\n", part(seconds));
    for [path, reference] in SCENES {
        let scene = variants::boxed_scene(Path::new(path));
        let reference = variants::reference(Path::new(reference), 1);
        println!("{path}, {}x{}\n", reference.width, reference.height);
        println!("{}\n", measure_all(&device, &scene, &reference, seconds)?);
    }
    Ok(())
}

/// Seconds of one repeat.
fn part(seconds: f64) -> f64 {
    seconds / f64::from(REPEATS)
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

/// A table of all ways.
fn measure_all(device: &Rc<Device>, scene: &Scene, reference: &Image, seconds: f64) -> Result<String> {
    let ways = ways([reference.width, reference.height]);
    let mut sums = vec![Outcome::default(); ways.len()];
    for repeat in 0..REPEATS {
        for i in 0..ways.len() {
            let i = if repeat % 2 == 0 { i } else { ways.len() - 1 - i };
            // Another seed, or both would have the same noise.
            let options = Options { seed: Some(repeat), ..ways[i].options.clone() };
            sums[i].add(&measure(device, scene, &options, reference, part(seconds))?);
        }
    }
    let mut table = String::from(
        "| way | ms/iteration | iterations | relMSE | mean energy | estimated error |\n\
         | --- | --- | --- | --- | --- | --- |",
    );
    for (way, sum) in ways.iter().zip(&sums) {
        table += &format!("\n| {} {}", way.name, sum.row());
    }
    Ok(table)
}

/// Renders for some time. Kernels are compiled before.
fn measure(device: &Rc<Device>, scene: &Scene, options: &Options, reference: &Image, seconds: f64) -> Result<Outcome> {
    let mut renderer = Renderer::new(Rc::clone(device), scene, options)?;
    let start = Instant::now();
    while start.elapsed().as_secs_f64() < seconds {
        renderer.step()?;
    }
    let spent = start.elapsed().as_secs_f64();
    let estimate = renderer.estimate()?;
    let Comparison { relmse_trimmed, energy_ratio_trimmed, .. } = compare(&estimate.image(), reference)?;
    let iterations = f64::from(renderer.iterations());
    Ok(Outcome {
        seconds_per_iteration: spent / iterations,
        iterations,
        relmse: relmse_trimmed,
        energy: energy_ratio_trimmed,
        // Nothing is known before two rounds are over.
        estimated_error: estimate.relative_error().unwrap_or(f64::NAN),
    })
}

impl Outcome {
    fn add(&mut self, other: &Self) {
        self.seconds_per_iteration += other.seconds_per_iteration;
        self.iterations += other.iterations;
        self.relmse += other.relmse;
        self.energy += other.energy;
        self.estimated_error += other.estimated_error;
    }

    /// The rest of a table's row: means over the repeats.
    fn row(&self) -> String {
        let repeats = f64::from(REPEATS);
        let Self { seconds_per_iteration, iterations, relmse, energy, estimated_error } = self;
        format!(
            "| {:.1} | {:.0} | {:.5} | {:.4} | {:.4} |",
            1e3 * seconds_per_iteration / repeats,
            iterations / repeats,
            relmse / repeats,
            energy / repeats,
            estimated_error / repeats
        )
    }
}
