//! Charts with two logarithmic axes, for measurements.

use std::error::Error;
use std::ops::Range;

use plotters::coord::Shift;
use plotters::prelude::*;

/// For what has no colour of its own: readable on light and dark pages.
pub const COLORS: [RGBColor; 10] = [
    RGBColor(57, 119, 214),
    RGBColor(224, 140, 20),
    RGBColor(33, 155, 140),
    RGBColor(215, 75, 85),
    RGBColor(94, 171, 69),
    RGBColor(160, 90, 190),
    RGBColor(160, 118, 75),
    RGBColor(130, 130, 130),
    RGBColor(220, 100, 170),
    RGBColor(110, 160, 220),
];

/// Where charts are drawn.
pub type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// What is written at a chart's edges, and the part of the plane that it shows.
pub struct Axes<'a> {
    /// Above it.
    pub title: &'a str,
    /// Below it.
    pub x_label: &'a str,
    /// From left to right, above 0.
    pub x: Range<f64>,
    /// From bottom to top, above 0.
    pub y: Range<f64>,
}

/// Points that belong together, from left to right.
#[derive(Clone)]
pub struct Curve {
    /// In the legend, if there.
    pub label: Option<String>,
    /// Of the line and its points.
    pub color: RGBColor,
    /// Pixels.
    pub width: u32,
    /// Or a whole line.
    pub dashed: bool,
    /// Whether points are circles; else they are corners only.
    pub marked: bool,
    /// Values, above 0.
    pub points: Vec<(f64, f64)>,
}

/// Draws curves, the last on top.
///
/// # Errors
/// The backend fails; SVG does not.
pub fn draw(area: &Area<'_>, axes: Axes<'_>, curves: &[Curve]) -> Result<(), Box<dyn Error>> {
    let mut chart = ChartBuilder::on(area)
        .caption(axes.title, ("sans-serif", 17))
        .margin(12)
        .x_label_area_size(40)
        .y_label_area_size(56)
        .build_cartesian_2d(axes.x.log_scale(), axes.y.log_scale())?;
    chart
        .configure_mesh()
        .x_desc(axes.x_label)
        .light_line_style(WHITE)
        .x_label_formatter(&|value| label(*value))
        .y_label_formatter(&|value| label(*value))
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

/// A number at a logarithmic axis: 1, 2 and 5 of each decade; others would overlap.
fn label(value: f64) -> String {
    let decade = value.log10().floor() as i32;
    let digit = value / 10_f64.powi(decade);
    if [1.0, 2.0, 5.0, 10.0].iter().all(|shown| (digit - shown).abs() > 1e-6) {
        String::new()
    } else if (-4..5).contains(&decade) {
        // Steps are sums, which f64 would show the rounding of.
        (value as f32).to_string()
    } else {
        format!("{:e}", value as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_few_and_short() {
        for (value, expected) in
            [(0.1 + 0.2, ""), (0.2, "0.2"), (5e4, "50000"), (2e6, "2e6"), (1e-5, "1e-5"), (7.0, "")]
        {
            assert_eq!(label(value), expected);
        }
        assert_eq!(label(0.1 + 0.1), "0.2");
    }
}
