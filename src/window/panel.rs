//! The panel: how the render is doing, and what can be changed.

use std::path::PathBuf;

use clap::ValueEnum;
use egui::{Color32, ComboBox, Context, DragValue, Grid, Slider, Ui};

use super::display::Curve;
use super::quantity::Quantity;
use super::session::Session;
use crate::options::Options;
use crate::pack::{Envelopes, RevolutionSolver};

/// Shows it.
pub fn show(context: &Context, session: &mut Session) {
    if !session.has_panel {
        return;
    }
    egui::Window::new("goblet").default_pos([8.0, 8.0]).default_width(250.0).show(context, |ui| {
        status(ui, session);
        ui.separator();
        look(ui, session);
        ui.collapsing("Render", |ui| knobs(ui, session));
        ui.collapsing("Camera", |ui| camera(ui, session));
        ui.collapsing("Files", |ui| files(ui, session));
        ui.collapsing("Keys", |ui| {
            ui.label(
                "drag: orbit; right button or shift: pan\nwheel: nearer; with ctrl: aperture\nclick: focus, and orbit \
                 about it\nW A S D E Q: fly; shift: faster\nR: reset; C: copy the camera\n1 to 8: what to show\nspace: pause; H: panel; Esc: \
                 quit",
            );
        });
        if let Some(message) = &session.message {
            ui.separator();
            match message {
                Ok(text) => ui.label(text),
                Err(text) => ui.colored_label(Color32::LIGHT_RED, text),
            };
        }
    });
}

fn status(ui: &mut Ui, session: &mut Session) {
    let status = &session.status;
    let seconds = status.time.as_secs_f64();
    let [width, height] = status.resolution;
    let per_second = if seconds > 0.0 { status.photons as f64 / seconds } else { 0.0 };
    let error = status.error.map_or_else(|| "-".to_owned(), |error| format!("{:.2} %", 100.0 * error));
    Grid::new("status").num_columns(2).show(ui, |ui| {
        for (name, value) in [
            (status.doing, format!("{width} x {height}")),
            ("iterations", format!("{} in {seconds:.1} s", status.iterations)),
            ("photons", format!("{}, {}/s", short(status.photons as f64), short(per_second))),
            ("estimated error", error),
            ("device memory", format!("{} MiB", status.memory >> 20)),
        ] {
            ui.label(name);
            ui.label(value);
            ui.end_row();
        }
    });
    ui.label(egui::RichText::new(&status.device).small());
    ui.collapsing("Time per pass", |ui| {
        Grid::new("passes").num_columns(2).show(ui, |ui| {
            for (name, time) in status.passes.iter().filter(|(_, time)| !time.is_zero()) {
                ui.label(*name);
                ui.label(format!("{:.1} ms", 1e3 * time.as_secs_f64()));
                ui.end_row();
            }
        });
    });
    let text = if session.paused { "go on" } else { "pause" };
    if ui.button(text).clicked() {
        session.paused = !session.paused;
        session.changed_view();
    }
}

/// A number with three digits.
fn short(number: f64) -> String {
    match number {
        n if n >= 1e9 => format!("{:.2} G", n / 1e9),
        n if n >= 1e6 => format!("{:.2} M", n / 1e6),
        n if n >= 1e3 => format!("{:.1} k", n / 1e3),
        n => format!("{n:.0}"),
    }
}

fn look(ui: &mut Ui, session: &mut Session) {
    let before = session.quantity;
    ComboBox::from_label("view").selected_text(before.name()).show_ui(ui, |ui| {
        for quantity in Quantity::ALL {
            ui.selectable_value(&mut session.quantity, quantity, quantity.name());
        }
    });
    if session.quantity != before {
        session.changed_view();
    }
    if let Some(white) = session.white {
        ui.label(format!("white is {white:.4e}"));
    }
    ui.add(Slider::new(&mut session.look.stops, -10.0..=10.0).text("exposure, stops"));
    ComboBox::from_label("tone map").selected_text(session.look.curve.name()).show_ui(ui, |ui| {
        for curve in Curve::ALL {
            ui.selectable_value(&mut session.look.curve, curve, curve.name());
        }
    });
}

/// One of an option's values, by the names of the command line.
fn choice<T: ValueEnum + PartialEq + Copy>(ui: &mut Ui, label: &str, value: &mut T) {
    let name = |value: &T| value.to_possible_value().map(|value| value.get_name().to_owned()).unwrap_or_default();
    ComboBox::from_label(label).selected_text(name(value)).show_ui(ui, |ui| {
        for other in T::value_variants() {
            ui.selectable_value(value, *other, name(other));
        }
    });
}

/// A number that is the scene's own, or the program's, until it is asked for.
fn optional<T: egui::emath::Numeric>(
    ui: &mut Ui,
    label: &str,
    value: &mut Option<T>,
    first: T,
    range: [T; 2],
    speed: f64,
) {
    ui.horizontal(|ui| {
        let mut is_own = value.is_some();
        ui.checkbox(&mut is_own, label);
        *value = is_own.then(|| value.unwrap_or(first));
        if let Some(value) = value {
            ui.add(DragValue::new(value).range(range[0]..=range[1]).speed(speed).update_while_editing(false));
        }
    });
}

fn knobs(ui: &mut Ui, session: &mut Session) {
    let [width, height] = session.status.resolution.map(u64::from);
    let options = &mut session.options;
    let before = options.clone();
    let per_pixel = width * height;
    optional(ui, "photons", &mut options.photons, per_pixel.max(1), [1, 1 << 31], 1e3);
    let (least, most) = (*Options::EYE_PATHS.start(), *Options::EYE_PATHS.end());
    optional(ui, "eye paths", &mut options.eye_paths, 4, [least, most], 0.05);
    optional(ui, "alpha", &mut options.alpha, 2.0 / 3.0, [0.01, 1.0], 0.005);
    let radius = session.control.pixel_width(options.resolution.unwrap_or([1, 1])) * 3.0;
    optional(ui, "first radius", &mut options.radius, radius, [0.01 * radius, 1e4 * radius], 0.02 * radius);
    choice(ui, "radius schedule", &mut options.radius_schedule);
    choice(ui, "lookup", &mut options.lookup);
    choice(ui, "direct light", &mut options.direct);
    choice(ui, "sampler", &mut options.sampler);
    let mut newton = options.revolution_solver != RevolutionSolver::Certified;
    ui.checkbox(&mut newton, "classical solver for bodies of revolution");
    if newton != (options.revolution_solver != RevolutionSolver::Certified) {
        let segments = RevolutionSolver::DEFAULT_SEGMENTS;
        let classical = RevolutionSolver::Newton { segments, envelopes: Envelopes::default() };
        options.revolution_solver = if newton { classical } else { RevolutionSolver::Certified };
    }
    if *options != before {
        session.changed_options();
    }
}

fn camera(ui: &mut Ui, session: &mut Session) {
    let camera = *session.control.camera();
    let (mut radius, mut focus) = (camera.lens_radius, camera.focal_distance);
    let scale = 1e-3 * session.control.distance();
    ui.horizontal(|ui| {
        ui.label("aperture");
        ui.add(DragValue::new(&mut radius).range(0.0..=1e3 * scale).speed(0.05 * scale));
        ui.label("focus");
        ui.add(DragValue::new(&mut focus).range(scale..=f64::MAX).speed(scale));
    });
    if (radius, focus) != (camera.lens_radius, camera.focal_distance) {
        session.control.set_lens(radius, focus);
        session.moved();
    }
    ui.horizontal(|ui| {
        if ui.button("reset").clicked() {
            session.reset();
        }
        if ui.button("copy as pbrt").clicked() {
            ui.ctx().copy_text(session.camera_text());
        }
    });
}

fn files(ui: &mut Ui, session: &mut Session) {
    ui.horizontal(|ui| {
        ui.text_edit_singleline(&mut session.save_text).on_hover_text("ends in .exr, .png or .checkpoint");
        if ui.button("save").on_hover_text("Ctrl+S").clicked() {
            let path = PathBuf::from(&session.save_text);
            session.save(&path);
        }
    });
    ui.horizontal(|ui| {
        ui.text_edit_singleline(&mut session.scene_text).on_hover_text("or drop a file on the window");
        if ui.button("open").clicked() {
            let path = PathBuf::from(&session.scene_text);
            session.open(&path);
        }
    });
}
