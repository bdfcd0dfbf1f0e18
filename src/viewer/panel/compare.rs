//! Comparison with a kept image or an image file.

use std::path::PathBuf;

use egui::{Color32, Grid, Slider, TextEdit, Ui};

use super::parts::{NAME, button};
use crate::viewer::bindings::Command;
use crate::viewer::compared::Beside;
use crate::viewer::dialog::Question;
use crate::viewer::session::{Effect, Session};

/// Shows what is compared, which of both is shown, and the error.
pub fn show(ui: &mut Ui, session: &mut Session, effects: &mut Vec<Effect>) {
    ui.horizontal(|ui| {
        button(ui, session, effects, "keep this image", Command::Keep, "K");
        button(ui, session, effects, "choose a file", Command::Ask(Question::Reference), "Ctrl+B");
    });
    ui.horizontal(|ui| {
        let name = TextEdit::singleline(&mut session.reference_text).desired_width(NAME).hint_text("image file");
        ui.add(name).on_hover_text("an EXR, PNG, PFM, HDR, JPEG or TGA; or drop it on the window");
        if ui.button("read").clicked() && !session.reference_text.is_empty() {
            let path = PathBuf::from(&session.reference_text);
            session.compare_with(&path);
        }
    });
    let Some(other) = &session.compared.other else { return };
    ui.label(format!("other: {}", other.name));
    if let Some(refusal) = session.refusal() {
        ui.colored_label(Color32::LIGHT_RED, refusal);
        let sizes = session.compared.other.as_ref().map(|other| other.picture.size);
        if sizes != Some(session.image()) && ui.button("render at its size").clicked() {
            session.take_size_of_other();
        }
    } else {
        choice(ui, session);
        error(ui, session);
    }
    if ui.button("end the comparison").clicked() {
        session.forget_other();
    }
}

fn choice(ui: &mut Ui, session: &mut Session) {
    let mut beside = session.compared.beside;
    ui.horizontal(|ui| {
        ui.selectable_value(&mut beside, Beside::Current, "this");
        ui.selectable_value(&mut beside, Beside::Other, "other").on_hover_text("B");
        let is_split = matches!(beside, Beside::Split(_));
        if ui.selectable_label(is_split, "both").on_hover_text("V").clicked() && !is_split {
            beside = Beside::Split(0.5);
        }
    });
    if let Beside::Split(line) = &mut beside {
        ui.add(Slider::new(line, 0.0..=1.0).text("line").show_value(false)).on_hover_text(", and . move it");
    }
    if beside != session.compared.beside {
        session.set_beside(beside);
    }
}

fn error(ui: &mut Ui, session: &Session) {
    let Some(error) = &session.compared.error else {
        ui.label("error: measured once the image is not coarse");
        return;
    };
    Grid::new("error").num_columns(2).show(ui, |ui| {
        for (name, value, hint) in [
            ("relMSE", format!("{:.4e}", error.relmse), "mean of (this - other)² / (other² + 0.01)"),
            ("ratio of means", format!("{:.4}", error.energy_ratio), "mean of this over mean of the other"),
        ] {
            ui.label(name).on_hover_text(hint);
            ui.label(value);
            ui.end_row();
        }
    });
}
