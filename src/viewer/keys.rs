//! Keyboard input: it translates key strokes into commands and into flight. It uses no window.

use std::collections::HashSet;

use egui::{Context, Key, Popup};
use glam::DVec3;

use super::quantity::Quantity;

/// A press or a release of a key.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stroke {
    /// The key.
    pub key: Key,
    /// Whether the key was pressed; else it was released.
    pub is_pressed: bool,
    /// Whether the system repeats a key that is held.
    pub is_repeat: bool,
    /// The modifiers that were held at that moment.
    pub with: With,
}

/// The modifier keys.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct With {
    /// The key of commands: Ctrl, or Cmd on a Mac.
    pub command: bool,
    /// Alt, Super, or Ctrl if Ctrl is not the key of commands.
    pub other: bool,
    /// Shift.
    pub shift: bool,
}

/// Whether other parts of the interface take keys.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Busy {
    /// Whether a text field or another widget has the focus, or a list is open, and takes plain keys.
    pub with_keys: bool,
    /// Whether a drag is in progress, which Esc ends.
    pub with_drag: bool,
}

impl Busy {
    /// Returns the state between two frames.
    pub fn of(context: &Context) -> Self {
        Self {
            with_keys: context.wants_keyboard_input() || Popup::is_any_open(context),
            with_drag: context.dragged_id().is_some(),
        }
    }

    /// Returns the state during a frame, from the states before (`self`) and after it. A widget that took
    /// keys before the frame has got the keys, even if they closed it; so has a widget that takes keys after
    /// it.
    pub fn until(self, after: Self) -> Self {
        Self { with_keys: self.with_keys || after.with_keys, with_drag: self.with_drag || after.with_drag }
    }
}

/// The command of a key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// Show this quantity.
    Show(Quantity),
    /// Reset the camera to the one of the scene.
    Reset,
    /// Pause or continue.
    Pause,
    /// Copy the camera as pbrt text.
    Copy,
    /// Show or hide the panel.
    Panel,
    /// Save to the file that the panel names.
    Save,
    /// Close the window.
    Quit,
}

/// Keys that show a quantity, in the order of [`Quantity::ALL`].
pub(super) const DIGITS: [Key; 10] =
    [Key::Num1, Key::Num2, Key::Num3, Key::Num4, Key::Num5, Key::Num6, Key::Num7, Key::Num8, Key::Num9, Key::Num0];
/// Plain keys with a command.
const PLAIN: [(Key, Command); 5] = [
    (Key::R, Command::Reset),
    (Key::Space, Command::Pause),
    (Key::C, Command::Copy),
    (Key::H, Command::Panel),
    (Key::Escape, Command::Quit),
];
/// Keys that fly, with their directions: x is right, y is up, z is forward.
const FLIGHT: [(Key, DVec3); 6] = [
    (Key::D, DVec3::X),
    (Key::A, DVec3::NEG_X),
    (Key::E, DVec3::Y),
    (Key::Q, DVec3::NEG_Y),
    (Key::W, DVec3::Z),
    (Key::S, DVec3::NEG_Z),
];
/// The factor of the speed while shift is held.
const FASTER: f64 = 4.0;

/// The keys of flight that are held.
#[derive(Debug, Default)]
pub struct Keys {
    /// The keys that are held.
    held: HashSet<Key>,
    /// The keys that were pressed since the last call of `flight`. They count once, even if released.
    tapped: HashSet<Key>,
}

impl Keys {
    /// Takes a stroke and returns its command, if it has one. The modifiers are the ones that were held with
    /// the stroke, even if they are released before this call.
    pub fn take(&mut self, stroke: Stroke, busy: Busy) -> Option<Command> {
        let Stroke { key, is_pressed, is_repeat, with } = stroke;
        if !is_pressed {
            self.held.remove(&key);
            return None;
        }
        if is_repeat || with.other {
            return None;
        }
        if with.command {
            return (key == Key::S && !with.shift).then_some(Command::Save);
        }
        if busy.with_keys || (busy.with_drag && key == Key::Escape) {
            return None;
        }
        if FLIGHT.iter().any(|(other, _)| *other == key) {
            self.held.insert(key);
            self.tapped.insert(key);
        }
        command(key)
    }

    /// Returns the direction of flight (right, up, forward) of the keys that are held or were pressed since
    /// the last call.
    pub fn flight(&mut self, is_fast: bool) -> DVec3 {
        let tapped = std::mem::take(&mut self.tapped);
        let is_down = |key| self.held.contains(key) || tapped.contains(key);
        let by: DVec3 = FLIGHT.iter().filter(|(key, _)| is_down(key)).map(|(_, by)| *by).sum();
        if is_fast { by * FASTER } else { by }
    }

    /// Returns strokes that release all keys of flight. The window needs them when it loses the focus,
    /// because it does not get the releases of keys after that.
    pub fn all_up() -> impl Iterator<Item = Stroke> {
        FLIGHT.iter().map(|(key, _)| Stroke { key: *key, is_pressed: false, is_repeat: false, with: With::default() })
    }

    /// Forgets all keys, because they are released or another widget takes them.
    pub fn release(&mut self) {
        *self = Self::default();
    }
}

/// Returns the command of a key without modifiers.
fn command(key: Key) -> Option<Command> {
    let shown = DIGITS.iter().position(|digit| *digit == key).and_then(|place| Quantity::ALL.get(place));
    let shown = shown.map(|quantity| Command::Show(*quantity));
    shown.or_else(|| PLAIN.iter().find(|(other, _)| *other == key).map(|(_, command)| *command))
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLAIN_KEY: With = With { command: false, other: false, shift: false };
    const CTRL: With = With { command: true, ..PLAIN_KEY };
    const FREE: Busy = Busy { with_keys: false, with_drag: false };
    const TYPING: Busy = Busy { with_keys: true, ..FREE };

    fn down(key: Key, with: With) -> Stroke {
        Stroke { key, is_pressed: true, is_repeat: false, with }
    }

    fn up(key: Key, with: With) -> Stroke {
        Stroke { is_pressed: false, ..down(key, with) }
    }

    fn every_key() -> impl Iterator<Item = Key> {
        DIGITS.into_iter().chain(PLAIN.map(|(key, _)| key)).chain(FLIGHT.map(|(key, _)| key))
    }

    #[test]
    fn every_plain_key_has_its_command() {
        let mut keys = Keys::default();
        let commands: Vec<_> = every_key().map(|key| keys.take(down(key, PLAIN_KEY), FREE)).collect();
        let shown = Quantity::ALL.iter().take(DIGITS.len()).map(|quantity| Some(Command::Show(*quantity)));
        let shown: Vec<_> = shown.collect();
        let plain = PLAIN.map(|(_, command)| Some(command));
        assert_eq!(commands, [&shown[..], &plain, &[None; 6]].concat());
    }

    #[test]
    fn with_ctrl_alt_or_super_no_key_is_plain() {
        for with in [CTRL, With { other: true, ..PLAIN_KEY }, With { other: true, ..CTRL }] {
            let mut keys = Keys::default();
            for key in every_key() {
                let is_save = key == Key::S && with == CTRL;
                assert_eq!(keys.take(down(key, with), FREE), is_save.then_some(Command::Save), "{key:?} {with:?}");
                assert_eq!(keys.take(up(key, with), FREE), None);
            }
            assert_eq!(keys.flight(false), DVec3::ZERO, "{with:?}");
        }
    }

    /// In any order of releases, and with any focus.
    #[test]
    fn a_quick_save_is_a_save_and_no_flight() {
        let orders = [
            vec![down(Key::S, CTRL), up(Key::S, CTRL)],
            vec![down(Key::S, CTRL), up(Key::S, PLAIN_KEY)],
            vec![down(Key::S, CTRL), Stroke { is_repeat: true, ..down(Key::S, PLAIN_KEY) }],
        ];
        for strokes in orders {
            for busy in [FREE, TYPING, Busy { with_drag: true, ..FREE }] {
                let mut keys = Keys::default();
                let commands: Vec<_> = strokes.iter().filter_map(|stroke| keys.take(*stroke, busy)).collect();
                assert_eq!(commands, [Command::Save], "{strokes:?} {busy:?}");
                assert_eq!(keys.flight(false), DVec3::ZERO);
            }
        }
    }

    #[test]
    fn what_is_typed_is_no_command() {
        let mut keys = Keys::default();
        for key in every_key() {
            assert_eq!(keys.take(down(key, PLAIN_KEY), TYPING), None, "{key:?}");
        }
        assert_eq!(keys.flight(false), DVec3::ZERO);
        let dragging = Busy { with_drag: true, ..FREE };
        assert_eq!(keys.take(down(Key::Escape, PLAIN_KEY), dragging), None, "it ends the drag");
        assert_eq!(keys.take(down(Key::Num4, PLAIN_KEY), dragging), Some(Command::Show(Quantity::ALL[3])));
    }

    #[test]
    fn repeats_are_no_commands() {
        let mut keys = Keys::default();
        for key in every_key() {
            let stroke = Stroke { is_repeat: true, ..down(key, PLAIN_KEY) };
            assert_eq!(keys.take(stroke, FREE), None, "{key:?}");
        }
        assert_eq!(keys.flight(false), DVec3::ZERO);
    }

    #[test]
    fn keys_fly_while_they_are_down_and_at_least_once() {
        let mut keys = Keys::default();
        for (key, by) in FLIGHT {
            keys.take(down(key, PLAIN_KEY), FREE);
            assert_eq!([keys.flight(false), keys.flight(false)], [by; 2]);
            keys.take(up(key, PLAIN_KEY), FREE);
            assert_eq!(keys.flight(false), DVec3::ZERO);
            keys.take(down(key, PLAIN_KEY), FREE);
            keys.take(up(key, PLAIN_KEY), FREE);
            assert_eq!([keys.flight(false), keys.flight(false)], [by, DVec3::ZERO], "a tap");
        }
        keys.take(down(Key::W, With { shift: true, ..PLAIN_KEY }), FREE);
        assert_eq!(keys.flight(true), DVec3::Z * FASTER);
        Keys::all_up().for_each(|stroke| assert_eq!(keys.take(stroke, FREE), None));
        assert_eq!(keys.flight(false), DVec3::ZERO);
    }
}
