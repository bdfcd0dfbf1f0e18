//! Tests of every key in every state of the viewer, with the render thread and without a window. The picture
//! that is shown equals that of a renderer with the same number of iterations, and a saved file has this
//! picture.

use std::fs;
use std::sync::Arc;
use std::time::{Duration, Instant};

use egui::Key;
use glam::DVec3;

use super::bindings::{BINDINGS, Chord, Command, Does};
use super::doing::Doing;
use super::keys::{Busy, Keys, Stroke, With};
use super::quantity::{Picture, Quantity};
use super::session::{Effect, Session};
use super::tests::{Rendering, SCENE, shared_device};
use super::truth::Truth;
use crate::render::options::{Contribution, Options};
use crate::scene::{Camera, Scene};

/// The number of iterations of a render that is not paused: enough that a render in progress, a paused one and
/// one that is done differ.
const MOST: u32 = 4;

/// The user at the window.
pub struct Hand {
    rendering: Rendering,
    /// The state of the window.
    pub session: Session,
    keys: Keys,
    /// The picture that the window shows.
    pub picture: Option<Arc<Picture>>,
}

impl Hand {
    /// Returns a user at a scene with a render thread, which has nothing left to do.
    pub fn at_rest() -> Self {
        let mut hand = Self::new();
        hand.rendering.start();
        hand.rest();
        hand
    }

    /// Returns the path of a file in the folder of the scene.
    pub fn path(&self, name: &str) -> std::path::PathBuf {
        self.rendering.path(name)
    }

    /// Returns a user at a scene without a render thread.
    fn new() -> Self {
        let mut rendering = Rendering::waiting(&["--iterations", &MOST.to_string()]);
        rendering.device = Some(shared_device());
        let scene = Scene::load(&rendering.args.scene).unwrap();
        let (shared, saved) = (Arc::clone(&rendering.shared), rendering.path("saved.exr"));
        let session = Session::new(&rendering.args.scene, &scene, rendering.args.options(), Some(&saved), shared);
        Self { rendering, session, keys: Keys::default(), picture: None }
    }

    /// Presses and releases a key with its modifiers.
    pub fn press(&mut self, (key, chord): (Key, Chord)) -> Option<Effect> {
        let with = With { command: chord != Chord::Plain, shift: chord == Chord::CommandShift, other: false };
        let down = Stroke { key, is_pressed: true, is_repeat: false, with };
        let command = self.keys.take(down, Busy::default());
        self.keys.take(Stroke { is_pressed: false, ..down }, Busy::default());
        let by = self.keys.flight(false);
        if by != DVec3::ZERO {
            self.session.moves(|control| control.fly(0.2 * by));
        }
        command.and_then(|command| self.session.obey(command))
    }

    /// Takes news until `ask` returns an answer.
    pub fn look<T>(&mut self, what: &str, mut ask: impl FnMut(&Self) -> Option<T>) -> T {
        let start = Instant::now();
        loop {
            if let Some(picture) = self.session.take_news() {
                self.picture = Some(picture);
            }
            if let Some(answer) = ask(self) {
                return answer;
            }
            assert!(start.elapsed() < Duration::from_secs(60), "waited in vain for {what}");
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    /// Waits until the render thread has nothing left to do.
    pub fn rest(&mut self) {
        self.look("a wish to be taken", |hand| hand.rendering.shared.is_taken().then_some(()));
        // All news from now on follow the wish.
        self.rendering.shared.news().status.doing = Doing::OpensDevice;
        self.rendering.shared.wish(false, |_| {});
        self.look("rest", |hand| [Doing::Pauses, Doing::IsDone].contains(&hand.session.status.doing).then_some(()));
    }

    /// Waits until the render thread has nothing left to do, and checks that a renderer gives the same
    /// picture. Returns the number of iterations of the picture.
    fn shows(&mut self, truth: &mut Truth, context: &str) -> u32 {
        self.rest();
        let iterations = self.session.status.iterations;
        assert!(iterations > 0, "{context}");
        let (expected, _) = truth.after(iterations, &self.session);
        let picture = self.picture.as_ref().unwrap();
        assert!(picture.size == [24, 16] && picture.values == expected.values, "{context}: {iterations} iterations");
        assert_eq!((picture.ends, picture.quantity), (expected.ends, expected.quantity), "{context}");
        iterations
    }

    /// Waits until a file is written, and returns the number of iterations of its image.
    fn written(&mut self, name: &str, context: &str) -> u32 {
        let path = self.rendering.path(name).display().to_string();
        let is_it = |said: &String| !said.starts_with("wrote ") || !said.contains(&path);
        let said =
            self.look("a file", |hand| hand.session.message.clone().filter(|said| !said.as_ref().is_ok_and(is_it)));
        let said = said.unwrap_or_else(|error| panic!("{context}: {error}"));
        let what = match self.session.quantity.contribution() {
            Contribution::All => "the image",
            Contribution::Direct => "the direct light",
            Contribution::Photons => "the light of photons",
        };
        assert!(said.starts_with(&format!("wrote {path}: {what} after ")), "{context}: {said}");
        said.split(' ').rev().nth(1).unwrap().parse().unwrap()
    }

    /// Saves, and checks that the file has the picture that is shown.
    fn saves(&mut self, truth: &mut Truth, context: &str) {
        self.press(SAVE);
        let iterations = self.written("saved.exr", context);
        let (_, image) = truth.after(iterations, &self.session);
        let path = self.rendering.path("saved.exr");
        assert!(crate::image::file::read(&path).unwrap().pixels == image, "{context}: {iterations} iterations");
        fs::remove_file(path).unwrap();
        let shown = self.shows(truth, context);
        assert!(iterations > 0 && (iterations == shown || !self.session.paused), "{context}: {iterations}");
    }

    /// Presses a key and checks its effects: the action of the window, the picture and the saved file.
    fn check(&mut self, truth: &mut Truth, key: (Key, Chord), state: &str) {
        let context = format!("{key:?} while {state}");
        let before = Before::new(&self.session);
        let effect = self.press(key);
        before.check(self, key, effect, &context);
        if key == SAVE {
            assert!(self.written("saved.exr", &context) > 0, "{context}");
            fs::remove_file(self.rendering.path("saved.exr")).unwrap();
        }
        self.shows(truth, &context);
        self.saves(truth, &context);
    }
}

const SAVE: (Key, Chord) = (Key::S, Chord::Command);
const SPACE: (Key, Chord) = plain(Key::Space);

const fn plain(key: Key) -> (Key, Chord) {
    (key, Chord::Plain)
}

/// Returns the keys of the table that what is rendered or saved depends on. `key_tests` has all keys.
fn every_key() -> impl Iterator<Item = (Key, Chord)> {
    let reaches_render = |does: Does| match does {
        Does::Fly(_) => true,
        Does::Command(command) => matches!(
            command,
            Command::Show(_)
                | Command::Widen(_)
                | Command::Undo
                | Command::Redo
                | Command::Reset
                | Command::Pause
                | Command::Save
                | Command::Panel
                | Command::Quit
        ),
    };
    let bindings = BINDINGS.iter().filter(move |binding| reaches_render(binding.does));
    bindings.map(|binding| (binding.keys[0], binding.with))
}

/// The values that keys change immediately.
#[derive(Clone, Copy, PartialEq, Debug)]
struct Before {
    quantity: Quantity,
    paused: bool,
    has_panel: bool,
    camera: Camera,
}

impl Before {
    fn new(session: &Session) -> Self {
        let camera = *session.control.camera();
        Self { quantity: session.quantity, paused: session.paused, has_panel: session.has_panel, camera }
    }

    fn check(self, hand: &Hand, key: (Key, Chord), effect: Option<Effect>, context: &str) {
        let after = Self::new(&hand.session);
        let mut expected = self;
        let binding = BINDINGS.iter().find(|binding| binding.keys.contains(&key.0) && binding.with == key.1).unwrap();
        match binding.does {
            Does::Command(Command::Show(quantity)) => expected.quantity = quantity,
            Does::Command(Command::Pause) => expected.paused = !self.paused,
            Does::Command(Command::Panel) => expected.has_panel = !self.has_panel,
            Does::Command(Command::Reset) => {
                assert!(hand.session.control.is_home(), "{context}");
                expected.camera = after.camera;
            }
            Does::Command(Command::Undo | Command::Redo) => expected.camera = after.camera,
            Does::Command(Command::Widen(_)) | Does::Fly(_) => {
                assert!(after.camera != self.camera, "{context}");
                expected.camera = after.camera;
            }
            Does::Command(_) => {}
        }
        assert_eq!(after, expected, "{context}");
        let is_quit = binding.does == Does::Command(Command::Quit);
        assert_eq!(effect, is_quit.then_some(Effect::Quit), "{context}");
    }
}

#[test]
fn every_key_while_it_renders() {
    let mut truth = Truth::new();
    let mut hand = Hand::new();
    hand.rendering.start();
    for key in every_key() {
        if hand.session.paused {
            hand.press(SPACE);
        }
        hand.session.reset();
        hand.session.show(Quantity::Image);
        hand.rest();
        hand.press(plain(Key::Q));
        let moves = hand.session.moves;
        let is_whole = |hand: &Hand| {
            hand.session.seen == moves && hand.picture.as_ref().is_some_and(|picture| picture.size == [24, 16])
        };
        hand.look("a whole image", |hand| is_whole(hand).then_some(()));
        hand.check(&mut truth, key, "it renders");
    }
}

/// While the scene is read or prepared, wishes are carried out after that.
#[test]
fn every_key_while_it_loads() {
    let mut truth = Truth::new();
    for key in every_key() {
        let mut hand = Hand::new();
        let context = format!("{key:?} while it loads");
        let before = Before::new(&hand.session);
        let effect = hand.press(key);
        before.check(&hand, key, effect, &context);
        hand.rendering.start();
        hand.shows(&mut truth, &context);
        if key == SAVE {
            assert!(hand.written("saved.exr", &context) > 0, "{context}");
        }
    }
}

#[test]
fn what_is_asked_for_while_a_scene_is_read_again_is_of_that() {
    let mut truth = Truth::new();
    let mut hand = Hand::new();
    hand.rendering.start();
    for key in [plain(Key::Num8), plain(Key::Num2), plain(Key::W)] {
        hand.session.reload();
        hand.press(key);
        hand.saves(&mut truth, "it is read again");
    }
    assert_eq!(hand.session.quantity, Quantity::Direct);
}

#[test]
fn every_key_while_it_is_paused() {
    let mut truth = Truth::new();
    let mut hand = Hand::new();
    hand.rendering.start();
    for key in every_key() {
        hand.session.reset();
        if hand.session.paused {
            hand.press(SPACE);
        }
        hand.session.show(Quantity::Image);
        hand.look("some iterations", |hand| (hand.session.status.iterations > 1).then_some(()));
        hand.press(SPACE);
        hand.rest();
        hand.check(&mut truth, key, "it is paused");
    }
}

#[test]
fn every_key_while_it_is_paused_and_moved() {
    let mut truth = Truth::new();
    let mut hand = Hand::new();
    hand.press(SPACE);
    hand.rendering.start();
    assert_eq!(hand.shows(&mut truth, "paused from the beginning"), 1);
    for key in every_key() {
        hand.session.paused = true;
        hand.rendering.shared.wish(false, |wish| wish.paused = true);
        hand.session.show(Quantity::Image);
        hand.press(plain(Key::D));
        hand.check(&mut truth, key, "it is paused and moves");
        hand.session.reset();
        hand.press(plain(Key::A));
        hand.rest();
        hand.check(&mut truth, key, "it is paused and was moved");
    }
}

#[test]
fn every_key_while_it_is_coarse() {
    let mut truth = Truth::new();
    let mut hand = Hand::new();
    hand.rendering.start();
    hand.rest();
    for key in every_key() {
        hand.session.reset();
        hand.session.show(Quantity::Image);
        hand.rest();
        hand.press(plain(Key::E));
        // As if the camera never came to rest.
        let later = Instant::now() + Duration::from_secs(1000);
        hand.rendering.shared.wish(true, |wish| wish.moved = Some(later));
        hand.look("a coarse picture", |hand| (hand.picture.as_ref()?.size[0] < 24).then_some(()));
        let context = format!("{key:?} while it is coarse");
        let before = Before::new(&hand.session);
        let effect = hand.press(key);
        before.check(&hand, key, effect, &context);
        hand.rendering.shared.wish(true, |wish| wish.moved = Some(later));
        let quantity = hand.session.quantity;
        hand.look("a coarse picture of it", |hand| (hand.picture.as_ref()?.quantity == quantity).then_some(()));
        std::thread::sleep(Duration::from_millis(20));
        assert!(!hand.rendering.path("saved.exr").exists(), "{context}");
        hand.rendering.shared.wish(true, |wish| wish.moved = None);
        if key == SAVE {
            assert!(hand.written("saved.exr", &context) > 0, "{context}");
            fs::remove_file(hand.rendering.path("saved.exr")).unwrap();
        }
        hand.shows(&mut truth, &context);
        hand.saves(&mut truth, &context);
    }
}

/// A scene with an error leaves the old scene unchanged.
#[test]
fn every_key_with_an_error_of_the_scene_shown() {
    let mut truth = Truth::new();
    let mut hand = Hand::new();
    hand.rendering.start();
    hand.rest();
    fs::write(hand.rendering.path("scene.pbrt"), "LookAt oops").unwrap();
    for key in every_key() {
        hand.session.reset();
        hand.session.show(Quantity::Image);
        hand.session.reload();
        hand.look("an error", |hand| hand.session.message.clone()?.err());
        hand.check(&mut truth, key, "an error is shown");
    }
}

/// Invalid options leave the old image, which the window still shows. It does not have the wished options, so
/// it is not saved.
#[test]
fn every_key_with_an_error_of_the_options_shown() {
    let mut truth = Truth::new();
    let mut hand = Hand::new();
    hand.rendering.start();
    for key in every_key() {
        hand.session.reset();
        hand.session.show(Quantity::Image);
        hand.rest();
        hand.session.options.radius = Some(1e9);
        hand.session.changed_options();
        let is_wrong = |hand: &Hand| hand.session.message.clone()?.err().filter(|error| error.contains("a radius of"));
        hand.look("an error", is_wrong);
        let context = format!("{key:?} with an error shown");
        let before = Before::new(&hand.session);
        let effect = hand.press(key);
        before.check(&hand, key, effect, &context);
        if hand.session.quantity.is_in(&hand.session.options) {
            let quantity = hand.session.quantity;
            hand.look("a picture of it", |hand| (hand.picture.as_ref()?.quantity == quantity).then_some(()));
        }
        hand.press(SAVE);
        hand.look("a refusal", |hand| {
            hand.session.message.clone()?.err().filter(|error| error.contains("not written"))
        });
        assert!(!hand.rendering.path("saved.exr").exists(), "{context}");
        hand.session.options.radius = None;
        hand.session.changed_options();
        hand.shows(&mut truth, &context);
        hand.saves(&mut truth, &context);
    }
}

/// Showing parts of the light, or layers that the image was not rendered with, loses no iteration, paused or not.
#[test]
fn an_image_that_is_left_for_a_part_of_its_light_comes_back_with_all_its_iterations() {
    let mut truth = Truth::new();
    for paused in [true, false] {
        let mut hand = Hand::new();
        hand.rendering.start();
        hand.rest();
        assert_eq!(hand.session.status.iterations, MOST);
        if paused {
            hand.press(SPACE);
            for digit in [Key::Num2, Key::Num3, Key::Num8, Key::Num5, Key::Num2] {
                hand.press(plain(digit));
                assert_eq!(hand.shows(&mut truth, "a part of the light or a layer, paused"), 1, "{digit:?}");
            }
        } else {
            hand.press(plain(Key::Num2));
        }
        for digit in [Key::Num1, Key::Num6] {
            hand.press(plain(digit));
            hand.rest();
            assert_eq!(hand.shows(&mut truth, "back again"), MOST, "{digit:?}");
        }
        hand.saves(&mut truth, "back again");
    }
}

/// The first file is saved before the camera moves, the second one after it.
#[test]
fn a_file_gets_what_was_shown_when_it_was_asked_for() {
    let mut truth = Truth::new();
    let mut hand = Hand::new();
    hand.rendering.start();
    hand.shows(&mut truth, "at first");
    let (_, image) = truth.after(MOST, &hand.session);
    hand.press(SAVE);
    hand.session.save_text = hand.rendering.path("other.exr").display().to_string();
    hand.press(plain(Key::W));
    hand.press(SAVE);
    let iterations = hand.written("other.exr", "after the move");
    assert!(crate::image::file::read(&hand.rendering.path("saved.exr")).unwrap().pixels == image);
    let (_, image) = truth.after(iterations, &hand.session);
    assert!(crate::image::file::read(&hand.rendering.path("other.exr")).unwrap().pixels == image, "{iterations}");
}

/// The initial numbers of the panel are of the full image, even if a coarse picture is shown.
#[test]
fn numbers_of_the_panel_are_those_of_the_image() {
    let hand = Hand::new();
    assert_eq!(hand.session.own_photons(), 500, "as the scene says");
    assert_eq!(hand.session.own_radius(), 0.5);
    let text = SCENE.replace("\"integer photonsperiteration\" 500 \"float radius\" 0.5", "");
    let scene = Scene::parse(&text, "scene.pbrt", ".").unwrap();
    let options = Options { resolution: Some([1200, 600]), radius_in_pixels: Some(2.0), ..Options::default() };
    let shared = Arc::clone(&hand.rendering.shared);
    let mut session = Session::new("scene.pbrt".as_ref(), &scene, options, None, shared);
    session.status.resolution = [150, 75];
    assert_eq!(session.own_photons(), 720_000);
    let pixel = session.control.pixel_width([1200, 600]);
    assert_eq!(session.own_radius(), 2.0 * pixel);
    session.options.radius_in_pixels = None;
    assert_eq!(session.own_radius(), 3.0 * pixel);
}
