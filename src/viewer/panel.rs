//! The panel: the status of the render and the controls.

mod camera;
mod compare;
mod files;
mod histogram;
mod look;
mod options;
mod parts;
mod pixel;
mod status;
#[cfg(test)]
mod tests;

use egui::containers::scroll_area::ScrollSource;
use egui::{Color32, Context, ScrollArea, SidePanel, Ui};

use super::layout::PANEL;
use super::session::{Effect, Session};

/// Shows the panel, if it is open. Returns what the window has to carry out.
pub fn show(context: &Context, session: &mut Session) -> Vec<Effect> {
    let mut effects = Vec::new();
    if session.has_panel {
        SidePanel::left("panel").resizable(false).exact_width(PANEL).show(context, |ui| {
            // An area that is dragged would take the keyboard's focus, and nobody would see where it is.
            let by = ScrollSource { drag: false, ..ScrollSource::ALL };
            ScrollArea::vertical()
                .auto_shrink(false)
                .scroll_source(by)
                .show(ui, |ui| contents(ui, session, &mut effects));
        });
    }
    effects
}

fn contents(ui: &mut Ui, session: &mut Session, effects: &mut Vec<Effect>) {
    status::show(ui, session, effects);
    ui.separator();
    look::show(ui, session);
    pixel::show(ui, session);
    // The message is above the sections that can be unfolded, so that it is always visible.
    if let Some(message) = &session.message {
        ui.separator();
        match message {
            Ok(text) => ui.label(text),
            Err(text) => ui.colored_label(Color32::LIGHT_RED, text),
        };
    }
    ui.separator();
    ui.collapsing("Histogram", |ui| histogram::show(ui, session));
    ui.collapsing("Compare", |ui| compare::show(ui, session, effects));
    ui.collapsing("Camera", |ui| camera::show(ui, session, effects));
    ui.collapsing("Render", |ui| options::show(ui, session));
    ui.collapsing("Time per pass", |ui| status::passes(ui, session));
    ui.collapsing("Guide", |ui| ui.label(session.status.guiding.sentences()));
    ui.collapsing("Files", |ui| files::show(ui, session, effects));
}
