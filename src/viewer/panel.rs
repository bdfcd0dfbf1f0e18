//! The panel: the status of the render and the controls.

use std::path::PathBuf;

use egui::emath::Numeric;
use egui::{Align, Color32, ComboBox, Context, DragValue, Grid, Layout, Rect, ScrollArea, Sense};
use egui::{SidePanel, Slider, TextEdit, Ui, vec2};

use super::display::Curve;
use super::false_color;
use super::layout::PANEL;
use super::quantity::{Quantity, Shade};
use super::session::Session;
use crate::base::names::Named;
use crate::gpu_scene::pack::RevolutionSolver;
use crate::render::options::table::{Fallback, RenderOption, find};

/// Width of the field for a file name, in points.
const NAME: f32 = 190.0;

/// Shows the panel, if it is open.
pub fn show(context: &Context, session: &mut Session) {
    if !session.has_panel {
        return;
    }
    SidePanel::left("panel").resizable(false).exact_width(PANEL).show(context, |ui| {
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| contents(ui, session));
    });
}

fn contents(ui: &mut Ui, session: &mut Session) {
    status(ui, session);
    ui.separator();
    look(ui, session);
    // The message is above the sections that can be unfolded, so that it is always visible.
    if let Some(message) = &session.message {
        ui.separator();
        match message {
            Ok(text) => ui.label(text),
            Err(text) => ui.colored_label(Color32::LIGHT_RED, text),
        };
        ui.separator();
    }
    ui.collapsing("Render", |ui| knobs(ui, session));
    ui.collapsing("Camera", |ui| camera(ui, session));
    ui.collapsing("Files", |ui| files(ui, session));
    ui.collapsing("Keys", |ui| {
        ui.label(
            "drag: orbit; right button or shift: pan\nwheel: nearer; with ctrl: aperture\nclick: focus, and orbit \
             about it\nW A S D E Q: fly; shift: faster\nR: reset; C: copy the camera\n1 to 9, 0: what to show\n\
             space: pause; H: panel\nCtrl+S: save; Esc: quit",
        );
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
            ("guide", status.guiding.short()),
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
    ui.collapsing("Guide", |ui| ui.label(status.guiding.sentences()));
    let text = if session.paused { "go on" } else { "pause" };
    if ui.button(text).clicked() {
        session.pause();
    }
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

fn look(ui: &mut Ui, session: &mut Session) {
    let mut wanted = session.quantity;
    ComboBox::from_label("view").selected_text(wanted.name()).show_ui(ui, |ui| {
        for quantity in Quantity::ALL {
            ui.selectable_value(&mut wanted, quantity, quantity.name()).on_hover_text(quantity.help());
        }
    });
    session.show(wanted);
    match (session.shade, session.ends) {
        (Shade::Shares, Some(ends)) => scale(ui, ends.map(|end| format!("{:.0} %", 100.0 * end))),
        (Shade::Amounts, Some(ends)) => scale(ui, ends.map(|end| format!("{end:.1e}"))),
        (_, Some([_, white])) if white.is_finite() => drop(ui.label(format!("white is {white:.4e}"))),
        (_, Some(_)) => drop(ui.label("not known after so few iterations")),
        (_, None) => drop(ui.label("")),
    }
    let exposure = Slider::new(&mut session.look.stops, -10.0..=10.0).text("exposure, stops");
    ui.add_enabled(session.shade.has_exposure(), exposure);
    ui.add_enabled_ui(session.shade == Shade::Light, |ui| {
        ComboBox::from_label("tone map").selected_text(session.look.curve.name()).show_ui(ui, |ui| {
            for curve in Curve::ALL {
                ui.selectable_value(&mut session.look.curve, curve, curve.name());
            }
        });
    });
}

/// Shows the scale of false colours between its ends.
fn scale(ui: &mut Ui, [first, last]: [String; 2]) {
    let (bar, response) = ui.allocate_exact_size(vec2(ui.available_width(), 10.0), Sense::hover());
    response.on_hover_text("black is 0");
    let steps = bar.width().max(1.0) as u32;
    for step in 0..steps {
        let at = step as f32 / steps as f32;
        let part = Rect::from_min_size(bar.min + vec2(at * bar.width(), 0.0), vec2(1.5, bar.height()));
        let [r, g, b] = false_color::color(at).map(|channel| (255.0 * channel).round() as u8);
        ui.painter().rect_filled(part.intersect(bar), 0.0, Color32::from_rgb(r, g, b));
    }
    ui.horizontal(|ui| {
        ui.label(first);
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| ui.label(last));
    });
}

const PHOTONS: &RenderOption = find("photons");
const EYE_PATHS: &RenderOption = find("eye-paths");
const ALPHA: &RenderOption = find("alpha");
const RADIUS: &RenderOption = find("radius");
const RADIUS_SCHEDULE: &RenderOption = find("radius-schedule");
const LOOKUP: &RenderOption = find("lookup");
const DIRECT: &RenderOption = find("direct");
const SAMPLER: &RenderOption = find("sampler");
const GUIDE: &RenderOption = find("guide");

/// Returns the name of an option in the panel.
fn label(option: &RenderOption) -> String {
    option.name.replace('-', " ")
}

/// Shows a list of the names of an option's values.
fn choice<T: Named>(ui: &mut Ui, option: &RenderOption, value: &mut T) {
    let list = ComboBox::from_label(label(option)).selected_text(value.name()).show_ui(ui, |ui| {
        for (other, (name, line)) in T::ALL.iter().zip(T::NAMES) {
            ui.selectable_value(value, *other, *name).on_hover_text(line.trim());
        }
    });
    list.response.on_hover_text(option.help);
}

/// Shows a field for a number, if the option has a number as its default. `speed` is the change per point of
/// a drag.
fn number<T: Numeric>(ui: &mut Ui, option: &RenderOption, value: &mut Option<T>, speed: f64) {
    if let (Fallback::Number(first, _), Some(range)) = (&option.fallback, option.range()) {
        number_from(ui, option, value, (T::from_f64(*first), range.map(T::from_f64)), speed);
    }
}

/// Shows a field for a number. When the user enables the field, the number is `first`; edits keep it within
/// the range.
fn number_from<T: Numeric>(
    ui: &mut Ui,
    option: &RenderOption,
    value: &mut Option<T>,
    (first, [least, most]): (T, [T; 2]),
    speed: f64,
) {
    ui.horizontal(|ui| {
        let mut is_own = value.is_some();
        ui.checkbox(&mut is_own, label(option)).on_hover_text(option.help);
        *value = is_own.then(|| value.unwrap_or(first));
        if let Some(value) = value {
            // A range may change with the camera; a value that the user has set does not change.
            let number = DragValue::new(value).range(least..=most).clamp_existing_to_range(false);
            ui.add(number.speed(speed).update_while_editing(false));
        }
    });
}

fn knobs(ui: &mut Ui, session: &mut Session) {
    let (photons, radius) = (session.own_photons(), session.own_radius());
    let options = &mut session.options;
    let before = options.clone();
    if let Some([least, most]) = PHOTONS.range() {
        number_from(ui, PHOTONS, &mut options.photons, (photons, [least as u64, most as u64]), 1e3);
    }
    number(ui, EYE_PATHS, &mut options.eye_paths, 0.05);
    number(ui, ALPHA, &mut options.alpha, 0.005);
    number_from(ui, RADIUS, &mut options.radius, (radius, [0.01 * radius, 1e4 * radius]), 0.02 * radius);
    choice(ui, RADIUS_SCHEDULE, &mut options.radius_schedule);
    choice(ui, LOOKUP, &mut options.lookup);
    choice(ui, DIRECT, &mut options.direct);
    choice(ui, GUIDE, &mut options.guidance);
    choice(ui, SAMPLER, &mut options.sampler);
    let mut newton = options.revolution_solver != RevolutionSolver::Certified;
    ui.checkbox(&mut newton, "classical solver for bodies of revolution");
    if newton != (options.revolution_solver != RevolutionSolver::Certified) {
        options.revolution_solver = if newton { RevolutionSolver::NEWTON } else { RevolutionSolver::Certified };
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
        let radius = DragValue::new(&mut radius).range(0.0..=1e3 * scale).speed(0.05 * scale);
        ui.add(radius.clamp_existing_to_range(false));
        ui.label("focus");
        let focus = DragValue::new(&mut focus).range(scale..=f64::MAX).speed(scale);
        ui.add(focus.clamp_existing_to_range(false));
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
        let name = TextEdit::singleline(&mut session.save_text).desired_width(NAME);
        ui.add(name).on_hover_text("ends in .exr, .png or .checkpoint");
        if ui.button("save").on_hover_text("Ctrl+S").clicked() {
            session.save();
        }
    });
    ui.horizontal(|ui| {
        let name = TextEdit::singleline(&mut session.scene_text).desired_width(NAME);
        ui.add(name).on_hover_text("or drop a file on the window");
        if ui.button("open").clicked() {
            let path = PathBuf::from(&session.scene_text);
            session.open(&path);
        }
    });
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use egui::{Event, Key, Modifiers, PointerButton, Popup, RawInput, Shape};

    use super::*;
    use crate::Options;
    use crate::scene::Scene;
    use crate::viewer::first_wish;
    use crate::viewer::guiding::Guiding;
    use crate::viewer::keys::{Busy, Command, Keys, Stroke, With};
    use crate::viewer::shared::Shared;

    /// A panel without a window.
    struct Panel {
        context: Context,
        session: Session,
        keys: Keys,
        /// The texts of the last frame, each with its middle.
        shown: Vec<(String, egui::Pos2)>,
    }

    impl Panel {
        fn new() -> Self {
            let scene = Scene::parse("WorldBegin\nLightSource \"point\"\nShape \"sphere\"\n", "scene.pbrt", ".");
            let options = Options { resolution: Some([640, 480]), ..Options::default() };
            let shared = Arc::new(Shared::new(first_wish("scene.pbrt".as_ref(), &options), || {}));
            let session = Session::new("scene.pbrt".as_ref(), &scene.unwrap(), options, None, shared);
            let mut panel = Self { context: Context::default(), session, keys: Keys::default(), shown: Vec::new() };
            panel.frame(Vec::new());
            panel
        }

        /// Runs one frame, and returns the commands of the keys.
        fn frame(&mut self, events: Vec<Event>) -> Vec<Command> {
            let before = Busy::of(&self.context);
            let strokes: Vec<Stroke> = events.iter().filter_map(stroke).collect();
            let screen_rect = Some(egui::Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(900.0, 2000.0)));
            // Opening and closing are animated; a frame of this length ends the animation.
            let input = RawInput { screen_rect, events, predicted_dt: 10.0, ..RawInput::default() };
            let output = self.context.run(input, |context| show(context, &mut self.session));
            self.shown = output.shapes.iter().flat_map(|clipped| texts(&clipped.shape)).collect();
            let busy = before.until(Busy::of(&self.context));
            strokes.into_iter().filter_map(|stroke| self.keys.take(stroke, busy)).collect()
        }

        /// Presses a key in one frame, and releases it in the next.
        fn press(&mut self, key: Key) -> Vec<Command> {
            let commands = self.frame([Some(event(key, true)), text(key)].into_iter().flatten().collect());
            self.frame(vec![event(key, false)]);
            self.frame(Vec::new());
            commands
        }
    }

    /// Returns the texts of a shape, each with its middle.
    fn texts(shape: &Shape) -> Vec<(String, egui::Pos2)> {
        match shape {
            Shape::Text(text) => vec![(text.galley.text().to_owned(), text.visual_bounding_rect().center())],
            Shape::Vec(shapes) => shapes.iter().flat_map(texts).collect(),
            _ => Vec::new(),
        }
    }

    #[test]
    fn the_panel_says_what_a_guide_has_found() {
        let mut panel = Panel::new();
        panel.session.status.guiding = Guiding::Off;
        let find = |panel: &mut Panel, what: &str| {
            panel.frame(Vec::new());
            let texts = std::mem::take(&mut panel.shown);
            texts.iter().find(|(text, _)| text.contains(what)).map(|(_, place)| *place)
        };
        assert!(find(&mut panel, "off").is_some());
        assert_eq!(find(&mut panel, "the guide is off"), None, "it is folded");
        let pos = find(&mut panel, "Guide").expect("a section");
        panel.frame(vec![Event::PointerMoved(pos)]);
        // In one frame, because a longer press is no click.
        let button = PointerButton::Primary;
        let clicks = [true, false];
        panel.frame(
            clicks.map(|pressed| Event::PointerButton { pos, button, pressed, modifiers: Modifiers::NONE }).into(),
        );
        panel.frame(Vec::new());
        assert!(find(&mut panel, "the guide is off").is_some());
    }

    #[test]
    fn false_colors_have_a_scale() {
        let mut panel = Panel::new();
        let scales =
            [(Shade::Shares, [0.0, 1.0], ["0 %", "100 %"]), (Shade::Amounts, [0.25, 2500.0], ["2.5e-1", "2.5e3"])];
        for (shade, ends, texts) in scales {
            (panel.session.shade, panel.session.ends) = (shade, Some(ends));
            panel.frame(Vec::new());
            for end in texts {
                assert!(panel.shown.iter().any(|(text, _)| text == end), "{end}");
            }
        }
    }

    fn event(key: Key, pressed: bool) -> Event {
        Event::Key { key, physical_key: None, pressed, repeat: false, modifiers: Modifiers::NONE }
    }

    fn text(key: Key) -> Option<Event> {
        (key.name().len() == 1).then(|| Event::Text(key.name().to_lowercase()))
    }

    fn stroke(event: &Event) -> Option<Stroke> {
        let Event::Key { key, pressed, .. } = event else { return None };
        Some(Stroke { key: *key, is_pressed: *pressed, is_repeat: false, with: With::default() })
    }

    #[test]
    fn esc_closes_a_list_and_only_then_the_window() {
        let mut panel = Panel::new();
        let mut lists = 0;
        for _ in 0..40 {
            panel.press(Key::Tab);
            panel.press(Key::Space);
            if !Popup::is_any_open(&panel.context) {
                continue;
            }
            lists += 1;
            assert_eq!(panel.press(Key::Escape), [], "it closes the list");
            assert!(!Popup::is_any_open(&panel.context));
            while panel.context.wants_keyboard_input() {
                assert_eq!(panel.press(Key::Escape), [], "nothing has the focus any more");
            }
            assert_eq!(panel.press(Key::Escape), [Command::Quit]);
            if lists == 2 {
                return;
            }
        }
        panic!("{lists} lists were found");
    }

    #[test]
    fn what_is_typed_into_a_field_is_no_command() {
        let mut panel = Panel::new();
        let name = panel.session.save_text.clone();
        // Unfolds the last section but one, which is the files.
        for _ in 0..2 {
            let modifiers = Modifiers::SHIFT;
            panel.frame(vec![Event::Key {
                key: Key::Tab,
                physical_key: None,
                pressed: true,
                repeat: false,
                modifiers,
            }]);
        }
        panel.press(Key::Enter);
        for _ in 0..4 {
            panel.press(Key::Tab);
            for key in [Key::H, Key::Num1, Key::R, Key::C, Key::S] {
                assert_eq!(panel.press(key), [], "{key:?}");
            }
            if panel.session.save_text != name {
                assert!(panel.session.save_text.contains("h1rcs"), "{}", panel.session.save_text);
                assert_eq!(panel.press(Key::Escape), [], "it leaves the field");
                assert_eq!(panel.press(Key::H), [Command::Panel]);
                return;
            }
        }
        panic!("no field was found");
    }
}
