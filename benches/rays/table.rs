//! The table.

use goblet::DeviceKind;

use crate::measure::{Case, Times};

/// A line of Markdown for each case; `benches/rays/embree.py` prints the same.
pub fn markdown(cases: &[Case], kind: DeviceKind) -> String {
    let mut text = String::from(
        "| scene | triangles | rays | nearest Mray/CPU s | nearest Mray/s | any Mray/CPU s | any Mray/s | spread | hits |\n\
         | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n",
    );
    cases.iter().for_each(|case| text += &row(case, kind));
    text
}

fn row(case: &Case, kind: DeviceKind) -> String {
    let [cpu, wall]: [fn(&Times) -> f64; 2] = [|times| times.cpu, |times| times.wall];
    // The CPU waits for a GPU, and its time says nothing.
    let steady = if kind == DeviceKind::Cpu { cpu } else { wall };
    let rates = case.times.each_ref().map(|times| {
        let rate = |of| case.count as f64 * 1e-6 / median(times, of);
        format!("{:.2} | {:.2}", rate(cpu), rate(wall))
    });
    let spread = case.times.iter().map(|times| spread(times, steady)).fold(0.0, f64::max);
    let [nearest, any] = case.hits;
    // Both are the same, unless alpha cuts surfaces away or the driver has ended a loop early.
    let hits = if nearest == any { nearest.to_string() } else { format!("{nearest}, any {any}") };
    format!(
        "| {} | {} | {} | {} | {} | {:.0} % | {hits} |\n",
        case.scene,
        case.triangles,
        case.set.name(),
        rates[0],
        rates[1],
        100.0 * spread
    )
}

fn sorted(times: &[Times], of: fn(&Times) -> f64) -> Vec<f64> {
    let mut seconds: Vec<f64> = times.iter().map(of).collect();
    seconds.sort_by(f64::total_cmp);
    seconds
}

fn median(times: &[Times], of: fn(&Times) -> f64) -> f64 {
    let seconds = sorted(times, of);
    0.5 * (seconds[(seconds.len() - 1) / 2] + seconds[seconds.len() / 2])
}

/// The longest less the shortest time, over the median.
fn spread(times: &[Times], of: fn(&Times) -> f64) -> f64 {
    let seconds = sorted(times, of);
    (seconds[seconds.len() - 1] - seconds[0]) / median(times, of)
}
