//! Prints what a device's compiler makes of goblet's kernels, for scenes that ask for little and for much of them:
//! `cargo run --example kernel_stats [-- OPTIONS]`
//!
//!     --device NAME   the device, by its index or a part of its name; without it, the one that renders would use
//!     --check         fails if a plain kernel or one with bodies of revolution spills or leaves too few subgroups
//!                     room, or if any kernel takes too long to compile
//!
//! The driver must have `VK_KHR_pipeline_executable_properties`. Mesa's driver for AMD cards compiles for a card
//! that is not there if `RADV_FORCE_FAMILY` names one: tests/registers.sh.

use std::env;
use std::error::Error;
use std::path::Path;
use std::process::ExitCode;
use std::time::Duration;

use goblet::kernels::{KERNELS, REQUIREMENTS, SceneFeatures, Specialization};
use goblet::render::specialized;
use goblet::scene::Scene;
use goblet::{DeviceInfo, Options};
use goblet_host::{Compiler, Executable, Instance, SpecializationValues};

/// The least number of subgroups that a SIMD unit must have room for, so that some can run while others wait for
/// memory.
const LEAST_SUBGROUPS: f64 = 8.0;
/// The most time of a CPU that a kernel may take to compile.
const MOST_TIME: Duration = Duration::from_secs(20);

/// What kernels are compiled for.
struct Profile {
    name: &'static str,
    /// In tests/reference. If there are several, kernels can do what any of them needs.
    scenes: &'static [&'static str],
    /// As if the scenes had so many primitives that rays need a hierarchy.
    is_large: bool,
    /// Whether kernels can also do what none of the scenes needs.
    has_all: bool,
    /// Whether kernels must neither spill nor take many registers.
    is_bounded: bool,
}

const PLAIN: &[&str] = &["cornell-caustic"];
const REVOLUTION: &[&str] = &["wine-cup"];
const RICH: &[&str] = &["layers", "textures", "lights", "spectra"];
const ALL: &[&str] = &[
    "caustic-point",
    "cornell-caustic",
    "layers",
    "lights",
    "revolution",
    "rough",
    "shapes",
    "spectra",
    "textures",
    "wine-cup",
];

const PROFILES: [Profile; 7] = [
    Profile { name: "plain", scenes: PLAIN, is_large: false, has_all: false, is_bounded: true },
    Profile { name: "plain, large", scenes: PLAIN, is_large: true, has_all: false, is_bounded: true },
    Profile { name: "revolution", scenes: REVOLUTION, is_large: false, has_all: false, is_bounded: true },
    Profile { name: "revolution, large", scenes: REVOLUTION, is_large: true, has_all: false, is_bounded: true },
    Profile { name: "meshes", scenes: &["shapes"], is_large: true, has_all: false, is_bounded: false },
    Profile { name: "rich, large", scenes: RICH, is_large: true, has_all: false, is_bounded: false },
    Profile { name: "everything", scenes: ALL, is_large: true, has_all: true, is_bounded: false },
];

/// Kernels that can do what any of these can.
struct Any(Vec<Specialization>);

impl SpecializationValues for Any {
    fn value(&self, id: u32) -> Option<[u8; 4]> {
        // True is above false. Floats that are not negative are ordered as their bits are.
        let values = self.0.iter().filter_map(|each| each.value(id)).map(u32::from_ne_bytes);
        values.max().map(u32::to_ne_bytes)
    }
}

impl Profile {
    /// Returns what kernels are specialised to, and the size of their workgroups.
    fn specialized(&self, device: &DeviceInfo) -> Result<(Any, u32), Box<dyn Error>> {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference");
        let (mut all, mut workgroup_size) = (Vec::new(), 0);
        if self.has_all {
            all.push(Specialization::DECLARED);
        }
        for name in self.scenes {
            let scene = Scene::load(folder.join(name).with_extension("pbrt"))?;
            let (mut one, size) = specialized(&scene, &Options::default(), device)?;
            if self.is_large {
                let none = SceneFeatures { is_flat: false, flat_triangles: 0, flat_quadrics: 0, ..one.scene };
                one.scene = SceneFeatures { flat_revolutions: 0, ..none };
            }
            all.push(one);
            workgroup_size = size;
        }
        Ok((Any(all), workgroup_size))
    }
}

/// What is printed of a kernel, in the order of the columns.
struct Row {
    kernel: &'static str,
    /// Names of the profiles that have these figures.
    profiles: Vec<&'static str>,
    is_bounded: bool,
    lanes: u32,
    figures: [Option<f64>; FIGURES.len()],
    /// The longest time to compile it, in seconds of a CPU.
    time: Duration,
}

/// Figures: the head of the column, then what drivers call it, of which those that one has are added up.
const FIGURES: [(&str, &[&str]); 5] = [
    ("registers", &["VGPRs", "Max live registers", "Number of GPRs"]),
    ("spilled", &["Spilled VGPRs", "Spilled SGPRs", "Spill count", "Spills", "Spills to memory"]),
    ("scratch", &["Scratch size", "Scratch memory size", "SLM size"]),
    ("subgroups", &["Subgroups per SIMD", "Max warps/SM"]),
    ("code", &["Code size"]),
];
const SPILLED: usize = 1;
const SUBGROUPS: usize = 3;

/// Returns the sum of the statistics with any of these names; `None` if there is none.
fn figure(executable: &Executable, names: &[&str]) -> Option<f64> {
    let is_named = |name: &str| names.iter().any(|other| other.eq_ignore_ascii_case(name));
    executable
        .statistics
        .iter()
        .filter(|(name, _)| is_named(name))
        .map(|(_, value)| *value)
        .reduce(|sum, value| sum + value)
}

/// Compiles all kernels for all profiles. Profiles for which a kernel is the same share a row.
fn rows(compiler: &Compiler) -> Result<Vec<Row>, Box<dyn Error>> {
    let mut rows: Vec<Row> = Vec::new();
    for profile in &PROFILES {
        let (values, workgroup_size) = profile.specialized(compiler.info())?;
        for kernel in &KERNELS {
            let before = cpu_time();
            let compiled = compiler.compile(kernel, &values, workgroup_size)?;
            let time = cpu_time() - before;
            for executable in &compiled.executables {
                let Profile { name, is_bounded, .. } = *profile;
                let figures = FIGURES.map(|(_, names)| figure(executable, names));
                let lanes = executable.lanes;
                let same = |row: &&mut Row| (row.kernel, row.lanes, row.figures) == (kernel.name, lanes, figures);
                match rows.iter_mut().find(same) {
                    Some(row) => {
                        row.profiles.push(name);
                        row.is_bounded |= is_bounded;
                        row.time = row.time.max(time);
                    }
                    None => {
                        rows.push(Row { kernel: kernel.name, profiles: vec![name], is_bounded, lanes, figures, time })
                    }
                }
            }
        }
    }
    rows.sort_by_key(|row| KERNELS.iter().position(|kernel| kernel.name == row.kernel));
    Ok(rows)
}

fn print(device: &DeviceInfo, rows: &[Row]) {
    println!("{}, {}\n", device.name, device.driver);
    let heads: Vec<&str> = FIGURES.iter().map(|(head, _)| *head).collect();
    println!("| kernel | profile | lanes | {} | ms |", heads.join(" | "));
    println!("| --- | --- |{}", " ---: |".repeat(heads.len() + 2));
    for Row { kernel, profiles, lanes, figures, time, .. } in rows {
        let profiles = if profiles.len() == PROFILES.len() { "all".to_owned() } else { profiles.join("; ") };
        let figures = figures.map(|figure| figure.map_or("?".to_owned(), |figure| figure.to_string()));
        println!("| {kernel} | {profiles} | {lanes} | {} | {} |", figures.join(" | "), time.as_millis());
    }
}

/// A message for each bound that a kernel does not keep.
fn faults(rows: &[Row]) -> Vec<String> {
    let mut faults = Vec::new();
    for Row { kernel, profiles, is_bounded, figures, time, .. } in rows {
        let of = format!("{kernel} ({})", profiles.join("; "));
        if *is_bounded {
            match (figures[SPILLED], figures[SUBGROUPS]) {
                (Some(spilled), Some(subgroups)) => {
                    if spilled > 0.0 {
                        faults.push(format!("{of} spills {spilled} registers"));
                    }
                    if subgroups < LEAST_SUBGROUPS {
                        faults.push(format!(
                            "{of}: a SIMD unit has room for {subgroups} subgroups, not {LEAST_SUBGROUPS}"
                        ));
                    }
                }
                _ => {
                    faults.push(format!("{of}: the driver does not tell whether it spills, or how many subgroups fit"))
                }
            }
        }
        if *time > MOST_TIME {
            faults.push(format!(
                "{of} takes {:.1} seconds to compile, more than {}",
                time.as_secs_f64(),
                MOST_TIME.as_secs()
            ));
        }
    }
    faults
}

/// CPU time of this process: it does not depend on what else the machine does.
#[cfg(unix)]
fn cpu_time() -> Duration {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    Duration::try_from(time).unwrap_or_default()
}

/// The time since the first call.
#[cfg(not(unix))]
fn cpu_time() -> Duration {
    static START: std::sync::OnceLock<std::time::Instant> = std::sync::OnceLock::new();
    START.get_or_init(std::time::Instant::now).elapsed()
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let (mut device, mut checks) = (None, false);
    let mut arguments = env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--device" => device = Some(arguments.next().ok_or("--device: expected a device")?),
            "--check" => checks = true,
            _ => return Err(format!("unknown argument {argument}; expected --device NAME or --check").into()),
        }
    }
    let compiler = Instance::new(false)?.open_compiler(device.as_deref(), &REQUIREMENTS)?;
    let rows = rows(&compiler)?;
    print(compiler.info(), &rows);
    let faults = if checks { faults(&rows) } else { Vec::new() };
    for fault in &faults {
        eprintln!("kernel_stats: {fault}");
    }
    Ok(if faults.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
