//! Measures goblet on this machine: whole scenes, the error at equal time, and how time grows
//! with the size of the task. Prints Markdown tables, and writes bench.json, which has every
//! single measurement, and plots:
//! `cargo run --release --example bench -- [--quick] [--references A.exr B.exr] OUT_DIR`

#[path = "bench/arguments.rs"]
mod arguments;
#[path = "bench/cases.rs"]
mod cases;
#[path = "bench/error.rs"]
mod error;
#[path = "bench/growth.rs"]
mod growth;
#[path = "bench/measure.rs"]
mod measure;
#[path = "bench/plot.rs"]
mod plot;
#[path = "bench/report.rs"]
mod report;
#[path = "bench/scenes.rs"]
mod scenes;

use std::env;
use std::error::Error;
use std::fs;
use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

use goblet::study::machine::Machine;
use goblet::{DeviceOptions, open_device};
use serde::Serialize;

use arguments::{Arguments, USAGE};
use growth::{Growth, SERIES};

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// Seconds that each part may take. What would take longer is left out.
struct Plan {
    /// For the iterations of each scene.
    scene: f64,
    seeds: u32,
    /// For each seed's render.
    error: f64,
    /// For each series, in the order of [`SERIES`].
    growth: [f64; SERIES.len()],
    /// For everything, should the machine be busy.
    total: f64,
}

/// Eight minutes.
const FULL: Plan = Plan { scene: 8.0, seeds: 3, error: 12.0, growth: [30.0, 70.0, 80.0, 200.0], total: 480.0 };
const QUICK: Plan = Plan { scene: 1.0, seeds: 1, error: 3.0, growth: [5.0, 8.0, 6.0, 8.0], total: 50.0 };

/// The contents of bench.json.
#[derive(Serialize)]
struct Bench {
    machine: Machine,
    quick: bool,
    scenes: Vec<scenes::Measured>,
    /// Null without references.
    error: Option<error::Measured>,
    growth: Vec<Growth>,
}

fn main() -> ExitCode {
    let arguments = match Arguments::parse(env::args_os().skip(1)) {
        Ok(arguments) => arguments,
        Err(what) => {
            eprintln!("bench: {what}; usage: {USAGE}");
            return ExitCode::from(2);
        }
    };
    match run(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("bench: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> Result<()> {
    let start = Instant::now();
    let plan = if arguments.quick { QUICK } else { FULL };
    let folder = &arguments.folder;
    fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let device = Arc::new(open_device(&DeviceOptions::default())?);
    let machine = Machine::new(device.info());
    println!("{}", report::machine(&machine));

    let mut bench = Bench { machine, quick: arguments.quick, scenes: vec![], error: None, growth: vec![] };
    bench.scenes = scenes::measure(&device, plan.scene)?;
    println!("{}", report::scenes(&bench.scenes));
    bench.save(folder)?;
    if let Some(references) = &arguments.references {
        let measured = error::measure(&device, references, plan.seeds, plan.error)?;
        println!("{}", report::error(&measured));
        plot::error(&folder.join("error.svg"), &measured)?;
        bench.error = Some(measured);
        bench.save(folder)?;
    }
    // What a series leaves, the next may have.
    let mut until = start.elapsed().as_secs_f64();
    for (series, seconds) in SERIES.into_iter().zip(plan.growth) {
        until = plan.total.min(until + seconds);
        let growth = growth::measure(&device, series, until - start.elapsed().as_secs_f64())?;
        println!("{}", report::growth(&growth));
        plot::growth(&folder.join(format!("growth-{}.svg", series.name)), &growth)?;
        bench.growth.push(growth);
        bench.save(folder)?;
    }
    eprintln!("{:.0} s in all", start.elapsed().as_secs_f64());
    Ok(())
}

impl Bench {
    /// After each part: who stops a long run keeps what there is.
    fn save(&self, folder: &Path) -> Result<()> {
        let path = folder.join("bench.json");
        let text = serde_json::to_string_pretty(self)? + "\n";
        Ok(fs::write(&path, text).map_err(|error| format!("{}: {error}", path.display()))?)
    }
}
