//! Measures the hash grid against the kd-tree: the time to index visible points, and the
//! time to add photons to those in reach. Writes lookup.csv and lookup.svg, and prints the
//! tables as Markdown: `cargo bench --bench lookup -- OUT_DIR`

#[path = "lookup/plot.rs"]
mod plot;

use std::env;
use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::path::PathBuf;
use std::sync::Arc;

use goblet::scene::Scene;
use goblet::{DeviceOptions, LookupKind, Options, Renderer, open_device};
use goblet_host::Device;

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// Widths and heights of the image, which has a visible point per pixel.
const SIDES: [u32; 5] = [100, 256, 512, 1000, 2000];
/// Scene units; the room is 2 wide.
const RADII: [f64; 5] = [0.002, 0.006, 0.02, 0.06, 0.2];
const PHOTONS: u64 = 65_536;
/// Cells of other widths are tried with these.
const CELL_SIDE: u32 = 512;
const CELL_RADII: [f64; 2] = [0.006, 0.02];
const CELL_SCALES: [f64; 5] = [0.25, 0.5, 1.0, 2.0, 4.0];

/// Each way is measured so often, in turn with the others, and the least time counts:
/// other work on the machine only ever adds to it.
const REPEATS: u32 = 3;
/// What would take longer is left out, seconds of one query.
const LIMIT: f64 = 30.0;

/// Seconds, the least of all repeats.
#[derive(Clone, Copy, Debug)]
struct Times {
    build: f64,
    query: f64,
}

/// The hash grid and the kd-tree; nothing where it would take too long.
type Pair = Option<[Times; 2]>;

fn main() -> Result<()> {
    let folder = PathBuf::from(env::args_os().skip(1).find(|word| word != "--bench").unwrap_or_else(|| ".".into()));
    fs::create_dir_all(&folder)?;
    let scene = Scene::load("scenes/cornell-caustic.pbrt")?;
    let device = Arc::new(open_device(&DeviceOptions::default())?);
    println!("{}, {}; {PHOTONS} photons an iteration\n", device.info().name, device.info().driver);

    let mut table = Vec::new();
    for side in SIDES {
        table.push(measure_radii(&device, &scene, side)?);
    }
    fs::write(folder.join("lookup.csv"), csv(&table)?)?;
    println!("{}", markdown(&table)?);
    plot::write(&folder.join("lookup.svg"), &table)?;

    println!("{}", cell_scales(&device, &scene)?);
    Ok(())
}

fn points(side: u32) -> u64 {
    u64::from(side) * u64::from(side)
}

/// All radii for one number of points, as long as they do not take too long.
fn measure_radii(device: &Arc<Device>, scene: &Scene, side: u32) -> Result<[Pair; RADII.len()]> {
    let mut row: [Pair; RADII.len()] = [None; RADII.len()];
    for (i, radius) in RADII.into_iter().enumerate() {
        // The number of points on a disc grows with the square of its radius.
        let expected = |i: usize| {
            let longest = row[i]?.map(|times| times.query).into_iter().fold(0.0, f64::max);
            Some(longest * (radius / RADII[i]).powi(2))
        };
        let before = i.checked_sub(1);
        if before.is_some_and(|before| expected(before).is_none_or(|seconds| seconds > LIMIT)) {
            continue;
        }
        let ways = [LookupKind::HashGrid, LookupKind::KdTree].map(|lookup| (lookup, 1.0));
        let times = measure(device, scene, side, radius, &ways)?;
        eprintln!("{} points, radius {radius}: {times:?}", points(side));
        row[i] = Some([times[0], times[1]]);
    }
    Ok(row)
}

/// The least times of each way, a lookup and a cell scale, measured in turn. The images that
/// they make must not differ.
fn measure(
    device: &Arc<Device>,
    scene: &Scene,
    side: u32,
    radius: f64,
    ways: &[(LookupKind, f64)],
) -> Result<Vec<Times>> {
    let mut renderers = Vec::new();
    for (lookup, cell_scale) in ways {
        let options = Options {
            resolution: Some([side, side]),
            photons: Some(PHOTONS),
            radius: Some(radius),
            // Radii stay as they are.
            alpha: Some(1.0),
            lookup: *lookup,
            cell_scale: Some(*cell_scale),
            ..Options::default()
        };
        renderers.push(Renderer::new(Arc::clone(device), scene, &options)?);
    }
    let mut least = vec![Times { build: f64::INFINITY, query: f64::INFINITY }; ways.len()];
    // The first round finds memory that nobody has touched yet.
    for repeat in 0..=REPEATS {
        for (renderer, least) in renderers.iter_mut().zip(&mut least) {
            let before = spent(renderer);
            renderer.step()?;
            let after = spent(renderer);
            if repeat > 0 {
                least.build = least.build.min(after.build - before.build);
                least.query = least.query.min(after.query - before.query);
            }
        }
    }
    let images = renderers.iter().map(Renderer::resolve).collect::<std::result::Result<Vec<_>, _>>()?;
    if images.iter().any(|image| image.pixels != images[0].pixels) {
        return Err("the images differ".into());
    }
    Ok(least)
}

/// Time so far: the device's, and the host's part of building trees.
fn spent(renderer: &Renderer) -> Times {
    let mut times = Times { build: renderer.kd_build_time().as_secs_f64(), query: 0.0 };
    for (pass, time) in renderer.device().pass_times() {
        match pass {
            "grid_size" | "grid_count" | "grid_reserve" | "grid_fill" | "tree_fill" => {
                times.build += time.as_secs_f64()
            }
            "gather_grid" | "gather_tree" => times.query += time.as_secs_f64(),
            _ => {}
        }
    }
    times
}

fn csv(table: &[[Pair; RADII.len()]]) -> Result<String> {
    let mut text = String::from("points,radius,grid_build_s,tree_build_s,grid_query_s,tree_query_s\n");
    for (side, row) in SIDES.into_iter().zip(table) {
        for (radius, pair) in RADII.into_iter().zip(row) {
            if let Some([grid, tree]) = pair {
                let times = [grid.build, tree.build, grid.query, tree.query].map(|time| format!("{time:.6}"));
                writeln!(text, "{},{radius},{}", points(side), times.join(","))?;
            }
        }
    }
    Ok(text)
}

/// Milliseconds to three figures.
fn milliseconds(seconds: f64) -> String {
    let time = 1e3 * seconds;
    let digits = (2.0 - time.log10().floor()).clamp(0.0, 3.0) as usize;
    format!("{time:.digits$}")
}

fn markdown(table: &[[Pair; RADII.len()]]) -> Result<String> {
    let mut text = String::from("| points | build |");
    RADII.iter().try_for_each(|radius| write!(text, " r = {radius} |"))?;
    write!(text, "\n| --- | --- |{}", " --- |".repeat(RADII.len()))?;
    for (side, row) in SIDES.into_iter().zip(table) {
        let build = |i: usize| row.iter().flatten().map(|pair| pair[i].build).fold(f64::INFINITY, f64::min);
        let cell = |times: [f64; 2]| times.map(milliseconds).join(" / ");
        write!(text, "\n| {} | {} |", points(side), cell([build(0), build(1)]))?;
        for pair in row {
            let query = pair.map_or("-".to_owned(), |pair| cell(pair.map(|times| times.query)));
            write!(text, " {query} |")?;
        }
    }
    text.push('\n');
    Ok(text)
}

/// How wide the grid's cells should be.
fn cell_scales(device: &Arc<Device>, scene: &Scene) -> Result<String> {
    let mut text = String::from("| radius |");
    CELL_SCALES.iter().try_for_each(|scale| write!(text, " {scale} |"))?;
    write!(text, " kd-tree |\n| --- |{} --- |", " --- |".repeat(CELL_SCALES.len()))?;
    let mut ways = CELL_SCALES.map(|scale| (LookupKind::HashGrid, scale)).to_vec();
    ways.push((LookupKind::KdTree, 1.0));
    for radius in CELL_RADII {
        write!(text, "\n| {radius} |")?;
        for times in measure(device, scene, CELL_SIDE, radius, &ways)? {
            write!(text, " {} |", milliseconds(times.query))?;
        }
    }
    text.push('\n');
    Ok(text)
}
