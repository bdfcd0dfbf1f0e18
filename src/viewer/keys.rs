//! Keyboard input: it translates key strokes into commands and into flight, by the [table](super::bindings) of keys. It
//! uses no window.

use std::collections::HashSet;

use egui::{Context, Key, Popup};
use glam::DVec3;

use super::bindings::{BINDINGS, Binding, Chord, Command, Does};

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
        let binding = find(key, with)?;
        let is_for_others = busy.with_keys && !binding.is_for_window() || busy.with_drag && key == Key::Escape;
        match binding.does {
            _ if is_for_others => None,
            Does::Command(command) => Some(command),
            Does::Fly(_) => {
                self.held.insert(key);
                self.tapped.insert(key);
                None
            }
        }
    }

    /// Returns the direction of flight (right, up, forward) of the keys that are held or were pressed since
    /// the last call.
    pub fn flight(&mut self, is_fast: bool) -> DVec3 {
        let tapped = std::mem::take(&mut self.tapped);
        let is_down = |key: &Key| self.held.contains(key) || tapped.contains(key);
        let by: DVec3 = flight().filter(|(key, _)| is_down(key)).map(|(_, by)| by).sum();
        if is_fast { by * FASTER } else { by }
    }

    /// Returns strokes that release all keys of flight. The window needs them when it loses the focus,
    /// because it does not get the releases of keys after that.
    pub fn all_up() -> impl Iterator<Item = Stroke> {
        flight().map(|(key, _)| Stroke { key, is_pressed: false, is_repeat: false, with: With::default() })
    }

    /// Forgets all keys, because they are released or another widget takes them.
    pub fn release(&mut self) {
        *self = Self::default();
    }
}

/// Returns the keys of flight with their directions.
fn flight() -> impl Iterator<Item = (Key, DVec3)> {
    BINDINGS
        .iter()
        .filter_map(|binding| match binding.does {
            Does::Fly(by) => Some(binding.keys.iter().map(move |key| (*key, by))),
            Does::Command(_) => None,
        })
        .flatten()
}

/// Returns the entry of the table for a key with these modifiers.
fn find(key: Key, with: With) -> Option<&'static Binding> {
    let chord = match with {
        With { command: true, shift: false, .. } => Chord::Command,
        With { command: true, shift: true, .. } => Chord::CommandShift,
        With { command: false, .. } => Chord::Plain,
    };
    BINDINGS.iter().find(|binding| binding.with == chord && binding.keys.contains(&key))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::viewer::quantity::Quantity;

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

    fn plain() -> impl Iterator<Item = (&'static Binding, Key)> {
        let plain = BINDINGS.iter().filter(|binding| binding.with == Chord::Plain);
        plain.flat_map(|binding| binding.keys.iter().map(move |key| (binding, *key)))
    }

    fn every_key() -> impl Iterator<Item = Key> {
        BINDINGS.iter().flat_map(|binding| binding.keys).copied()
    }

    #[test]
    fn every_entry_of_the_table_is_found_by_its_keys() {
        for binding in BINDINGS {
            let with = match binding.with {
                Chord::Plain => PLAIN_KEY,
                Chord::Command => CTRL,
                Chord::CommandShift => With { shift: true, ..CTRL },
            };
            for key in binding.keys {
                let found = Keys::default().take(down(*key, with), FREE);
                let expected = if let Does::Command(command) = binding.does { Some(command) } else { None };
                assert_eq!(found, expected, "{key:?} {with:?}");
            }
        }
    }

    #[test]
    fn a_chord_is_no_plain_key() {
        for with in
            [CTRL, With { shift: true, ..CTRL }, With { other: true, ..PLAIN_KEY }, With { other: true, ..CTRL }]
        {
            let mut keys = Keys::default();
            for (binding, key) in plain() {
                let command = keys.take(down(key, with), FREE);
                let is_plain = matches!(binding.does, Does::Command(plain) if command == Some(plain));
                assert!(!is_plain && (!with.other || command.is_none()), "{key:?} {with:?}: {command:?}");
                assert_eq!(keys.take(up(key, with), FREE), None);
            }
            assert_eq!(keys.flight(false), DVec3::ZERO, "{with:?}");
        }
    }

    /// Where a text has the focus, Ctrl+Z is its own, and Ctrl+S saves.
    #[test]
    fn files_can_be_saved_while_a_text_is_typed() {
        let mut keys = Keys::default();
        assert_eq!(keys.take(down(Key::Z, CTRL), TYPING), None);
        assert_eq!(keys.take(down(Key::Z, CTRL), FREE), Some(Command::Undo));
        assert_eq!(keys.take(down(Key::S, CTRL), TYPING), Some(Command::Save));
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
        for (_, key) in plain() {
            assert_eq!(keys.take(down(key, PLAIN_KEY), TYPING), None, "{key:?}");
        }
        assert_eq!(keys.flight(false), DVec3::ZERO);
        let dragging = Busy { with_drag: true, ..FREE };
        assert_eq!(keys.take(down(Key::Escape, PLAIN_KEY), dragging), None, "it ends the drag");
        assert_eq!(keys.take(down(Key::Num4, PLAIN_KEY), dragging), Some(Command::Show(Quantity::ALL[3])));
        assert_eq!(keys.take(down(Key::F1, PLAIN_KEY), dragging), Some(Command::Keys));
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
        for (key, by) in flight() {
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
