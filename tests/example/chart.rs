//! Charts with two logarithmic axes, for the examples that measure.

use std::error::Error;
use std::ops::Range;

use plotters::coord::Shift;
use plotters::prelude::*;

pub type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// What is written at a chart's edges, and the part of the plane that it shows.
pub struct Axes<'a> {
    pub title: &'a str,
    pub x_label: &'a str,
    pub x: Range<f64>,
    pub y: Range<f64>,
}

/// Points that belong together, from left to right.
#[derive(Clone)]
pub struct Curve {
    /// In the legend, if there.
    pub label: Option<String>,
    pub color: RGBColor,
    pub width: u32,
    pub dashed: bool,
    /// Whether points are circles; else they are corners only.
    pub marked: bool,
    pub points: Vec<(f64, f64)>,
}

/// Draws curves, the last on top.
pub fn draw(area: &Area<'_>, axes: Axes<'_>, curves: &[Curve]) -> Result<(), Box<dyn Error>> {
    let mut chart = ChartBuilder::on(area)
        .caption(axes.title, ("sans-serif", 17))
        .margin(12)
        .x_label_area_size(40)
        .y_label_area_size(56)
        .build_cartesian_2d(axes.x.log_scale(), axes.y.log_scale())?;
    // Steps are sums, which f64 would show the rounding of.
    let number = |value: &f64| (*value as f32).to_string();
    chart
        .configure_mesh()
        .x_desc(axes.x_label)
        .light_line_style(WHITE)
        .x_label_formatter(&number)
        .y_label_formatter(&number)
        .draw()?;
    for Curve { label, color, width, dashed, marked, points } in curves {
        let style = color.stroke_width(*width);
        let line = if *dashed {
            chart.draw_series(DashedLineSeries::new(points.clone(), 6, 4, style))?
        } else {
            chart.draw_series(LineSeries::new(points.clone(), style))?
        };
        if let Some(label) = label {
            line.label(label).legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], style));
        }
        if *marked {
            chart.draw_series(points.iter().map(|point| Circle::new(*point, 3, style)))?;
        }
    }
    if curves.iter().any(|curve| curve.label.is_some()) {
        let mut legend = chart.configure_series_labels();
        legend.position(SeriesLabelPosition::UpperLeft).background_style(WHITE).border_style(BLACK).draw()?;
    }
    Ok(())
}
