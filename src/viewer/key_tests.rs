//! Every key of the table has an effect that is seen. A command without a test does not compile.

use std::sync::Arc;

use egui::Key;

use super::bindings::{BINDINGS, Binding, Chord, Command, Does};
use super::compared::Beside;
use super::layout::Zoom;
use super::paint::Colors;
use super::quantity::Quantity;
use super::session::Effect;
use super::state_tests::Hand;
use crate::image::exposure::{Exposure, auto_stops};

/// Presses a key of an entry.
fn press(hand: &mut Hand, binding: &Binding, key: Key) -> Option<Effect> {
    hand.press((key, binding.with))
}

fn plain(key: Key) -> (Key, Chord) {
    (key, Chord::Plain)
}

/// Brings the window to a state in which every key has an effect: the camera has moved twice, one move is undone, a picture is
/// kept and shown beside the current one, and the image is enlarged.
fn prepare(hand: &mut Hand) {
    hand.session.reset();
    hand.session.show(Quantity::Image);
    hand.session.color(Colors::Own);
    hand.session.paused = false;
    (hand.session.has_panel, hand.session.has_keys, hand.session.is_asking) = (true, false, false);
    hand.rest();
    for factor in [1.2, 1.3] {
        hand.session.widen(factor);
        // A key between them makes them two steps.
        hand.press((Key::Z, Chord::Command));
        hand.press((Key::Y, Chord::Command));
    }
    hand.press((Key::Z, Chord::Command));
    hand.rest();
    hand.session.area.size = hand.session.image();
    hand.session.zoom = Zoom::Own { scale: 3.0, middle: [0.5; 2] };
    hand.session.compared = Default::default();
    hand.press(plain(Key::K));
    hand.session.set_beside(Beside::Split(0.5));
    hand.session.set_exposure(Exposure::Stops(0.0));
    hand.session.message = None;
}

#[test]
fn every_key_of_the_table_has_its_effect() {
    let mut hand = Hand::at_rest();
    for binding in BINDINGS {
        for key in binding.keys {
            prepare(&mut hand);
            check(&mut hand, &binding, *key);
        }
    }
}

fn check(hand: &mut Hand, binding: &Binding, key: Key) {
    let context = format!("{key:?} {:?}", binding.with);
    let place = hand.session.control.place();
    let zoom = hand.session.zoom;
    let [undone, redone] = hand.session.steps();
    let session = |hand: &Hand| (hand.session.paused, hand.session.has_panel, hand.session.has_keys);
    let before = session(hand);
    // Of the image, another quantity than the one that the key shows.
    if binding.does == Does::Command(Command::Show(Quantity::Image)) {
        hand.session.show(Quantity::ALL[4]);
    }
    let effect = press(hand, binding, key);
    let command = match binding.does {
        Does::Fly(by) => {
            let moved = hand.session.control.camera().world_from_camera.translation
                - place.camera.world_from_camera.translation;
            // The camera looks along z.
            return assert!(moved.dot(by) > 0.0 && (moved - moved.dot(by) * by).length() < 1e-9, "{context}: {moved}");
        }
        Does::Command(command) => command,
    };
    match command {
        Command::Show(quantity) => assert_eq!(hand.session.quantity, quantity, "{context}"),
        Command::Colors => assert_eq!(hand.session.colors, Colors::False(0), "{context}"),
        Command::Expose(steps) => assert_eq!(hand.session.look.stops, 0.5 * f32::from(steps), "{context}"),
        Command::AutoExpose => {
            let stops = auto_stops(&hand.session.picture.as_ref().unwrap().to_image());
            assert!(stops != 0.0 && hand.session.look.stops == stops, "{context}: {stops}");
        }
        Command::Zoom(is_in) => {
            let Zoom::Own { scale, .. } = hand.session.zoom else { panic!("{context}") };
            assert!((scale - if is_in { 4.0 } else { 2.0 }).abs() < 1e-3, "{context}: {scale}");
        }
        Command::Fit => assert_eq!(hand.session.zoom, Zoom::Fit, "{context}"),
        Command::Pixels => assert_eq!(hand.session.zoom, Zoom::Own { scale: 1.0, middle: [0.5; 2] }, "{context}"),
        Command::Shift(by) => {
            let (Zoom::Own { middle: to, .. }, Zoom::Own { middle: from, .. }) = (hand.session.zoom, zoom) else {
                panic!("{context}")
            };
            for axis in [0, 1] {
                let direction = if to[axis] == from[axis] { 0.0 } else { (from[axis] - to[axis]).signum() };
                assert_eq!(direction, f32::from(by[axis]), "{context}: {from:?} {to:?}");
            }
        }
        Command::Widen(is_wider) => {
            let now = hand.session.control.field_of_view().unwrap();
            let then = {
                let mut control = hand.session.control.clone();
                control.go_to(place);
                control.field_of_view().unwrap()
            };
            assert_eq!(now > then, is_wider, "{context}: {then} {now}");
        }
        Command::Undo => {
            assert!(hand.session.control.is_home() && hand.session.steps() == [undone - 1, redone + 1], "{context}")
        }
        Command::Redo => {
            assert!(
                hand.session.control.place() != place && hand.session.steps() == [undone + 1, redone - 1],
                "{context}"
            );
        }
        Command::Reset => assert!(hand.session.control.is_home(), "{context}"),
        Command::Copy => {
            assert!(matches!(effect, Some(Effect::Copy(text)) if text.contains("Camera")), "{context}");
            return;
        }
        Command::Keep => assert_eq!(
            hand.session.message.clone().unwrap().unwrap().split(':').next(),
            Some("kept image after 4 iterations")
        ),
        Command::Flip => assert_eq!(hand.session.compared.beside, Beside::Other, "{context}"),
        Command::Split => assert_eq!(hand.session.compared.beside, Beside::Current, "{context}"),
        Command::MoveSplit(is_right) => {
            let Beside::Split(line) = hand.session.compared.beside else { panic!("{context}") };
            assert_eq!(line > 0.5, is_right, "{context}");
            assert!(line != 0.5, "{context}");
        }
        Command::Pause => assert_eq!(session(hand), (!before.0, before.1, before.2), "{context}"),
        Command::Panel => assert_eq!(session(hand), (before.0, !before.1, before.2), "{context}"),
        Command::Keys => assert_eq!(session(hand), (before.0, before.1, !before.2), "{context}"),
        Command::Save => {
            let path = hand.path("saved.exr");
            hand.look("a file", |_| path.exists().then_some(()));
        }
        Command::Ask(question) => {
            assert!(matches!(effect, Some(Effect::Ask(asked, _)) if asked == question), "{context}");
            assert!(hand.session.is_asking, "{context}");
            return;
        }
        Command::Quit => return assert_eq!(effect, Some(Effect::Quit), "{context}"),
    }
    assert_eq!(effect, None, "{context}");
}

#[test]
fn the_list_of_keys_is_closed_before_the_window() {
    let mut hand = Hand::at_rest();
    hand.press(plain(Key::F1));
    assert_eq!(hand.press(plain(Key::Escape)), None);
    assert!(!hand.session.has_keys);
    assert_eq!(hand.press(plain(Key::Escape)), Some(Effect::Quit));
}

#[test]
fn one_dialog_is_open_at_a_time() {
    let mut hand = Hand::at_rest();
    assert!(hand.press((Key::O, Chord::Command)).is_some());
    assert_eq!(hand.press((Key::B, Chord::Command)), None);
}

/// A kept picture stays while the camera moves, and the error is that of the picture that is shown.
#[test]
fn a_kept_image_is_compared_with_what_is_rendered_later() {
    let mut hand = Hand::at_rest();
    hand.press(plain(Key::B));
    assert!(!hand.session.shows_other(), "nothing is kept");
    hand.press(plain(Key::K));
    hand.press(plain(Key::V));
    assert!(hand.session.shows_other());
    let kept = Arc::clone(hand.picture.as_ref().unwrap());
    hand.rest();
    let error = hand.look("an error", |hand| hand.session.compared.error);
    assert_eq!((error.relmse, error.energy_ratio), (0.0, 1.0), "it is the same image");
    hand.press(plain(Key::D));
    hand.rest();
    let error = hand.look("an error", |hand| hand.session.compared.error.filter(|error| error.relmse > 0.0));
    let expected = super::compared::error(hand.picture.as_ref().unwrap(), &kept).unwrap();
    assert_eq!(error, expected);
}

/// The cursor is on the pixel whose values are said, however the image is enlarged.
#[test]
fn the_values_are_those_of_the_pixel_under_the_cursor() {
    let mut hand = Hand::at_rest();
    hand.session.area.size = hand.session.image();
    hand.press(plain(Key::K));
    let picture = Arc::clone(hand.picture.as_ref().unwrap());
    for zoom in [Zoom::Fit, Zoom::Own { scale: 8.0, middle: [0.25, 0.75] }] {
        hand.session.zoom = zoom;
        let placement = hand.session.placement();
        for [x, y] in [[6_u32, 12], [5, 11], [7, 13]] {
            let at = |pixel: u32, axis: usize| {
                placement.origin[axis] + (pixel as f32 + 0.5) * placement.size[axis] / picture.size[axis] as f32
            };
            hand.session.cursor = Some([at(x, 0), at(y, 1)]);
            let probe = hand.session.probe().unwrap();
            let [r, g, b, _] = picture.values[(y * 24 + x) as usize];
            assert_eq!((probe.pixel, probe.values, probe.other), ([x, y], [r, g, b], Some([r, g, b])), "{zoom:?}");
        }
        hand.session.cursor = Some([-1e3, 0.0]);
        assert_eq!(hand.session.probe(), None);
    }
}

#[test]
fn files_to_compare_with_must_be_images_of_the_same_size() {
    let mut hand = Hand::at_rest();
    let other = crate::image::film::Image::new(24, 17);
    let path = hand.path("other.exr");
    crate::image::file::write(&path, &other, &[]).unwrap();
    hand.session.drop_file(&path);
    hand.look("the file", |hand| hand.session.compared.other.as_ref().map(|_| ()));
    let refusal = hand.session.refusal().unwrap();
    assert!(refusal.contains("24x17") && refusal.contains("24x16") && refusal.contains("same size"), "{refusal}");
    hand.press(plain(Key::V));
    assert!(!hand.session.shows_other());
    hand.session.take_size_of_other();
    assert_eq!(hand.session.refusal(), None);
    hand.rest();
    let error = hand.look("an error", |hand| hand.session.compared.error);
    assert!(error.energy_ratio == f64::INFINITY && error.height == 17, "{error:?}");
    hand.session.compare_with("no such file.exr".as_ref());
    let error = hand.look("an error", |hand| hand.session.message.clone()?.err());
    assert!(error.contains("no such file.exr"), "{error}");
}

#[test]
fn a_window_is_named_after_its_scene_and_what_it_does() {
    let mut hand = Hand::at_rest();
    assert_eq!(hand.session.title(), "scene.pbrt - all iterations done - goblet");
    hand.press(plain(Key::Space));
    hand.rest();
    assert_eq!(hand.session.title(), "scene.pbrt - paused - goblet");
    hand.session.options.radius = Some(1e9);
    hand.session.changed_options();
    hand.look("an error", |hand| hand.session.message.clone()?.err());
    hand.look("a state", |hand| (hand.session.state() == "failed").then_some(()));
    hand.press(plain(Key::Num4));
    std::thread::sleep(std::time::Duration::from_millis(300));
    hand.session.take_news();
    assert_eq!(hand.session.state(), "failed", "the old image is shown, and nothing is rendered");
}
