//! The table of keys. The commands of the keyboard, the list of keys in the window (F1), the table in docs/view.md and
//! the tests of every key follow from it.

use egui::Key;
use glam::DVec3;

use super::dialog::Question;
use super::quantity::Quantity;

/// The command of a key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// Show this quantity.
    Show(Quantity),
    /// Show the quantity in its next colours: its own, or false ones.
    Colors,
    /// Change the exposure by so many half stops.
    Expose(i8),
    /// Choose the exposure by the image, or keep it as it is.
    AutoExpose,
    /// Show more (true) or less of the image's detail.
    Zoom(bool),
    /// Show the whole image.
    Fit,
    /// Show each pixel of the image at a pixel of the window.
    Pixels,
    /// Move the image in the window: to the right and down, in eighths of the area.
    Shift([i8; 2]),
    /// Make the field of view wider (true) or narrower.
    Widen(bool),
    /// Return to the place of the camera before the last move.
    Undo,
    /// Take back the last undoing.
    Redo,
    /// Reset the camera to the one of the scene.
    Reset,
    /// Copy the camera as pbrt text.
    Copy,
    /// Keep the picture for comparison.
    Keep,
    /// Show the kept picture, or the current one again.
    Flip,
    /// Show both beside each other, or the current one again.
    Split,
    /// Move the line between both to the right (true) or to the left.
    MoveSplit(bool),
    /// Pause or continue.
    Pause,
    /// Save to the file that the panel names, or to the next free name.
    Save,
    /// Ask the user for a file.
    Ask(Question),
    /// Show or hide the panel.
    Panel,
    /// Show or hide the list of keys.
    Keys,
    /// Close the list of keys, or the window.
    Quit,
}

/// The modifiers of a key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Chord {
    /// None, or shift.
    Plain,
    /// Ctrl, or Cmd on a Mac.
    Command,
    /// The same with shift.
    CommandShift,
}

/// What a key does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Does {
    /// It gives a command.
    Command(Command),
    /// It flies while it is down: x is right, y is up, z is forward.
    Fly(DVec3),
}

/// An entry of the table.
#[derive(Clone, Copy, Debug)]
pub struct Binding {
    /// The keys, each of which does the same.
    pub keys: &'static [Key],
    /// The modifiers.
    pub with: Chord,
    /// What the key does.
    pub does: Does,
    /// What the list of keys says; of quantities, it says their names.
    help: &'static str,
}

/// A part of the table with its title in the list of keys.
type Part = (&'static str, &'static [Binding]);

const fn plain(keys: &'static [Key], command: Command, help: &'static str) -> Binding {
    Binding { keys, with: Chord::Plain, does: Does::Command(command), help }
}

const fn ctrl(keys: &'static [Key], command: Command, help: &'static str) -> Binding {
    Binding { with: Chord::Command, ..plain(keys, command, help) }
}

const fn ctrl_shift(keys: &'static [Key], command: Command, help: &'static str) -> Binding {
    Binding { with: Chord::CommandShift, ..plain(keys, command, help) }
}

const fn shows(keys: &'static [Key], index: usize) -> Binding {
    plain(keys, Command::Show(Quantity::ALL[index]), "")
}

const fn flies(keys: &'static [Key], by: DVec3, help: &'static str) -> Binding {
    Binding { keys, with: Chord::Plain, does: Does::Fly(by), help }
}

const CAMERA: [Binding; 13] = [
    flies(&[Key::W], DVec3::Z, "fly forward; faster with shift"),
    flies(&[Key::S], DVec3::NEG_Z, "fly backward"),
    flies(&[Key::A], DVec3::NEG_X, "fly to the left"),
    flies(&[Key::D], DVec3::X, "fly to the right"),
    flies(&[Key::E], DVec3::Y, "fly up"),
    flies(&[Key::Q], DVec3::NEG_Y, "fly down"),
    plain(&[Key::OpenBracket, Key::PageDown], Command::Widen(false), "narrower field of view"),
    plain(&[Key::CloseBracket, Key::PageUp], Command::Widen(true), "wider field of view"),
    ctrl(&[Key::Z], Command::Undo, "undo the last move of the camera"),
    ctrl(&[Key::Y], Command::Redo, "redo the move"),
    ctrl_shift(&[Key::Z], Command::Redo, "redo the move"),
    plain(&[Key::R], Command::Reset, "back to the camera of the scene"),
    plain(&[Key::C], Command::Copy, "copy the camera as pbrt text"),
];

const IMAGE: [Binding; 9] = [
    plain(&[Key::Plus, Key::Equals], Command::Zoom(true), "enlarge the image at the cursor"),
    plain(&[Key::Minus], Command::Zoom(false), "make the image smaller"),
    plain(&[Key::F], Command::Fit, "fit the whole image into the window"),
    plain(&[Key::X], Command::Pixels, "show the image in its own size"),
    plain(&[Key::ArrowLeft], Command::Shift([1, 0]), "show what is to the left"),
    plain(&[Key::ArrowRight], Command::Shift([-1, 0]), "show what is to the right"),
    plain(&[Key::ArrowUp], Command::Shift([0, 1]), "show what is above"),
    plain(&[Key::ArrowDown], Command::Shift([0, -1]), "show what is below"),
    plain(&[Key::G], Command::Colors, "own colours, or false ones"),
];

const LOOK: [Binding; 13] = [
    shows(&[Key::Num1], 0),
    shows(&[Key::Num2], 1),
    shows(&[Key::Num3], 2),
    shows(&[Key::Num4], 3),
    shows(&[Key::Num5], 4),
    shows(&[Key::Num6], 5),
    shows(&[Key::Num7], 6),
    shows(&[Key::Num8], 7),
    shows(&[Key::Num9], 8),
    shows(&[Key::Num0], 9),
    plain(&[Key::O], Command::Expose(-1), "darker by half a stop"),
    plain(&[Key::P], Command::Expose(1), "brighter by half a stop"),
    plain(&[Key::L], Command::AutoExpose, "exposure by the image, or as it is"),
];

const COMPARE: [Binding; 6] = [
    plain(&[Key::K], Command::Keep, "keep this image to compare with"),
    plain(&[Key::B], Command::Flip, "the kept image, and this one again"),
    plain(&[Key::V], Command::Split, "both images side by side; drag the line"),
    plain(&[Key::Comma], Command::MoveSplit(false), "move the line to the left"),
    plain(&[Key::Period], Command::MoveSplit(true), "move the line to the right"),
    ctrl(&[Key::B], Command::Ask(Question::Reference), "compare with an image file"),
];

const WINDOW: [Binding; 7] = [
    plain(&[Key::Space], Command::Pause, "pause after this iteration, or go on"),
    ctrl(&[Key::S], Command::Save, "save; a name that exists gets a number"),
    ctrl_shift(&[Key::S], Command::Ask(Question::Save), "choose a file to save to"),
    ctrl(&[Key::O], Command::Ask(Question::Scene), "choose a scene to open"),
    plain(&[Key::H], Command::Panel, "hide or show the panel"),
    plain(&[Key::F1], Command::Keys, "this list"),
    plain(&[Key::Escape], Command::Quit, "close the list, or the window"),
];

/// All keys by their subjects, in the order of the list of keys.
pub const PARTS: [Part; 5] =
    [("Camera", &CAMERA), ("Image", &IMAGE), ("What is shown", &LOOK), ("Compare", &COMPARE), ("Window", &WINDOW)];

const COUNT: usize = CAMERA.len() + IMAGE.len() + LOOK.len() + COMPARE.len() + WINDOW.len();

/// All keys.
pub static BINDINGS: [Binding; COUNT] = {
    let mut all = [CAMERA[0]; COUNT];
    let (mut part, mut place) = (0, 0);
    while part < PARTS.len() {
        let mut index = 0;
        while index < PARTS[part].1.len() {
            all[place] = PARTS[part].1[index];
            (index, place) = (index + 1, place + 1);
        }
        part += 1;
    }
    all
};

/// What the mouse does on the image: the input, and its effect.
pub const MOUSE: [(&str, &str); 9] = [
    ("drag", "turn about the point in focus"),
    ("right drag", "move sideways; so does shift+drag"),
    ("wheel", "move closer or further away"),
    ("click", "focus there, and turn about it"),
    ("Ctrl+wheel", "open or close the aperture"),
    ("Alt+wheel", "enlarge the image at the cursor"),
    ("middle drag", "move the image; so does Alt+drag"),
    ("drag the line", "move it between two images"),
    ("drop a file", "open a scene, or compare an image"),
];

impl Binding {
    /// Returns the names of the keys, as in "Ctrl+Shift+S".
    pub fn name(&self) -> String {
        let with = match self.with {
            Chord::Plain => "",
            Chord::Command => "Ctrl+",
            Chord::CommandShift => "Ctrl+Shift+",
        };
        let names: Vec<String> = self.keys.iter().map(|key| format!("{with}{}", name(*key))).collect();
        names.join(" or ")
    }

    /// Returns what the key does.
    pub fn help(&self) -> String {
        match self.does {
            Does::Command(Command::Show(quantity)) => format!("show {}", quantity.name()),
            _ => self.help.to_owned(),
        }
    }

    /// Returns whether the key has its effect even while a text is typed: keys of files, which no text field has.
    pub fn is_for_window(&self) -> bool {
        matches!(self.does, Does::Command(Command::Save | Command::Ask(_)))
    }
}

/// Returns the name of a key as keyboards and people have it.
fn name(key: Key) -> &'static str {
    match key {
        Key::Plus => "+",
        Key::Equals => "=",
        Key::Minus => "-",
        Key::Comma => ",",
        Key::Period => ".",
        Key::OpenBracket => "[",
        Key::CloseBracket => "]",
        Key::ArrowLeft => "left",
        Key::ArrowRight => "right",
        Key::ArrowUp => "up",
        Key::ArrowDown => "down",
        Key::Escape => "Esc",
        Key::Space => "space",
        key => key.name(),
    }
}

/// Returns the names of all keys with what they do, for tests of the window.
#[must_use]
pub fn key_list() -> Vec<(String, String)> {
    BINDINGS.iter().map(|binding| (binding.name(), binding.help())).collect()
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;
    use std::path::Path;

    use super::*;

    #[test]
    fn no_key_has_two_effects_and_each_is_explained() {
        let mut seen = HashSet::new();
        for binding in BINDINGS.iter() {
            assert!(!binding.help().is_empty() && !binding.keys.is_empty(), "{binding:?}");
            for key in binding.keys {
                assert!(seen.insert((*key, binding.with as u8)), "{key:?} {:?}", binding.with);
            }
        }
    }

    #[test]
    fn the_names_of_keys_are_those_of_keyboards() {
        let names: Vec<String> = BINDINGS.iter().map(Binding::name).collect();
        for expected in ["Ctrl+Shift+S", "+ or =", "0", "left", "[ or PageDown", "Esc", "space", "F1"] {
            assert!(names.iter().any(|name| name == expected), "{expected}: {names:?}");
        }
    }

    const START: &str = "<!-- keys -->\n";
    const END: &str = "<!-- end of keys -->\n";

    /// The table of the guide: mouse and keys, with the keys of an effect in one row.
    fn table() -> String {
        let mut rows = vec!["| input | effect |".to_owned(), "| --- | --- |".to_owned()];
        let mut row = |input: &str, effect: &str| rows.push(format!("| {input} | {effect} |"));
        MOUSE.iter().for_each(|(input, effect)| row(input, effect));
        BINDINGS.iter().for_each(|binding| row(&binding.name(), &binding.help()));
        rows.join("\n") + "\n"
    }

    /// To write the table of the guide again: `GOBLET_WRITE_DOCS=1 cargo test --lib keys_of_the_guide`.
    #[test]
    fn keys_of_the_guide_are_those_of_the_table() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/view.md");
        let text = std::fs::read_to_string(&path).unwrap();
        let (before, rest) = text.split_once(START).expect("a place for the table");
        let (found, after) = rest.split_once(END).expect("an end of the table");
        let expected = table();
        if std::env::var_os("GOBLET_WRITE_DOCS").is_some() {
            std::fs::write(&path, format!("{before}{START}{expected}{END}{after}")).unwrap();
        } else {
            assert!(found == expected, "run GOBLET_WRITE_DOCS=1 cargo test --lib keys_of_the_guide");
        }
    }
}
