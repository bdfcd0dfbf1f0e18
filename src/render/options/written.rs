//! Requests from the texts of option values.

use super::request::Request;
use super::table::{Needs, OPTIONS, RenderOption};

/// The reason why values do not make a [`Request`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Refusal {
    /// An option does not accept its value.
    #[error("invalid value '{value}' for --{option}: {expected}")]
    Value {
        /// The name of the option.
        option: &'static str,
        /// The value.
        value: String,
        /// A description of the accepted values.
        expected: String,
    },
    /// An option has a meaning only if another option has a certain value.
    #[error("--{option} requires --{other} {value}")]
    Requires {
        /// The name of the option.
        option: &'static str,
        /// The other option.
        other: &'static str,
        /// The value that the other option must have.
        value: &'static str,
    },
    /// Two options contradict each other.
    #[error("--{option} cannot be used with --{other}")]
    Excludes {
        /// The name of the option.
        option: &'static str,
        /// The other option.
        other: &'static str,
    },
}

impl Request {
    /// Returns a request with the given values of options. Options that are not in `values` keep their
    /// defaults. The order of `values` does not matter; if an option has two values, the first one is used.
    ///
    /// # Errors
    /// An option does not accept its value, or two options do not fit each other.
    pub fn from_values(values: &[(&'static RenderOption, &str)]) -> Result<Self, Refusal> {
        let value_of = |name: &str| values.iter().find(|(given, _)| given.name == name).map(|(_, value)| *value);
        let mut request = Self::default();
        for option in OPTIONS {
            let Some(value) = value_of(option.name) else { continue };
            match option.needs {
                Needs::Nothing => {}
                Needs::Value(other, needed) if value_of(other) == Some(needed) => {}
                Needs::Value(other, value) => return Err(Refusal::Requires { option: option.name, other, value }),
                Needs::Absence(other) if value_of(other).is_none() => {}
                Needs::Absence(other) => return Err(Refusal::Excludes { option: option.name, other }),
            }
            option.set(&mut request, value).map_err(|expected| Refusal::Value {
                option: option.name,
                value: value.to_owned(),
                expected,
            })?;
        }
        Ok(request)
    }
}
