//! Files in the panel: the scene, and where to save.

use std::path::PathBuf;

use egui::{TextEdit, Ui};

use super::parts::{NAME, button};
use crate::viewer::bindings::Command;
use crate::viewer::dialog::Question;
use crate::viewer::session::{Effect, Session};

/// Shows the names of the files.
pub fn show(ui: &mut Ui, session: &mut Session, effects: &mut Vec<Effect>) {
    ui.label("scene");
    ui.horizontal(|ui| {
        let name = TextEdit::singleline(&mut session.scene_text).desired_width(NAME);
        ui.add(name).on_hover_text("or drop a file on the window");
        if ui.button("open").clicked() {
            let path = PathBuf::from(&session.scene_text);
            session.open(&path);
        }
    });
    button(ui, session, effects, "choose a scene", Command::Ask(Question::Scene), "Ctrl+O");
    ui.label("save to");
    ui.horizontal(|ui| {
        let name = TextEdit::singleline(&mut session.save_text).desired_width(NAME);
        ui.add(name)
            .on_hover_text("ends in .exr, .png or .checkpoint; a file that exists is kept, and a number is added");
        button(ui, session, effects, "save", Command::Save, "Ctrl+S");
    });
    button(ui, session, effects, "choose a file", Command::Ask(Question::Save), "Ctrl+Shift+S");
}
