//! What a user asks of a render: options and limits, from values as people write them.

use std::time::Duration;

use super::Options;
use super::table::{Needs, OPTIONS, RenderOption};

/// When a render ends: at the first limit that it reaches.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Limits {
    /// Iterations.
    pub iterations: Option<u32>,
    /// Rounds of the integrator `ppm`. Not together with `iterations`.
    pub rounds: Option<u32>,
    /// Time of iterations; a render ends after the iteration that reaches it.
    pub time: Option<Duration>,
    /// Estimated relative error of the image, as in [`crate::Renderer::relative_error`].
    pub target_error: Option<f64>,
}

/// How to render, and for how long.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Request {
    /// How.
    pub options: Options,
    /// For how long.
    pub limits: Limits,
}

/// Why values make no request.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Refusal {
    /// A value is not one of its option.
    #[error("invalid value '{value}' for --{option}: {expected}")]
    Value {
        /// The name of the option.
        option: &'static str,
        /// The value.
        value: String,
        /// What was expected.
        expected: String,
    },
    /// An option has no meaning without a value of another.
    #[error("--{option} requires --{other} {value}")]
    Requires {
        /// The name of the option.
        option: &'static str,
        /// The other option.
        other: &'static str,
        /// The value that the other must have.
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
    /// The request that gives each option its value in `values`, where it has one. The order of
    /// `values` does not matter; of two values of an option the first counts.
    ///
    /// # Errors
    /// A value is not one of its option, or two options do not fit each other.
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
