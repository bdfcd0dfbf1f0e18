//! Pictures of growth and of the error, which can be read on light and dark pages.

use std::path::Path;

use plotters::prelude::*;

use super::Result;
use super::error::{self, PBRT};
use super::growth::Growth;
use super::measure::{Times, passes};
use goblet::study::chart::{self, Area, Axes, COLORS, Curve};

const SIZE: (u32, u32) = (860, 480);
const LEGEND_WIDTH: u32 = 190;

/// Writes an SVG of the times of a series. Nothing is written where nothing was measured.
pub fn growth(path: &Path, growth: &Growth) -> Result<()> {
    let name = growth.series.name;
    let title = format!("Time of an iteration, ms, over the number of {name}");
    write(path, &title, name, &growth_curves(growth))
}

fn growth_curves(growth: &Growth) -> Vec<(String, Curve)> {
    let line = |time: &dyn Fn(&Times) -> f64| {
        let points = growth.measured().map(|(point, times)| (point.size as f64, 1e3 * time(times)));
        points.filter(|point| point.1 > 0.0).collect::<Vec<_>>()
    };
    let mut curves = Vec::new();
    if let Some((first, times)) = growth.big().next() {
        let order = growth.series.order;
        let unit = 1e3 * times.whole().least / order.at(first.size);
        let points = growth.measured().map(|(point, _)| (point.size as f64, unit * order.at(point.size))).collect();
        let name = format!("{order:?}").to_lowercase();
        curves.push((
            name,
            Curve { label: None, color: BLACK, width: 1, dashed: true, marked: false, points, bars: Vec::new() },
        ));
    }
    curves.push(("iteration".into(), marked(BLACK, line(&|times| times.whole().least))));
    let passes = passes(growth.measured().map(|(_, times)| times));
    for (pass, color) in passes.into_iter().zip(COLORS.into_iter().cycle()) {
        curves.push((pass.into(), marked(color, line(&|times| times.pass(pass).least))));
    }
    curves
}

fn marked(color: RGBColor, points: Vec<(f64, f64)>) -> Curve {
    Curve { label: None, color, width: 2, dashed: false, marked: true, points, bars: Vec::new() }
}

/// Writes an SVG of the errors of all seeds over time, and of pbrt's.
pub fn error(path: &Path, measured: &error::Measured) -> Result<()> {
    let mut curves = Vec::new();
    for (seed, color) in measured.seeds.iter().zip(COLORS.into_iter().cycle()) {
        let moments = seed.moments.iter().map(|moment| (moment.seconds, moment.error));
        let curve = marked(color, moments.filter(|point| point.1 > 0.0).collect());
        // Circles of many points would hide the line.
        let curve = Curve { marked: curve.points.len() < 100, ..curve };
        curves.push((format!("goblet, seed {}", seed.seed), curve));
    }
    curves.push(("pbrt-v4 sppm".into(), marked(BLACK, PBRT.to_vec())));
    write(path, "Error over seconds", "seconds", &curves)
}

/// A chart, and the names of its curves beside it.
fn write(path: &Path, title: &str, x_label: &str, named: &[(String, Curve)]) -> Result<()> {
    let all = || named.iter().flat_map(|(_, curve)| &curve.points);
    let (Some(x), Some(y)) = (range(all().map(|point| point.0)), range(all().map(|point| point.1))) else {
        return Ok(());
    };
    let root = SVGBackend::new(path, SIZE).into_drawing_area();
    root.fill(&WHITE)?;
    let (left, right) = root.split_horizontally(SIZE.0 - LEGEND_WIDTH);
    let curves: Vec<Curve> = named.iter().map(|(_, curve)| curve.clone()).collect();
    chart::draw(&left, Axes { title, x_label, y_label: "", x, y }, &curves)?;
    legend(&right, named)?;
    Ok(root.present()?)
}

/// From the least to the most and a little further; nothing of nothing.
fn range(values: impl Iterator<Item = f64>) -> Option<std::ops::Range<f64>> {
    let (least, most) =
        values.fold((f64::INFINITY, 0.0), |(least, most): (f64, f64), value| (least.min(value), most.max(value)));
    (least <= most).then_some(0.7 * least..1.5 * most)
}

fn legend(area: &Area<'_>, named: &[(String, Curve)]) -> Result<()> {
    for (i, (name, curve)) in named.iter().enumerate() {
        let y = 50 + 20 * i as i32;
        let style = curve.color.stroke_width(curve.width);
        // Long and short, as the lines themselves.
        let dashes = if curve.dashed { vec![(0, 6), (10, 16), (20, 24)] } else { vec![(0, 24)] };
        for (from, to) in dashes {
            area.draw(&PathElement::new([(from, y), (to, y)], style))?;
        }
        area.draw(&Text::new(name.clone(), (30, y - 6), ("sans-serif", 13)))?;
    }
    Ok(())
}
