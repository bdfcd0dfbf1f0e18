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

/// An option of a render.
pub struct RenderOption {
    /// The name on the command line, after two dashes.
    pub name: &'static str,
    /// What stands for its value in the help, such as `N`.
    pub placeholder: &'static str,
    /// The values that it takes.
    pub kind: Kind,
    /// Unit of the value; empty where it has none.
    pub unit: &'static str,
    /// The value where nobody gives one.
    pub fallback: Fallback,
    /// Heading of the help under which it stands.
    pub group: &'static str,
    /// What it does, in one line without a full stop.
    pub help: &'static str,
    /// The rest of what a user should know; may be empty.
    pub more: &'static str,
    /// What it changes.
    pub(crate) effect: Effect,
    /// How it depends on other options.
    pub needs: Needs,
    /// Whether `goblet measure` can vary it.
    pub is_knob: bool,
}

/// Values of an option, and how a request gets one. The values of a range include its ends.
pub enum Kind {
    /// Whole numbers, also written as in `5e8`.
    Whole {
        /// The least and the largest.
        range: [u64; 2],
        /// Sets a value of the range.
        set: fn(&mut Request, u64),
    },
    /// Numbers.
    Number {
        /// The least and the largest.
        range: [f64; 2],
        /// Sets a value of the range.
        set: fn(&mut Request, f64),
    },
    /// One of a few names.
    Named {
        /// The names.
        names: &'static [Name],
        /// Sets the value of a name.
        set: fn(&mut Request, &str) -> Result<(), String>,
    },
    /// Text of another form.
    Form {
        /// What is expected, as in `WIDTHxHEIGHT`.
        expected: &'static str,
        /// Reads and sets a value.
        set: fn(&mut Request, &str) -> Result<(), String>,
    },
}

/// The value of an option that is not given.
pub enum Fallback {
    /// There is no value: the option changes nothing.
    Nothing,
    /// The scene's value.
    Scene,
    /// What the text says.
    Words(&'static str),
    /// The scene's value; if it has none, a number and its unit.
    SceneOrNumber(f64, &'static str),
    /// A number and its unit.
    Number(f64, &'static str),
    /// One of the names of the option.
    Name(fn() -> &'static str),
}

/// What an option changes.
pub(crate) enum Effect {
    /// The image. A checkpoint keeps the value under a name, and is continued only with this value.
    Image(&'static str, fn(&Options, &Resolved) -> String),
    /// The image. In a checkpoint, the value is a part of that of an option before it.
    PartOf,
    /// When the render ends.
    End,
    /// Time and memory only.
    Cost,
}

/// How an option depends on others.
pub enum Needs {
    /// Not at all.
    Nothing,
    /// It has a meaning only with a value of another option.
    Value(&'static str, &'static str),
    /// It contradicts another option.
    Absence(&'static str),
}

impl RenderOption {
    /// Gives the option a value, as people write it.
    ///
    /// # Errors
    /// What was expected.
    pub fn set(&self, request: &mut Request, text: &str) -> Result<(), String> {
        let expected = || format!("expected {}", self.kind.expected());
        match self.kind {
            Kind::Whole { range: [least, most], set } => {
                let value = count(text).filter(|value| (least..=most).contains(value));
                set(request, value.ok_or_else(expected)?);
            }
            Kind::Number { range: [least, most], set } => {
                let accepted = |value| (least..=most).contains(&value);
                set(request, number(text, accepted, &self.kind.expected())?);
            }
            Kind::Named { set, .. } | Kind::Form { set, .. } => set(request, text)?,
        }
        Ok(())
    }

    /// Its values if they are numbers: the least and the largest.
    pub fn range(&self) -> Option<[f64; 2]> {
        match self.kind {
            Kind::Whole { range, .. } => Some(range.map(|end| end as f64)),
            Kind::Number { range, .. } => Some(range),
            Kind::Named { .. } | Kind::Form { .. } => None,
        }
    }

    /// The value where nobody gives one, in words: `4`, `the scene's, else 3px`. Empty if there is none.
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

    /// Whether it changes the image, apart from how long it is rendered.
    pub fn changes_image(&self) -> bool {
        matches!(self.effect, Effect::Image(..) | Effect::PartOf)
    }
}

impl Kind {
    /// The values in words: `a whole number from 1 to 64`.
    pub fn expected(&self) -> String {
        match self {
            Self::Whole { range: [least, most], .. } => format!("a whole number from {least} to {most}"),
            // Not rounded to zero on the device.
            Self::Number { range: [least, most], .. } if *least == f64::from(f32::MIN_POSITIVE) => {
                format!("a number above 0 and at most {most}")
            }
            Self::Number { range: [least, most], .. } => format!("a number from {least} to {most}"),
            Self::Named { names, .. } => expected_name(names).trim_start_matches("expected ").to_owned(),
            Self::Form { expected, .. } => (*expected).to_owned(),
        }
    }
}

/// At most four decimals.
fn short(number: f64) -> String {
    ((number * 1e4).round() / 1e4).to_string()
}

/// The option that has a name. In a constant, a name that no option has does not compile.
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
