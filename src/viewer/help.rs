//! The list of keys, above the image.

use egui::{Align2, Context, Grid, RichText, ScrollArea, Ui, Window};

use super::bindings::{Binding, MOUSE, PARTS};
use super::session::Session;

/// The width of a window in points from which the list has three columns.
const THREE_COLUMNS: f32 = 1000.0;
/// The space around the list in points, with its title.
const AROUND: f32 = 70.0;

/// Shows the list of keys, if it is open.
pub fn show(context: &Context, session: &mut Session) {
    let screen = context.content_rect();
    let window = Window::new("Keys and mouse").open(&mut session.has_keys).collapsible(false).resizable(false);
    window.anchor(Align2::CENTER_CENTER, [0.0, 0.0]).show(context, |ui| {
        let height = (screen.height() - AROUND).max(100.0);
        ScrollArea::vertical().max_height(height).min_scrolled_height(height).show(ui, |ui| {
            if screen.width() < THREE_COLUMNS {
                PARTS[..].iter().for_each(|(title, keys)| part(ui, title, keys));
                mouse(ui);
            } else {
                columns(ui);
            }
            ui.label(RichText::new("Keys act on the image while no text is being typed.").small());
        });
    });
}

/// Shows the list in columns of about the same height.
fn columns(ui: &mut Ui) {
    let [camera, others @ ..] = &PARTS[..] else { return };
    let (image, window) = others.split_at(2);
    ui.horizontal_top(|ui| {
        ui.vertical(|ui| {
            part(ui, camera.0, camera.1);
            mouse(ui);
        });
        for parts in [image, window] {
            ui.add_space(10.0);
            ui.vertical(|ui| parts.iter().for_each(|(title, keys)| part(ui, title, keys)));
        }
    });
}

fn part(ui: &mut Ui, title: &str, keys: &[Binding]) {
    let rows: Vec<(String, String)> = keys.iter().map(|binding| (binding.name(), binding.help())).collect();
    rows_of(ui, title, rows.iter().map(|(name, help)| (name.as_str(), help.as_str())));
}

fn mouse(ui: &mut Ui) {
    rows_of(ui, "Mouse", MOUSE.into_iter());
}

fn rows_of<'a>(ui: &mut Ui, title: &str, rows: impl Iterator<Item = (&'a str, &'a str)>) {
    ui.label(RichText::new(title).strong());
    Grid::new(title).num_columns(2).min_col_width(90.0).spacing([10.0, 1.0]).show(ui, |ui| {
        for (name, help) in rows {
            ui.label(RichText::new(name).monospace().size(11.0));
            ui.label(RichText::new(help).size(12.0));
            ui.end_row();
        }
    });
    ui.add_space(4.0);
}
