//! The measurements as Markdown.

use super::error::{self, PBRT};
use super::growth::{Growth, Outcome, Point};
use super::measure::{Spread, Times, passes};
use super::scenes;
use goblet::study::machine::Machine;

pub fn machine(machine: &Machine) -> String {
    let Machine { goblet, commit, date, device, driver, cpus } = machine;
    let commit = commit.as_ref().map_or_else(String::new, |commit| format!(" ({commit})"));
    let cpus = cpus.map_or_else(String::new, |cpus| format!(", {cpus} CPU threads"));
    format!("goblet {goblet}{commit}, {date}\n\n{device}, {driver}{cpus}\n")
}

/// A table of cells; the first row is its head.
fn table(rows: &[Vec<String>]) -> String {
    let mut text = String::new();
    for (i, row) in rows.iter().enumerate() {
        text += &format!("| {} |\n", row.join(" | "));
        if i == 0 {
            text += &format!("|{}\n", " --- |".repeat(row.len()));
        }
    }
    text
}

/// Three figures; "-" for nothing.
fn figures(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return "-".into();
    }
    let digits = (2.0 - value.abs().log10().floor()).clamp(0.0, 4.0) as usize;
    format!("{value:.digits$}")
}

fn milliseconds(seconds: f64) -> String {
    figures(1e3 * seconds)
}

fn pair(Spread { least, median }: Spread) -> String {
    format!("{} / {}", milliseconds(least), milliseconds(median))
}

/// The first cell, and one for each scene.
fn row<T>(head: &str, all: &[T], cell: impl Fn(&T) -> String) -> Vec<String> {
    [head.to_owned()].into_iter().chain(all.iter().map(cell)).collect()
}

/// A column for each scene.
pub fn scenes(all: &[scenes::Measured]) -> String {
    let name =
        |scene: &scenes::Measured| scene.scene.trim_start_matches("scenes/").trim_end_matches(".pbrt").to_owned();
    let rate = |scene: &scenes::Measured, seconds: f64| figures(1e-6 * scene.photons as f64 / seconds);
    let mut rows = vec![
        row("", all, name),
        row("load, s", all, |scene| figures(scene.times.setup.load)),
        row("build, s", all, |scene| figures(scene.times.setup.build)),
        row("compile, s", all, |scene| figures(scene.times.setup.compile)),
        row("first iteration, ms", all, |scene| milliseconds(scene.times.warm_up.seconds)),
        row("iterations after it", all, |scene| scene.times.iterations.len().to_string()),
        row("iteration, ms", all, |scene| pair(scene.times.whole())),
        row("million photons/s", all, |scene| {
            let Spread { least, median } = scene.times.whole();
            format!("{} / {}", rate(scene, least), rate(scene, median))
        }),
    ];
    for pass in passes(all.iter().map(|scene| &scene.times)) {
        rows.push(row(pass, all, |scene| pair(scene.times.pass(pass))));
    }
    rows.push(row("rest", all, |scene| pair(scene.times.rest())));
    format!(
        "## Scenes\n\n{0}x{0} pixels, {1} photons an iteration; the least / the median of the iterations, in \
         milliseconds of the device by pass. *rest* is what is no pass's.\n\n{2}",
        scenes::SIDE,
        scenes::PHOTONS,
        table(&rows)
    )
}

/// A row for each checkpoint, with what pbrt takes ten times as long for.
pub fn error(measured: &error::Measured) -> String {
    let head =
        ["goblet until, s", "taken, s", "iterations", "error", "pbrt-v4 sppm, s", "error", "pbrt's error / goblet's"];
    let mut rows = vec![head.map(str::to_owned).to_vec()];
    for (checkpoint, (seconds, pbrt)) in measured.checkpoints.iter().zip(PBRT) {
        let reached = checkpoint.reached;
        let cell = |value: &dyn Fn(error::Moment) -> String| reached.map_or("-".into(), value);
        rows.push(vec![
            checkpoint.at.to_string(),
            cell(&|moment| format!("{:.2}", moment.seconds)),
            cell(&|moment| moment.iterations.to_string()),
            cell(&|moment| format!("{:.5}", moment.error)),
            seconds.to_string(),
            format!("{pbrt:.4}"),
            cell(&|moment| figures(pbrt / moment.error)),
        ]);
    }
    format!(
        "## Error at equal time\n\n{}, median of {} seed(s). Error: mean of (x - a)(x - b) / (m² + 0.01) in \
         luminance. pbrt-v4's figures are of another machine, with two cores.\n\n{}",
        measured.scene,
        measured.seeds.len(),
        table(&rows)
    )
}

/// A row for each size, and how times grow.
pub fn growth(growth: &Growth) -> String {
    let passes = passes(growth.measured().map(|(_, times)| times));
    let mut head: Vec<String> =
        [growth.series.name, "load, s", "build, s", "compile, s", "iteration"].map(str::to_owned).to_vec();
    head.extend(passes.iter().map(|pass| pass.to_string()));
    head.push("rest".into());
    let mut rows = vec![head];
    rows.extend(growth.points.iter().map(|point| size_row(point, &passes)));
    rows.push(slope_row(growth, &passes));
    format!(
        "## Growth with {}\n\nMilliseconds of an iteration and of its passes, the least of all. The last row has the \
         exponents that fit the sizes from {} on; a time of {} growth would have {}.\n\n{}",
        growth.series.name,
        growth.series.big,
        format!("{:?}", growth.series.order).to_lowercase(),
        growth.slopes(|times| times.whole().least).map_or("-".into(), |slopes| format!("{:.2}", slopes[1])),
        table(&rows)
    )
}

fn size_row(point: &Point, passes: &[&str]) -> Vec<String> {
    let mut cells = vec![point.size.to_string()];
    match &point.outcome {
        Outcome::Measured(times) => {
            cells.extend([times.setup.load, times.setup.build, times.setup.compile].map(figures));
            cells.push(milliseconds(times.whole().least));
            cells.extend(passes.iter().map(|pass| milliseconds(times.pass(pass).least)));
            cells.push(milliseconds(times.rest().least));
        }
        Outcome::Refused(why) => cells.push(format!("refused after {:.1} s: {why}", point.total)),
        Outcome::LeftOut(why) => cells.push(format!("left out: {why}")),
    }
    cells.resize(passes.len() + 6, String::new());
    cells
}

fn slope_row(growth: &Growth, passes: &[&str]) -> Vec<String> {
    let slope =
        |time: &dyn Fn(&Times) -> f64| growth.slopes(time).map_or("-".into(), |[measured, _]| format!("{measured:.2}"));
    let mut cells = vec!["exponent".to_owned()];
    cells.push(slope(&|times| times.setup.load));
    cells.push(slope(&|times| times.setup.build));
    cells.push(slope(&|times| times.setup.compile));
    cells.push(slope(&|times| times.whole().least));
    cells.extend(passes.iter().map(|pass| slope(&|times| times.pass(pass).least)));
    cells.push(slope(&|times| times.rest().least));
    cells
}
