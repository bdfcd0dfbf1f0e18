//! The status of the render in the panel.

use std::time::Duration;

use egui::{Grid, RichText, Ui};

use super::parts::button;
use crate::viewer::bindings::Command;
use crate::viewer::session::{Effect, Session};

/// The time between two frames while a wait is counted in seconds.
const TICK: Duration = Duration::from_millis(500);

/// Shows what is going on, in words and numbers.
pub fn show(ui: &mut Ui, session: &mut Session, effects: &mut Vec<Effect>) {
    ui.label(RichText::new(session.state()).strong().size(15.0));
    if session.status.doing.is_wait() {
        ui.ctx().request_repaint_after(TICK);
    }
    ui.horizontal(|ui| {
        let text = if session.paused { "go on" } else { "pause" };
        button(ui, session, effects, text, Command::Pause, "space");
        button(ui, session, effects, "keys", Command::Keys, "F1: all keys and what the mouse does");
        button(ui, session, effects, "save", Command::Save, "Ctrl+S; the name is under Files");
    });
    numbers(ui, session);
    ui.label(RichText::new(&session.status.device).small());
}

fn numbers(ui: &mut Ui, session: &Session) {
    let status = &session.status;
    let seconds = status.time.as_secs_f64();
    let [width, height] = status.resolution;
    let per_second = if seconds > 0.0 { status.photons as f64 / seconds } else { 0.0 };
    let error = status.error.map_or_else(|| "-".to_owned(), |error| format!("{:.2} %", 100.0 * error));
    let size = if width == 0 { "-".to_owned() } else { format!("{width} x {height}") };
    Grid::new("status").num_columns(2).show(ui, |ui| {
        for (name, value) in [
            ("image", size),
            ("iterations", format!("{} in {seconds:.1} s", status.iterations)),
            ("photons", format!("{}, {}/s", short(status.photons as f64), short(per_second))),
            ("estimated error", error),
            ("guide", status.guiding.short()),
            ("device memory", format!("{} MiB", status.memory >> 20)),
        ] {
            ui.label(name);
            ui.label(value);
            ui.end_row();
        }
    });
}

/// Shows the time that each pass of the last iteration took.
pub fn passes(ui: &mut Ui, session: &Session) {
    Grid::new("passes").num_columns(2).show(ui, |ui| {
        for (name, time) in session.status.passes.iter().filter(|(_, time)| !time.is_zero()) {
            ui.label(*name);
            ui.label(format!("{:.1} ms", 1e3 * time.as_secs_f64()));
            ui.end_row();
        }
    });
}

/// Writes a number with about three digits and a decimal prefix.
fn short(number: f64) -> String {
    match number {
        n if n >= 1e9 => format!("{:.2} G", n / 1e9),
        n if n >= 1e6 => format!("{:.2} M", n / 1e6),
        n if n >= 1e3 => format!("{:.1} k", n / 1e3),
        n => format!("{n:.0}"),
    }
}
