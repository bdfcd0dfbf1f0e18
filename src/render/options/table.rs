//! The options of a render, each defined once. The arguments of `goblet render` and `goblet view`,
//! the options that `goblet measure` varies, the identity of a checkpoint, the viewer's panel and
//! `docs/options.md` follow from this table.
//!
//! To add an option, add its entry here and its field to [`Options`], and use the field.

mod entries;

pub use entries::OPTIONS;

use super::request::Request;
use super::values::{count, number};
use super::{Options, Resolved};
use crate::base::names::{Name, expected_name};

/// The text with which a trial chooses a number.
pub const AUTO: &str = "auto";

/// An option of a render.
pub struct RenderOption {
    /// The name on the command line, without the two dashes.
    pub name: &'static str,
    /// The placeholder of the value in the help, such as `N`.
    pub placeholder: &'static str,
    /// The values that the option accepts.
    pub kind: Kind,
    /// Unit of the value; empty if it has none.
    pub unit: &'static str,
    /// The value that is used if the option is not given.
    pub fallback: Fallback,
    /// Heading of the help under which the option is listed.
    pub group: &'static str,
    /// A description of the option in one line without a full stop.
    pub help: &'static str,
    /// More sentences for the long help; may be empty.
    pub more: &'static str,
    /// What the option changes.
    pub(crate) effect: Effect,
    /// How the option depends on other options.
    pub needs: Needs,
    /// Whether `goblet measure` can vary the option.
    pub is_knob: bool,
}

/// The values of an option, and the function that stores a value in a request. A range includes its ends.
pub enum Kind {
    /// Whole numbers, which may have an exponent, as in `5e8`.
    Whole {
        /// The smallest and the largest value.
        range: [u64; 2],
        /// Stores a value of the range.
        set: fn(&mut Request, u64),
    },
    /// Whole numbers as above, or `auto`.
    WholeOrAuto {
        /// The smallest and the largest value.
        range: [u64; 2],
        /// Stores a value of the range; `None` for `auto`.
        set: fn(&mut Request, Option<u64>),
    },
    /// Numbers.
    Number {
        /// The smallest and the largest value.
        range: [f64; 2],
        /// Stores a value of the range.
        set: fn(&mut Request, f64),
    },
    /// One of a few names.
    Named {
        /// The names.
        names: &'static [Name],
        /// Stores the value with this name.
        set: fn(&mut Request, &str) -> Result<(), String>,
    },
    /// Text of another form.
    Form {
        /// A description of the accepted text, as in `WIDTHxHEIGHT`.
        expected: &'static str,
        /// Reads a value and stores it.
        set: fn(&mut Request, &str) -> Result<(), String>,
    },
}

/// The value that is used if an option is not given.
pub enum Fallback {
    /// No value: without it, the option has no effect.
    Nothing,
    /// The scene's value.
    Scene,
    /// A value that the text describes.
    Words(&'static str),
    /// The scene's value; if the scene has none, a number and its unit.
    SceneOrNumber(f64, &'static str),
    /// A number and its unit.
    Number(f64, &'static str),
    /// One of the names of the option.
    Name(fn() -> &'static str),
}

/// What an option changes.
pub(crate) enum Effect {
    /// The image. A checkpoint stores the value under a name, and can be continued only with this value.
    Image(&'static str, fn(&Options, &Resolved) -> String),
    /// The image. In a checkpoint, the value is part of the value of an earlier option.
    PartOf,
    /// The end of the render.
    End,
    /// Time and memory only, not the image.
    Cost,
}

/// How an option depends on other options.
pub enum Needs {
    /// The option does not depend on other options.
    Nothing,
    /// The option has a meaning only if another option has a certain value: its name and the value.
    Value(&'static str, &'static str),
    /// The option cannot be combined with the option of this name.
    Absence(&'static str),
}

impl RenderOption {
    /// Reads the text of a value and stores the value in a request.
    ///
    /// # Errors
    /// The option does not accept the value; the message says what is expected.
    pub fn set(&self, request: &mut Request, text: &str) -> Result<(), String> {
        let expected = || format!("expected {}", self.kind.expected());
        match self.kind {
            Kind::Whole { range: [least, most], set } => {
                let value = count(text).filter(|value| (least..=most).contains(value));
                set(request, value.ok_or_else(expected)?);
            }
            Kind::WholeOrAuto { set, .. } if text == AUTO => set(request, None),
            Kind::WholeOrAuto { range: [least, most], set } => {
                let value = count(text).filter(|value| (least..=most).contains(value));
                set(request, Some(value.ok_or_else(expected)?));
            }
            Kind::Number { range: [least, most], set } => {
                let accepted = |value| (least..=most).contains(&value);
                set(request, number(text, accepted, &self.kind.expected())?);
            }
            Kind::Named { set, .. } | Kind::Form { set, .. } => set(request, text)?,
        }
        Ok(())
    }

    /// Returns the smallest and the largest value of the option; `None` if its values are not numbers.
    pub fn range(&self) -> Option<[f64; 2]> {
        match self.kind {
            Kind::Whole { range, .. } | Kind::WholeOrAuto { range, .. } => Some(range.map(|end| end as f64)),
            Kind::Number { range, .. } => Some(range),
            Kind::Named { .. } | Kind::Form { .. } => None,
        }
    }

    /// Returns the value that is used if the option is not given, in words: `4`, `the scene's, else 3px`.
    /// Empty if there is none.
    pub fn default_text(&self) -> String {
        match self.fallback {
            Fallback::Nothing => String::new(),
            Fallback::Scene => "the scene's".to_owned(),
            Fallback::Words(words) => words.to_owned(),
            Fallback::SceneOrNumber(number, unit) => format!("the scene's, else {}{unit}", short(number)),
            Fallback::Number(number, unit) => format!("{}{unit}", short(number)),
            Fallback::Name(name) => name().to_owned(),
        }
    }

    /// Returns whether the option changes the image other than by the end of the render.
    pub fn changes_image(&self) -> bool {
        matches!(self.effect, Effect::Image(..) | Effect::PartOf)
    }
}

impl Kind {
    /// Returns the accepted values in words: `a whole number from 1 to 64`.
    pub fn expected(&self) -> String {
        match self {
            Self::Whole { range: [least, most], .. } => format!("a whole number from {least} to {most}"),
            Self::WholeOrAuto { range: [least, most], .. } => {
                format!("a whole number from {least} to {most}, or {AUTO}")
            }
            // Smaller numbers would be rounded to zero on the device.
            Self::Number { range: [least, most], .. } if *least == f64::from(f32::MIN_POSITIVE) => {
                format!("a number above 0 and at most {most}")
            }
            Self::Number { range: [least, most], .. } => format!("a number from {least} to {most}"),
            Self::Named { names, .. } => expected_name(names).trim_start_matches("expected ").to_owned(),
            Self::Form { expected, .. } => (*expected).to_owned(),
        }
    }
}

/// Writes a number with at most four decimals.
fn short(number: f64) -> String {
    ((number * 1e4).round() / 1e4).to_string()
}

/// Returns the option with this name; panics if there is none. In a constant, a wrong name does not compile.
pub const fn find(name: &str) -> &'static RenderOption {
    let mut i = 0;
    while i < OPTIONS.len() {
        if is_same(OPTIONS[i].name.as_bytes(), name.as_bytes()) {
            return &OPTIONS[i];
        }
        i += 1;
    }
    panic!("no option has this name")
}

const fn is_same(a: &[u8], b: &[u8]) -> bool {
    let mut i = 0;
    while i < a.len() && i < b.len() && a[i] == b[i] {
        i += 1;
    }
    i == a.len() && i == b.len()
}

#[cfg(test)]
mod tests;
