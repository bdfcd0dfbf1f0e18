//! The picture of the measurements: times over the number of points.

use std::error::Error;
use std::path::Path;

use plotters::prelude::*;

use super::{Pair, RADII, SIDES, points};
use goblet::study::chart::{self, Area, Axes, Curve};

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// From the smallest radius to the largest.
const COLORS: [RGBColor; RADII.len()] =
    [RGBColor(68, 1, 84), RGBColor(59, 82, 139), RGBColor(33, 145, 140), RGBColor(94, 171, 69), RGBColor(224, 150, 20)];

/// Milliseconds over points: of the grid, and of the tree.
struct Curves {
    label: String,
    color: RGBColor,
    ways: [Vec<(f64, f64)>; 2],
}

/// Writes an SVG of two charts, to build and to query.
pub fn write(path: &Path, table: &[[Pair; RADII.len()]]) -> Result<()> {
    let root = SVGBackend::new(path, (1000, 480)).into_drawing_area();
    root.fill(&WHITE)?;
    let (left, right) = root.split_horizontally(420);
    let build = |i: usize| line(table, |row| row.iter().flatten().map(|pair| pair[i].build).min_by(f64::total_cmp));
    let build = Curves { label: "any radius".to_owned(), color: BLACK, ways: [build(0), build(1)] };
    chart(&left, "Build, ms", vec![build])?;
    let query = |(radius, color): (usize, RGBColor)| {
        let way = |i: usize| line(table, |row| row[radius].map(|pair| pair[i].query));
        Curves { label: format!("r = {}", RADII[radius]), color, ways: [way(0), way(1)] }
    };
    let queries = COLORS.into_iter().enumerate().map(query).collect();
    chart(&right, "Query, ms (solid: hash grid, dashed: kd-tree)", queries)?;
    root.present()?;
    Ok(())
}

/// A point for each row that has a time.
fn line(table: &[[Pair; RADII.len()]], seconds: impl Fn(&[Pair; RADII.len()]) -> Option<f64>) -> Vec<(f64, f64)> {
    let at = |(side, row)| Some((points(side) as f64, 1e3 * seconds(row)?));
    SIDES.into_iter().zip(table).filter_map(at).collect()
}

fn chart(area: &Area<'_>, title: &str, all: Vec<Curves>) -> Result<()> {
    let times = || all.iter().flat_map(|curves| curves.ways.iter().flatten()).map(|point| point.1);
    let (least, most) = (times().fold(f64::INFINITY, f64::min), times().fold(0.0, f64::max));
    let axes = Axes { title, x_label: "visible points", y_label: "", x: 8e3..5e6, y: 0.7 * least..1.5 * most };
    let pair = |Curves { label, color, ways: [grid, tree] }| {
        let grid =
            Curve { label: Some(label), color, width: 2, dashed: false, marked: true, points: grid, bars: Vec::new() };
        [grid, Curve { label: None, color, width: 2, dashed: true, marked: true, points: tree, bars: Vec::new() }]
    };
    chart::draw(area, axes, &all.into_iter().flat_map(pair).collect::<Vec<_>>())
}
