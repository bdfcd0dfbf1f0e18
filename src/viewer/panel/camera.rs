//! The camera in the panel: field of view, lens, undo.

use egui::{DragValue, Slider, Ui};

use super::parts::button;
use crate::viewer::bindings::Command;
use crate::viewer::camera_control::FIELDS_OF_VIEW;
use crate::viewer::session::{Effect, Session};

/// Shows the controls of the camera.
pub fn show(ui: &mut Ui, session: &mut Session, effects: &mut Vec<Effect>) {
    field_of_view(ui, session);
    lens(ui, session);
    let [before, after] = session.steps();
    ui.horizontal(|ui| {
        ui.add_enabled_ui(before > 0, |ui| button(ui, session, effects, "undo", Command::Undo, "Ctrl+Z"));
        ui.add_enabled_ui(after > 0, |ui| button(ui, session, effects, "redo", Command::Redo, "Ctrl+Y"));
        button(ui, session, effects, "reset", Command::Reset, "R");
        button(ui, session, effects, "copy as pbrt", Command::Copy, "C");
    });
}

fn field_of_view(ui: &mut Ui, session: &mut Session) {
    let Some(before) = session.control.field_of_view() else { return };
    let mut degrees = before;
    let slider = Slider::new(&mut degrees, FIELDS_OF_VIEW[0]..=FIELDS_OF_VIEW[1]).text("field of view").suffix("°");
    ui.add(slider.fixed_decimals(1)).on_hover_text("along the shorter side of the image; [ and ] change it");
    if degrees != before {
        session.moves(|control| control.set_field_of_view(degrees));
    }
}

fn lens(ui: &mut Ui, session: &mut Session) {
    let camera = *session.control.camera();
    let (mut radius, mut focus) = (camera.lens_radius, camera.focal_distance);
    let scale = 1e-3 * session.control.distance();
    ui.horizontal(|ui| {
        ui.label("aperture");
        let radius = DragValue::new(&mut radius).range(0.0..=1e3 * scale).speed(0.05 * scale);
        ui.add(radius.clamp_existing_to_range(false)).on_hover_text("radius of the lens in scene units");
        ui.label("focus");
        let focus = DragValue::new(&mut focus).range(scale..=f64::MAX).speed(scale);
        ui.add(focus.clamp_existing_to_range(false)).on_hover_text("distance of what is sharp, in scene units");
    });
    if (radius, focus) != (camera.lens_radius, camera.focal_distance) {
        session.moves(|control| control.set_lens(radius, focus));
    }
}
