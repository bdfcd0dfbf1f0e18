//! The values of the pixel under the cursor.

use egui::{Grid, RichText, Ui};

use super::parts::figure;
use crate::viewer::session::{Probe, Session};

/// Shows the values under the cursor. The lines are there without a cursor too, so that nothing jumps.
pub fn show(ui: &mut Ui, session: &Session) {
    let probe = session.probe();
    let place = probe.as_ref().map_or_else(
        || "pixel: point at the image".to_owned(),
        |Probe { pixel: [x, y], .. }| format!("pixel {x}, {y}"),
    );
    ui.label(place).on_hover_text("column and row from the upper left corner");
    let has_other = session.compared.other.is_some();
    Grid::new("pixel").num_columns(4).min_col_width(20.0).spacing([6.0, 2.0]).show(ui, |ui| {
        row(ui, "this", probe.as_ref(), probe.as_ref().map(|probe| probe.values));
        if has_other {
            row(ui, "other", probe.as_ref(), probe.as_ref().and_then(|probe| probe.other));
        }
    });
}

fn row(ui: &mut Ui, name: &str, probe: Option<&Probe>, values: Option<[f32; 3]>) {
    ui.label(RichText::new(name).small());
    match (probe, values) {
        (Some(probe), Some(values)) => {
            for (axis, value) in probe.quantity.axes().iter().zip(values) {
                ui.label(RichText::new(format!("{axis} {}", figure(value)).trim()).monospace().size(11.0));
            }
        }
        _ => drop(ui.label(RichText::new("-").monospace().size(11.0))),
    }
    ui.end_row();
}
