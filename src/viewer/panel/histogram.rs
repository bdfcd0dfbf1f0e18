//! The histogram of the picture.

use egui::{Color32, Rect, RichText, Sense, Stroke, Ui, pos2, vec2};

use super::parts::{between, figure};
use crate::cli::stats::percent;
use crate::viewer::histogram::{BINS, Histogram};
use crate::viewer::paint::Shade;
use crate::viewer::session::Session;

/// Height of the plot in points.
const HEIGHT: f32 = 80.0;
/// Colours of three axes, and of one.
const COLORS: [Color32; 3] = [
    Color32::from_rgba_premultiplied(150, 30, 30, 60),
    Color32::from_rgba_premultiplied(30, 130, 30, 60),
    Color32::from_rgba_premultiplied(40, 60, 160, 60),
];
const ONE_COLOR: Color32 = Color32::from_rgb(150, 150, 150);

/// Shows how many pixels have which value.
pub fn show(ui: &mut Ui, session: &mut Session) {
    let white = (session.colors.shade(session.quantity) == Shade::Light).then(|| (-session.look.stops).exp2());
    let unit = session.unit();
    let Some(histogram) = session.histogram() else {
        ui.label("there is no picture yet");
        return;
    };
    plot(ui, histogram, white);
    let [first, last] = histogram.ends.map(figure);
    between(ui, &first, &last);
    let kind = if histogram.is_log { "logarithmic" } else { "linear" };
    let mut text = if unit.is_empty() { format!("{kind} scale") } else { format!("{unit}, {kind} scale") };
    if white.is_some() {
        text += "; line: white";
    }
    if histogram.left_out > 0.0 {
        text += &format!("; {} of the values are 0 or less", percent(f64::from(histogram.left_out)));
    }
    ui.label(RichText::new(text).small());
}

fn plot(ui: &mut Ui, histogram: &Histogram, white: Option<f32>) {
    let (plot, _) = ui.allocate_exact_size(vec2(ui.available_width(), HEIGHT), Sense::hover());
    let painter = ui.painter_at(plot);
    painter.rect_filled(plot, 2.0, Color32::from_gray(12));
    let inner = 1..BINS - 1;
    // The bins at the ends have what is beyond them, which may be most of the picture.
    let highest = histogram.shares.iter().flat_map(|shares| &shares[inner.clone()]).fold(0.0_f32, |a, b| a.max(*b));
    let highest = if highest > 0.0 { highest } else { 1.0 };
    let colors = if histogram.shares.len() == 1 { &[ONE_COLOR][..] } else { &COLORS };
    let width = plot.width() / BINS as f32;
    for (shares, color) in histogram.shares.iter().zip(colors) {
        for (bin, share) in shares.iter().enumerate() {
            // Roots, so that rare values are seen beside frequent ones.
            let height = (share / highest).min(1.0).sqrt() * (plot.height() - 2.0);
            let left = plot.left() + bin as f32 * width;
            let bar = Rect::from_min_max(pos2(left, plot.bottom() - height), pos2(left + width, plot.bottom()));
            painter.rect_filled(bar, 0.0, *color);
        }
    }
    if let Some(place) = white.map(|white| histogram.place(white)).filter(|place| (0.0..=1.0).contains(place)) {
        painter.vline(plot.left() + place * plot.width(), plot.y_range(), Stroke::new(1.0, Color32::WHITE));
    }
}
