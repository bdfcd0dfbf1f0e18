//! Charts with two logarithmic axes, for measurements.

use std::error::Error;
use std::ops::Range;

use plotters::coord::Shift;
use plotters::prelude::*;

/// Colours of curves, readable on light and dark pages.
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

/// The area of a chart.
pub type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// The texts at a chart's edges, and the ranges of its axes.
pub struct Axes<'a> {
    /// Text above the chart.
    pub title: &'a str,
    /// Text below the chart.
    pub x_label: &'a str,
    /// Range from left to right, above 0.
    pub x: Range<f64>,
    /// Range from bottom to top, above 0.
    pub y: Range<f64>,
}

/// Points that a line joins, from left to right.
#[derive(Clone)]
pub struct Curve {
    /// Name in the legend; not in it without one.
    pub label: Option<String>,
    /// Colour of the line and its points.
    pub color: RGBColor,
    /// Width of the line in pixels.
    pub width: u32,
    /// Whether the line is dashed.
    pub dashed: bool,
    /// Whether each point is marked by a circle.
    pub marked: bool,
    /// Coordinates, above 0.
    pub points: Vec<(f64, f64)>,
}

/// Draws curves; later ones cover earlier ones.
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

/// Returns the text of a number at a logarithmic axis: that of 1, 2 and 5 of each decade, and none for
/// others, which would overlap.
fn label(value: f64) -> String {
    let decade = value.log10().floor() as i32;
    let digit = value / 10_f64.powi(decade);
    if [1.0, 2.0, 5.0, 10.0].iter().all(|shown| (digit - shown).abs() > 1e-6) {
        String::new()
    } else if (-4..5).contains(&decade) {
        // Steps are sums; an f64 would be written with its rounding error.
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
