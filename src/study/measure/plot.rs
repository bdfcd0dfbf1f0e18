//! The plots of a report, as SVG. The style sheet of the page replaces black and white by its own colours.

use std::error::Error;
use std::ops::Range;

use plotters::prelude::*;

use super::results::{Measured, Point, Results};
use crate::study::chart::{self, Axes, COLORS, Curve};

type Result<T> = std::result::Result<T, Box<dyn Error>>;

const SIZE: (u32, u32) = (620, 400);

/// A plot with its title.
pub struct Plot {
    /// The title.
    pub title: &'static str,
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
    let mut plots = Vec::new();
    plots.extend(lines("relMSE against time", "seconds of iterations", &all(results, &seconds, &relmse))?);
    let photons = |point: &Point| point.photons as f64;
    plots.extend(lines("relMSE against photons", "photons", &all(results, &photons, &relmse))?);
    plots.extend(lines("Pareto front over all settings", "seconds of iterations", &front(results))?);
    let noise = |point: &Point| point.separated.map(|separated| separated.noise);
    let bias = |point: &Point| point.separated.map(|separated| separated.bias);
    let mut separated = all(results, &seconds, &noise);
    for mut curve in all(results, &seconds, &bias) {
        (curve.dashed, curve.marked) = (true, false);
        separated.push(curve);
    }
    plots.extend(lines("Noise (whole lines) and bias (dashed), relMSE", "seconds of iterations", &separated)?);
    let flip = |point: &Point| Some(point.flip);
    plots.extend(lines("FLIP against time", "seconds of iterations", &all(results, &seconds, &flip))?);
    plots.push(stack(results)?);
    Ok(plots)
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

/// Returns a curve for each setting, without the points that a logarithmic axis cannot show.
fn all(results: &Results, x: &dyn Fn(&Point) -> f64, y: &dyn Fn(&Point) -> Option<f64>) -> Vec<Curve> {
    let curve = |(i, setting): (usize, &Measured)| {
        let points = setting.points.iter().filter_map(|point| Some((x(point), y(point)?)));
        let points = points.filter(|(x, y)| *x > 0.0 && *y > 0.0 && x.is_finite() && y.is_finite()).collect();
        Curve { label: None, color: color(i), width: 2, dashed: i >= COLORS.len(), marked: true, points }
    };
    results.settings.iter().enumerate().map(curve).collect()
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
    curves.push(Curve { label: None, color: BLACK, width: 2, dashed: false, marked: false, points: best });
    curves
}

/// Draws curves; `None` if they have no point.
fn lines(title: &'static str, x_label: &str, curves: &[Curve]) -> Result<Option<Plot>> {
    let points = || curves.iter().flat_map(|curve| &curve.points);
    if points().next().is_none() {
        return Ok(None);
    }
    let [x, y] = [around(points().map(|point| point.0)), around(points().map(|point| point.1))];
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        chart::draw(&area, Axes { title, x_label, x, y }, curves)?;
        area.present()?;
    }
    Ok(Some(Plot { title, svg }))
}

/// Returns a range of values with a margin, at least half a decade wide.
fn around(values: impl Iterator<Item = f64>) -> Range<f64> {
    let (least, most) = values.fold((f64::INFINITY, 0.0_f64), |(least, most), v| (least.min(v), most.max(v)));
    let room = (3.2 * least / most).sqrt().max(1.15);
    least / room..most * room
}

/// Draws a bar for each setting: the times of its passes in an iteration.
fn stack(results: &Results) -> Result<Plot> {
    let title = "Time of an iteration by pass, milliseconds";
    let settings = &results.settings;
    let total = |setting: &Measured| 1e3 * setting.passes.values().sum::<f64>();
    let most = settings.iter().map(total).fold(f64::MIN_POSITIVE, f64::max);
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        let mut chart = ChartBuilder::on(&area)
            .caption(title, ("sans-serif", 17))
            .margin(12)
            .x_label_area_size(40)
            .y_label_area_size(56)
            .build_cartesian_2d(0.0..settings.len() as f64, 0.0..1.05 * most)?;
        let number = |value: &f64| (*value as f32).to_string();
        chart
            .configure_mesh()
            .disable_x_mesh()
            .x_labels(0)
            .x_desc("settings, in their order")
            .light_line_style(WHITE)
            .y_label_formatter(&number)
            .draw()?;
        for (i, setting) in settings.iter().enumerate() {
            let mut from = 0.0;
            for (pass, name) in passes(results).into_iter().enumerate() {
                let to = from + 1e3 * setting.passes.get(name).copied().unwrap_or(0.0);
                let corners = [(i as f64 + 0.15, from), (i as f64 + 0.85, to)];
                chart.draw_series([Rectangle::new(corners, color(pass).filled())])?;
                from = to;
            }
        }
        area.present()?;
    }
    Ok(Plot { title, svg })
}
