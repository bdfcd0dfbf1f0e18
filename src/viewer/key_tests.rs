//! Every key of the table has an effect that is seen. A command without a test does not compile.

use std::sync::Arc;

use egui::Key;

use super::bindings::{BINDINGS, Binding, Chord, Command, Does};
use super::camera_control::Place;
use super::compared::Beside;
use super::dialog::{Answer, Question};
use super::layout::Zoom;
use super::paint::Colors;
use super::quantity::Quantity;
use super::session::{Effect, Session};
use super::state_tests::Hand;
use crate::image::exposure::{Exposure, auto_stops, exposed};

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

/// The state before a key is pressed.
struct Before {
    place: Place,
    zoom: Zoom,
    steps: [usize; 2],
    flags: [bool; 3],
}

impl Before {
    fn new(session: &Session) -> Self {
        let Session { zoom, paused, has_panel, has_keys, .. } = *session;
        let (place, steps) = (session.control.place(), session.steps());
        Self { place, zoom, steps, flags: [paused, has_panel, has_keys] }
    }

    /// Checks that the key has changed one of the flags, and no other.
    fn flips(&self, session: &Session, flag: usize, context: &str) {
        let mut expected = self.flags;
        expected[flag] ^= true;
        assert_eq!(Self::new(session).flags, expected, "{context}");
    }
}

/// Presses a key, and checks its effect.
fn check(hand: &mut Hand, binding: &Binding, key: Key) {
    let context = format!("{key:?} {:?}", binding.with);
    // Of the image, another quantity than the one that the key shows.
    if binding.does == Does::Command(Command::Show(Quantity::Image)) {
        hand.session.show(Quantity::ALL[4]);
    }
    let before = Before::new(&hand.session);
    let effect = press(hand, binding, key);
    let session = &hand.session;
    let command = match binding.does {
        Does::Fly(by) => {
            let places =
                [session.control.place(), before.place].map(|place| place.camera.world_from_camera.translation);
            let moved = places[0] - places[1];
            // The camera looks along z.
            return assert!(moved.dot(by) > 0.0 && (moved - moved.dot(by) * by).length() < 1e-9, "{context}: {moved}");
        }
        Does::Command(command) => command,
    };
    match command {
        Command::Show(_) | Command::Colors | Command::Expose(_) | Command::AutoExpose => {
            look(session, command, &context)
        }
        Command::Zoom(_) | Command::Fit | Command::Pixels | Command::Shift(_) => {
            image(session, &before, command, &context);
        }
        Command::Widen(_) | Command::Undo | Command::Redo | Command::Reset => {
            camera(session, &before, command, &context);
        }
        Command::Keep | Command::Flip | Command::Split | Command::MoveSplit(_) => compare(session, command, &context),
        Command::Pause => before.flips(session, 0, &context),
        Command::Panel => before.flips(session, 1, &context),
        Command::Keys => before.flips(session, 2, &context),
        Command::Save => {
            let path = hand.path("saved.exr");
            hand.look("a file", |_| path.exists().then_some(()));
        }
        Command::Copy => {
            return assert!(matches!(effect, Some(Effect::Copy(text)) if text.contains("Camera")), "{context}");
        }
        Command::Ask(question) => {
            assert!(session.is_asking, "{context}");
            return assert!(matches!(effect, Some(Effect::Ask(asked, _)) if asked == question), "{context}");
        }
        Command::Quit => return assert_eq!(effect, Some(Effect::Quit), "{context}"),
    }
    assert_eq!(effect, None, "{context}");
}

fn look(session: &Session, command: Command, context: &str) {
    match command {
        Command::Show(quantity) => assert_eq!(session.quantity, quantity, "{context}"),
        Command::Colors => assert_eq!(session.colors, Colors::False(0), "{context}"),
        Command::Expose(steps) => assert_eq!(session.look.stops, 0.5 * f32::from(steps), "{context}"),
        Command::AutoExpose => {
            let stops = auto_stops(&session.picture.as_ref().unwrap().to_image());
            assert!(stops != 0.0 && session.look.stops == stops, "{context}: {stops}");
        }
        _ => panic!("{context}"),
    }
}

fn image(session: &Session, before: &Before, command: Command, context: &str) {
    match (command, session.zoom, before.zoom) {
        (Command::Zoom(is_in), Zoom::Own { scale, .. }, _) => {
            assert!((scale - if is_in { 4.0 } else { 2.0 }).abs() < 1e-3, "{context}: {scale}");
        }
        (Command::Fit, zoom, _) => assert_eq!(zoom, Zoom::Fit, "{context}"),
        (Command::Pixels, zoom, _) => assert_eq!(zoom, Zoom::Own { scale: 1.0, middle: [0.5; 2] }, "{context}"),
        (Command::Shift(by), Zoom::Own { middle: to, .. }, Zoom::Own { middle: from, .. }) => {
            for axis in [0, 1] {
                let direction = if to[axis] == from[axis] { 0.0 } else { (from[axis] - to[axis]).signum() };
                assert_eq!(direction, f32::from(by[axis]), "{context}: {from:?} {to:?}");
            }
        }
        _ => panic!("{context}"),
    }
}

fn camera(session: &Session, before: &Before, command: Command, context: &str) {
    let [undone, redone] = before.steps;
    match command {
        Command::Widen(is_wider) => {
            let mut control = session.control.clone();
            control.go_to(before.place);
            let [then, now] = [&control, &session.control].map(|control| control.field_of_view().unwrap());
            assert_eq!(now > then, is_wider, "{context}: {then} {now}");
        }
        Command::Undo => {
            assert!(session.control.is_home(), "{context}");
            assert_eq!(session.steps(), [undone - 1, redone + 1], "{context}");
        }
        Command::Redo => {
            assert!(session.control.place() != before.place, "{context}");
            assert_eq!(session.steps(), [undone + 1, redone - 1], "{context}");
        }
        Command::Reset => assert!(session.control.is_home(), "{context}"),
        _ => panic!("{context}"),
    }
}

fn compare(session: &Session, command: Command, context: &str) {
    let beside = session.compared.beside;
    match (command, beside) {
        (Command::Keep, _) => {
            let said = session.message.clone().unwrap().unwrap();
            assert!(said.starts_with("kept image after 4 iterations:"), "{context}: {said}");
        }
        (Command::Flip, _) => assert_eq!(beside, Beside::Other, "{context}"),
        (Command::Split, _) => assert_eq!(beside, Beside::Current, "{context}"),
        (Command::MoveSplit(is_right), Beside::Split(line)) => {
            assert!(line != 0.5 && (line > 0.5) == is_right, "{context}: {line}");
        }
        _ => panic!("{context}"),
    }
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

/// The state of the window after the answer to a dialog.
fn answered(hand: &mut Hand, question: Question, answer: Answer) -> Option<Result<String, String>> {
    hand.session.message = None;
    assert!(matches!(hand.session.obey(Command::Ask(question)), Some(Effect::Ask(..))));
    hand.session.shared().tell(|news| news.answer = Some((question, answer)));
    hand.look("an answer", |hand| (!hand.session.is_asking).then_some(()));
    hand.session.message.clone()
}

#[test]
fn the_answer_to_a_dialog_is_followed_and_a_desktop_without_one_is_said() {
    let mut hand = Hand::at_rest();
    assert_eq!(answered(&mut hand, Question::Scene, Answer::Cancelled), None);
    for question in [Question::Scene, Question::Reference, Question::Save] {
        let said = answered(&mut hand, question, Answer::Failed("no bus".to_owned())).unwrap().unwrap_err();
        assert!(said.starts_with("this desktop shows no file dialog (no bus): type the name"), "{said}");
    }
    let path = hand.path("chosen.png");
    std::fs::write(&path, "mine").unwrap();
    answered(&mut hand, Question::Save, Answer::Chosen(path.clone()));
    hand.look("a file", |hand| hand.session.message.clone()?.ok().filter(|said| said.starts_with("wrote")));
    assert!(std::fs::metadata(&path).unwrap().len() > 50, "the desktop has asked before it is replaced");
    assert!(!hand.path("chosen-2.png").exists());
    answered(&mut hand, Question::Reference, Answer::Chosen(path));
    hand.look("the file", |hand| hand.session.compared.other.as_ref().map(|_| ()));
    let scene = hand.path("scene.pbrt");
    answered(&mut hand, Question::Scene, Answer::Chosen(scene));
    hand.look("the scene", |hand| (hand.session.message == Some(Ok("read the scene".to_owned()))).then_some(()));
}

/// A PNG is as bright as the window, and by the function of `goblet render --exposure`.
#[test]
fn a_saved_png_has_the_exposure_of_the_window() {
    let mut hand = Hand::at_rest();
    let image = hand.session.picture.as_ref().unwrap().to_image();
    for (name, exposure) in
        [("plain", Exposure::Stops(0.0)), ("bright", Exposure::Stops(1.5)), ("auto", Exposure::Auto)]
    {
        hand.session.set_exposure(exposure);
        assert_eq!(hand.session.look.stops, exposure.stops(&image));
        let [saved, expected] = [format!("{name}.png"), format!("{name}-expected.png")].map(|name| hand.path(&name));
        crate::image::file::write(&expected, &exposed(&image, exposure.stops(&image)), &[]).unwrap();
        hand.session.save_text = saved.display().to_string();
        hand.press((Key::S, Chord::Command));
        hand.look("a file", |_| saved.exists().then_some(()));
        let bytes = [saved, expected].map(|path| std::fs::read(path).unwrap());
        assert!(bytes[0] == bytes[1], "{name}");
    }
}
