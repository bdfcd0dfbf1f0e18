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
    /// Text at the left of the chart; may be empty.
    pub y_label: &'a str,
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
    /// Vertical bars: x, and from where to where; above 0.
    pub bars: Vec<(f64, [f64; 2])>,
}

/// Draws curves; later ones cover earlier ones.
///
/// # Errors
/// The backend fails; SVG does not.
pub fn draw(area: &Area<'_>, axes: Axes<'_>, curves: &[Curve]) -> Result<(), Box<dyn Error>> {
    let Axes { title, x_label, y_label, x, y } = axes;
    let [x_ticks, y_ticks] = [&x, &y].map(ticks);
    let mut builder = ChartBuilder::on(area);
    if !title.is_empty() {
        builder.caption(title, ("sans-serif", 17));
    }
    let mut chart = builder
        .margin(12)
        .x_label_area_size(42)
        .y_label_area_size(64)
        .build_cartesian_2d(x.log_scale().with_key_points(x_ticks), y.log_scale().with_key_points(y_ticks))?;
    chart
        .configure_mesh()
        .x_desc(x_label)
        .y_desc(y_label)
        .label_style(("sans-serif", 14))
        .axis_desc_style(("sans-serif", 15))
        .light_line_style(WHITE)
        .x_label_formatter(&|value| label(*value))
        .y_label_formatter(&|value| label(*value))
        .draw()?;
    for Curve { label, color, width, dashed, marked, points, bars } in curves {
        let style = color.stroke_width(*width);
        let line = if *dashed {
            chart.draw_series(DashedLineSeries::new(points.clone(), 6, 4, style))?
        } else {
            chart.draw_series(LineSeries::new(points.clone(), style))?
        };
        if let Some(label) = label {
            line.label(label).legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], style));
        }
        // A short line across each end.
        chart.draw_series(
            bars.iter()
                .flat_map(|(x, ends)| ends.map(|y| (*x, y)))
                .map(|end| EmptyElement::at(end) + PathElement::new(vec![(-3, 0), (4, 0)], color)),
        )?;
        chart.draw_series(bars.iter().map(|(x, ends)| PathElement::new(ends.map(|y| (*x, y)), color)))?;
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

/// The digits of the values at a logarithmic axis, by the number of them in a decade: the fewest that give an axis
/// four values.
const DIGITS: [&[f64]; 5] = [
    &[1.0],
    &[1.0, 2.0, 5.0],
    &[1.0, 2.0, 3.0, 5.0, 7.0],
    &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0],
    &[1.0, 1.2, 1.4, 1.6, 1.8, 2.0, 2.5, 3.0, 3.5, 4.0, 4.5, 5.0, 5.5, 6.0, 6.5, 7.0, 7.5, 8.0, 8.5, 9.0, 9.5],
];
/// Decades of an axis at most.
const MAX_DECADES: i32 = 40;

/// Returns the values that are written at an axis.
fn ticks(range: &Range<f64>) -> Vec<f64> {
    let first = range.start.log10().floor() as i32;
    let last = (range.end.log10().ceil() as i32).min(first.saturating_add(MAX_DECADES));
    // Of many decades, only some.
    let every = ((last - first) / 6 + 1) as usize;
    let of = |digits: &[f64]| -> Vec<f64> {
        let decades = (first..=last).filter(|decade| (decade.unsigned_abs() as usize).is_multiple_of(every));
        let all = decades.flat_map(|decade| digits.iter().map(move |digit| digit * 10_f64.powi(decade)));
        all.filter(|value| range.contains(value)).collect()
    };
    let found = DIGITS.iter().map(|digits| of(digits)).find(|ticks| ticks.len() >= 4);
    found.unwrap_or_else(|| of(DIGITS[DIGITS.len() - 1]))
}

/// Returns the text of a number at an axis.
fn label(value: f64) -> String {
    // Steps are products; an f64 would be written with its rounding error.
    let short = value as f32;
    if (1e-4..1e5).contains(&value) { short.to_string() } else { format!("{short:e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_short() {
        for (value, expected) in [(0.1 + 0.2, "0.3"), (5e4, "50000"), (2e6, "2e6"), (1e-5, "1e-5"), (0.7, "0.7")] {
            assert_eq!(label(value), expected);
        }
    }

    #[test]
    fn every_axis_has_several_values() {
        let texts = |range: Range<f64>| ticks(&range).into_iter().map(label).collect::<Vec<_>>().join(" ");
        assert_eq!(texts(0.02..0.064), "0.02 0.03 0.04 0.05 0.06");
        assert_eq!(texts(0.9..2.9), "0.9 0.95 1 1.2 1.4 1.6 1.8 2 2.5");
        assert_eq!(texts(0.5..40.0), "0.5 1 2 5 10 20");
        assert_eq!(texts(1e-6..2e6), "1e-6 0.001 1 1000 1e6");
        for start in 0..40 {
            let least = 10_f64.powf(f64::from(start) / 40.0);
            for decades in [0.5, 0.7, 1.0, 1.5, 2.5, 5.0, 9.0] {
                let count = ticks(&(least..least * 10_f64.powf(decades))).len();
                assert!((4..=11).contains(&count), "{least} {decades}: {count}");
            }
        }
    }
}
