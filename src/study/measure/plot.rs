//! The plots of a report, as SVG. The style sheet of the page replaces black and white by its own colours.

use std::error::Error;
use std::ops::Range;

use plotters::prelude::*;

use super::measured::{Measured, Point};
use super::results::Results;
use crate::study::chart::{self, Axes, COLORS, Curve};

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// A phone shows it at 0.75 of this size.
const SIZE: (u32, u32) = (460, 330);

const SECONDS: &str = "seconds of iterations";

/// A plot with its title.
pub struct Plot {
    /// The title.
    pub title: &'static str,
    /// One sentence on what it shows.
    pub caption: &'static str,
    /// An `svg` element.
    pub svg: String,
}

/// Returns every plot for which the results have data.
///
/// # Errors
/// The backend fails; SVG does not.
pub fn plots(results: &Results) -> Result<Vec<Plot>> {
    let relmse = |point: &Point| Some(point.relmse);
    let seconds = |point: &Point| point.seconds;
    let flip = |point: &Point| Some(point.flip);
    let photons = |point: &Point| point.photons as f64;
    let mut error = all(results, &seconds, &relmse);
    add_bars(&mut error, results, &|run| run.relmse);
    let mut perceived = all(results, &seconds, &flip);
    add_bars(&mut perceived, results, &|run| run.flip);
    let drawn = [
        lines(
            ["Error against time", "Lower is better. Bars reach from the least to the largest of the seeds."],
            [SECONDS, "relMSE"],
            &error,
        )?,
        lines(
            ["Noise and bias against time", "Whole lines: noise. Dashed lines: bias. Their sum is relMSE."],
            [SECONDS, "part of relMSE"],
            &noise_and_bias(results),
        )?,
        lines(
            ["Visible error against time", "Lower is better. Bars reach from the least to the largest of the seeds."],
            [SECONDS, "FLIP"],
            &perceived,
        )?,
        lines(
            ["Error against photons", "How much each photon is worth, whatever it costs in time."],
            ["photons emitted", "relMSE"],
            &all(results, &photons, &relmse),
        )?,
        lines(
            ["The least error for each time", "The line joins the points that no other point beats in less time."],
            [SECONDS, "relMSE"],
            &front(results),
        )?,
    ];
    Ok(drawn.into_iter().flatten().collect())
}

/// Returns the names of the kernels, the slowest over all settings first.
pub fn passes(results: &Results) -> Vec<&'static str> {
    let mut totals = std::collections::BTreeMap::new();
    for (name, seconds) in results.settings.iter().flat_map(|setting| &setting.passes) {
        *totals.entry(*name).or_insert(0.0) += seconds;
    }
    let mut names: Vec<(&'static str, f64)> = totals.into_iter().collect();
    names.sort_by(|a, b| b.1.total_cmp(&a.1));
    names.into_iter().map(|(name, _)| name).collect()
}

/// Returns the colour of a setting or of a pass.
pub fn color(index: usize) -> RGBColor {
    COLORS[index % COLORS.len()]
}

/// Returns whether the lines of a setting are dashed, because another one has its colour.
pub fn is_dashed(index: usize) -> bool {
    index >= COLORS.len()
}

/// Returns a curve for each setting, without the points that a logarithmic axis cannot show.
fn all(results: &Results, x: &dyn Fn(&Point) -> f64, y: &dyn Fn(&Point) -> Option<f64>) -> Vec<Curve> {
    let curve = |(i, setting): (usize, &Measured)| {
        let points = setting.points.iter().filter_map(|point| Some((x(point), y(point)?)));
        let points = points.filter(|(x, y)| *x > 0.0 && can_be_shown(*y) && x.is_finite()).collect();
        let (label, bars) = Default::default();
        Curve { label, color: color(i), width: 2, dashed: is_dashed(i), marked: true, points, bars }
    };
    results.settings.iter().enumerate().map(curve).collect()
}

fn can_be_shown(value: f64) -> bool {
    value > 0.0 && value.is_finite()
}

/// Adds a bar from the least to the largest value of the turns at each point, if there are several.
fn add_bars(curves: &mut [Curve], results: &Results, value: &dyn Fn(&super::measured::Run) -> f64) {
    for (curve, setting) in curves.iter_mut().zip(&results.settings) {
        for point in setting.points.iter().filter(|point| point.runs.len() > 1 && point.seconds > 0.0) {
            let values = point.runs.iter().map(value);
            let ends = values.fold([f64::INFINITY, 0.0], |[least, most], v| [least.min(v), most.max(v)]);
            if ends.into_iter().all(can_be_shown) {
                curve.bars.push((point.seconds, ends));
            }
        }
    }
}

fn noise_and_bias(results: &Results) -> Vec<Curve> {
    let seconds = |point: &Point| point.seconds;
    let noise = |point: &Point| point.separated.map(|separated| separated.noise);
    let bias = |point: &Point| point.separated.map(|separated| separated.bias);
    let mut curves = all(results, &seconds, &noise);
    for mut curve in all(results, &seconds, &bias) {
        (curve.dashed, curve.marked) = (true, false);
        curves.push(curve);
    }
    curves
}

/// Returns all points, and a line through those of the Pareto front.
fn front(results: &Results) -> Vec<Curve> {
    let alone =
        |curve: Curve| curve.points.clone().into_iter().map(move |at| Curve { points: vec![at], ..curve.clone() });
    let curves = all(results, &|point| point.seconds, &|point| Some(point.relmse));
    let mut curves: Vec<Curve> = curves.into_iter().flat_map(alone).collect();
    let points = results.settings.iter().flat_map(|setting| &setting.points);
    let mut best: Vec<(f64, f64)> = points
        .filter(|point| point.on_front && point.relmse > 0.0)
        .map(|point| (point.seconds, point.relmse))
        .collect();
    best.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (label, bars) = Default::default();
    curves.push(Curve { label, color: BLACK, width: 2, dashed: false, marked: false, points: best, bars });
    curves
}

/// Draws curves; `None` if they have no point.
fn lines([title, caption]: [&'static str; 2], labels: [&str; 2], curves: &[Curve]) -> Result<Option<Plot>> {
    let points = || curves.iter().flat_map(|curve| &curve.points);
    if points().next().is_none() {
        return Ok(None);
    }
    let bars = || curves.iter().flat_map(|curve| &curve.bars).flat_map(|(_, ends)| *ends);
    let [x, y] = [around(points().map(|point| point.0)), around(points().map(|point| point.1).chain(bars()))];
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        let [x_label, y_label] = labels;
        chart::draw(&area, Axes { title: "", x_label, y_label, x, y }, curves)?;
        area.present()?;
    }
    Ok(Some(Plot { title, caption, svg }))
}

/// Returns a range of values with a margin, at least half a decade wide.
fn around(values: impl Iterator<Item = f64>) -> Range<f64> {
    let (least, most) = values.fold((f64::INFINITY, 0.0_f64), |(least, most), v| (least.min(v), most.max(v)));
    let room = (3.2 * least / most).sqrt().max(1.15);
    least / room..most * room
}
