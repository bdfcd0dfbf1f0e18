//! The request of a user: options and limits of a render, read from the text of their values.

use std::time::Duration;

use super::Options;
use super::table::{Needs, OPTIONS, RenderOption};

/// The limits of a render. It ends at the first limit that it reaches.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Limits {
    /// Number of iterations.
    pub iterations: Option<u32>,
    /// Number of rounds of the integrator `ppm`. It cannot be combined with `iterations`.
    pub rounds: Option<u32>,
    /// Total time of the iterations. A render ends after the iteration that reaches it.
    pub time: Option<Duration>,
    /// Estimated relative error of the image, as defined by [`crate::Renderer::relative_error`].
    pub target_error: Option<f64>,
}

/// The options of a render and its limits.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Request {
    /// The options.
    pub options: Options,
    /// The limits.
    pub limits: Limits,
}

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
