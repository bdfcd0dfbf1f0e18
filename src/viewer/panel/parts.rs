//! Parts that the sections of the panel share.

use egui::{Align, Layout, Ui};

use crate::viewer::bindings::Command;
use crate::viewer::session::{Effect, Session};

/// Width of the field for a file name, in points.
pub const NAME: f32 = 190.0;

/// Shows a button that gives a command, with its key as a hint.
pub fn button(ui: &mut Ui, session: &mut Session, effects: &mut Vec<Effect>, text: &str, command: Command, hint: &str) {
    if ui.button(text).on_hover_text(hint).clicked() {
        effects.extend(session.obey(command));
    }
}

/// Writes a value with about five digits.
pub fn figure(value: f32) -> String {
    let size = value.abs();
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    if !(1e-3..1e5).contains(&size) {
        return format!("{value:.3e}");
    }
    let before = size.log10().floor().max(0.0) as usize;
    format!("{value:.0$}", 4 - before.min(4))
}

/// Shows a text at the left and one at the right.
pub fn between(ui: &mut Ui, first: &str, last: &str) {
    ui.horizontal(|ui| {
        ui.label(first);
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| ui.label(last));
    });
}
