//! Measures how many rays a second goblet traces, for the nearest hit and for any hit, and prints a table
//! as Markdown: `cargo bench --bench rays -- [OPTIONS] [SCENE.pbrt..]`
//!
//! The rays are made before the measurement. The kernel that traces them has the loop of the passes
//! (`shaders/include/geometry/trace.glsl`), but neither shading nor anything else to do between rays.
//! `benches/rays/embree.py` measures Embree on the same rays.

#[path = "rays/arguments.rs"]
mod arguments;
#[path = "rays/export.rs"]
mod export;
#[path = "rays/measure.rs"]
mod measure;
#[path = "../tests/support/place.rs"]
mod place;
#[path = "rays/prepare.rs"]
mod prepare;
#[allow(dead_code, reason = "tests use the rest")]
#[path = "../tests/support/random.rs"]
mod random;
#[path = "rays/scenes.rs"]
mod scenes;
#[path = "rays/sets.rs"]
mod sets;
#[path = "rays/table.rs"]
mod table;

use std::env;
use std::error::Error;
use std::process::{Command, ExitCode};

use arguments::{Arguments, USAGE};
use goblet::{Device, DeviceOptions, open_device};
use measure::{Answers, Case};
use prepare::Prepared;
use sets::{Rays, Set};

type Result<T> = std::result::Result<T, Box<dyn Error>>;

fn main() -> ExitCode {
    // Cargo adds `--bench`.
    let arguments = match Arguments::parse(env::args_os().skip(1).filter(|word| word != "--bench")) {
        Ok(arguments) => arguments,
        Err(message) => {
            eprintln!("rays: {message}\nusage: cargo bench --bench rays -- {USAGE}");
            return ExitCode::from(2);
        }
    };
    match run(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("rays: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> Result<()> {
    let device = open_device(&DeviceOptions { selector: arguments.device.as_deref(), ..DeviceOptions::default() })?;
    let answers = Answers::new(&device, arguments.rays)?;
    let mut cases = Vec::new();
    for source in scenes::sources(arguments) {
        let scene = source.load()?;
        let prepared = Prepared::new(&device, source.name(), &scene)?;
        if let Some(folder) = &arguments.folder {
            export::write(&device, &prepared, arguments.rays, folder)?;
            continue;
        }
        for set in Set::ALL {
            if let Some(rays) = Rays::new(&device, &prepared, set, arguments.rays)? {
                cases.push(Case::new(&device, &prepared, rays, &answers)?);
            }
        }
    }
    if arguments.folder.is_none() {
        print_conditions(&device, arguments);
        measure::measure(&device, &mut cases, &answers, arguments.turns)?;
        print!("{}", table::markdown(&cases, device.info().kind));
    }
    Ok(())
}

/// Prints on what is measured, and how.
fn print_conditions(device: &Device, arguments: &Arguments) {
    let commit = git_commit().map_or(String::new(), |commit| format!(", commit {commit}"));
    println!("goblet {}{commit}", env!("CARGO_PKG_VERSION"));
    println!("{}, {}", device.info().name, device.info().driver);
    println!("{} rays, medians of {} turns\n", arguments.rays, arguments.turns);
}

/// The commit that is checked out, with a `+` if files differ from it.
fn git_commit() -> Option<String> {
    let git = Command::new("git")
        .arg("-C")
        .arg(place::root())
        .args(["describe", "--always", "--abbrev=9", "--exclude=*", "--dirty=+"])
        .output()
        .ok()?;
    let text = String::from_utf8(git.stdout).ok()?.trim().to_owned();
    (git.status.success() && !text.is_empty()).then_some(text)
}
