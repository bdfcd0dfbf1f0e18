//! Tests of the panel without a window.

use std::sync::Arc;

use egui::{Event, Key, Modifiers, PointerButton, Popup, RawInput, Shape};

use super::parts::figure;
use super::*;
use crate::Options;
use crate::scene::Scene;
use crate::viewer::bindings::Command;
use crate::viewer::first_wish;
use crate::viewer::guiding::Guiding;
use crate::viewer::keys::{Busy, Keys, Stroke, With};
use crate::viewer::paint::{Colors, Scale};
use crate::viewer::quantity::{Picture, Quantity};
use crate::viewer::shared::Shared;

/// A panel without a window.
struct Panel {
    context: Context,
    session: Session,
    keys: Keys,
    /// The texts of the last frame that are not cut off, each with its middle.
    shown: Vec<(String, egui::Pos2)>,
    /// The size of the window in points.
    screen: egui::Vec2,
}

impl Panel {
    fn new() -> Self {
        let scene = Scene::parse("WorldBegin\nLightSource \"point\"\nShape \"sphere\"\n", "scene.pbrt", ".");
        let options = Options { resolution: Some([640, 480]), ..Options::default() };
        let shared = Arc::new(Shared::new(first_wish("scene.pbrt".as_ref(), &options), || {}));
        let session = Session::new("scene.pbrt".as_ref(), &scene.unwrap(), options, None, shared);
        let mut panel = Self {
            context: Context::default(),
            session,
            keys: Keys::default(),
            shown: Vec::new(),
            screen: egui::vec2(900.0, 2000.0),
        };
        panel.frame(Vec::new());
        panel
    }

    /// Runs one frame, and returns the commands of the keys.
    fn frame(&mut self, events: Vec<Event>) -> Vec<Command> {
        let before = Busy::of(&self.context);
        let strokes: Vec<Stroke> = events.iter().filter_map(stroke).collect();
        let screen_rect = Some(egui::Rect::from_min_size(egui::Pos2::ZERO, self.screen));
        // Opening and closing are animated; a frame of this length ends the animation.
        let input = RawInput { screen_rect, events, predicted_dt: 10.0, ..RawInput::default() };
        let output = self.context.run(input, |context| drop(show(context, &mut self.session)));
        let shown = |clipped: &egui::epaint::ClippedShape| {
            let clip = clipped.clip_rect;
            texts(&clipped.shape).into_iter().filter(move |(_, place)| clip.contains(*place)).collect::<Vec<_>>()
        };
        self.shown = output.shapes.iter().flat_map(shown).collect();
        let busy = before.until(Busy::of(&self.context));
        strokes.into_iter().filter_map(|stroke| self.keys.take(stroke, busy)).collect()
    }

    /// Clicks at a place, in one frame, because a longer press is no click.
    fn click(&mut self, pos: egui::Pos2) {
        self.frame(vec![Event::PointerMoved(pos)]);
        let (button, modifiers) = (PointerButton::Primary, Modifiers::NONE);
        self.frame([true, false].map(|pressed| Event::PointerButton { pos, button, pressed, modifiers }).into());
        self.frame(Vec::new());
    }

    /// Turns the wheel over the panel until a text is seen, and returns its place.
    fn scroll_to(&mut self, text: &str) -> egui::Pos2 {
        for _ in 0..100 {
            let (unit, modifiers) = (egui::MouseWheelUnit::Point, Modifiers::NONE);
            self.frame(vec![
                Event::PointerMoved(egui::pos2(100.0, 300.0)),
                Event::MouseWheel { unit, delta: egui::vec2(0.0, -40.0), modifiers },
            ]);
            self.frame(Vec::new());
            if let Some((_, place)) = self.shown.iter().find(|(shown, _)| shown == text) {
                return *place;
            }
        }
        panic!("{text} is not to be found")
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
    panel.click(pos);
    assert!(find(&mut panel, "the guide is off").is_some());
}

/// Of every quantity, in all its false colours: the ends of the scale and the unit.
#[test]
fn false_colors_have_a_scale_with_its_unit() {
    let mut panel = Panel::new();
    let values: Vec<[f32; 4]> = (1..=100).map(|step| [0.25 * step as f32; 4]).collect();
    for quantity in Quantity::ALL {
        panel.session.show(quantity);
        let ends = Some([0.5, 2500.0]);
        let picture = Picture { size: [100, 1], values: values.clone(), quantity, ends };
        panel.session.picture = Some(Arc::new(picture.clone()));
        for colors in Colors::all(quantity).into_iter().skip(1) {
            panel.session.color(colors);
            panel.session.scale = Scale::of(&picture, colors);
            panel.frame(Vec::new());
            let texts: Vec<&str> = panel.shown.iter().map(|(text, _)| text.as_str()).collect();
            let ends = panel.session.scale.unwrap().ends.map(figure);
            assert!(ends.iter().all(|end| texts.contains(&end.as_str())), "{quantity:?} {ends:?}: {texts:?}");
            let is_said = texts.iter().any(|text| text.starts_with(quantity.unit()) && text.ends_with("scale"));
            assert!(is_said, "{quantity:?}: {texts:?}");
        }
    }
}

#[test]
fn figures_have_five_digits() {
    for (value, expected) in [
        (0.0, "0"),
        (1.0, "1.0000"),
        (12.345_67, "12.346"),
        (-0.5, "-0.5000"),
        (99_999.0, "99999"),
        (1e5, "1.000e5"),
        (2.5e-4, "2.500e-4"),
        (f32::INFINITY, "inf"),
        (f32::NAN, "NaN"),
    ] {
        assert_eq!(figure(value), expected);
    }
}

/// A window of 1024x640 shows or scrolls to everything, even if all sections are unfolded.
#[test]
fn everything_can_be_reached_in_a_small_window() {
    let mut panel = Panel::new();
    panel.screen = egui::vec2(1024.0, 640.0);
    for name in ["Histogram", "Compare", "Camera", "Render", "Time per pass", "Guide", "Files"] {
        panel.frame(Vec::new());
        let found = panel.shown.iter().find(|(text, _)| text == name).map(|(_, place)| *place);
        let place = found.unwrap_or_else(|| panel.scroll_to(name));
        assert!(place.x < PANEL && (0.0..640.0).contains(&place.y), "{name} at {place:?}");
        panel.click(place);
    }
    panel.scroll_to("choose a file");
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
    let (_, place) = panel.shown.iter().find(|(text, _)| text == "Files").cloned().unwrap();
    panel.click(place);
    panel.frame(Vec::new());
    let (_, place) = panel.shown.iter().find(|(text, _)| *text == name).cloned().unwrap();
    panel.click(place);
    for key in [Key::H, Key::Num1, Key::R, Key::C, Key::S] {
        assert_eq!(panel.press(key), [], "{key:?}");
    }
    assert!(panel.session.save_text.contains("h1rcs"), "{}", panel.session.save_text);
    assert_eq!(panel.press(Key::Escape), [], "it leaves the field");
    assert_eq!(panel.press(Key::H), [Command::Panel]);
}
