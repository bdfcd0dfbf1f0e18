//! Settings: values of options of a render, from text such as `photons=1e5,1e6`.

use std::collections::BTreeMap;

use crate::render::options::request::Request;
use crate::render::options::table::{OPTIONS, RenderOption};
use crate::render::options::written::Refusal;

/// Names of the options that can be varied, as in `photons, eye-paths`.
pub fn knobs() -> String {
    let names: Vec<&str> = OPTIONS.iter().filter(|option| option.is_knob).map(|option| option.name).collect();
    names.join(", ")
}

/// The largest number of settings of one measurement.
const MAX_SETTINGS: usize = 256;

/// A knob and its values, as they are written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Vary {
    /// The name of an option that [`knobs`] lists.
    pub knob: &'static str,
    /// The texts of the values, at least one.
    pub values: Vec<String>,
}

/// The reason why knobs are refused.
#[derive(Debug, thiserror::Error)]
pub enum KnobError {
    /// There is no such knob, or it has no values.
    #[error("{given}: expected KNOB=VALUE,VALUE and so on, the knob one of {}", knobs())]
    Form {
        /// The text that was given.
        given: String,
    },
    /// A value is not accepted by its knob, or two values contradict each other.
    #[error("{setting}: {reason}")]
    Value {
        /// The values.
        setting: String,
        /// The reason.
        reason: Refusal,
    },
    /// A knob is given twice.
    #[error("{knob} is varied twice: expected all values in one list")]
    Twice {
        /// The knob.
        knob: &'static str,
    },
    /// All combinations are too many.
    #[error("{0} settings: expected at most {MAX_SETTINGS}")]
    TooMany(usize),
}

impl std::str::FromStr for Vary {
    type Err = KnobError;

    fn from_str(text: &str) -> Result<Self, KnobError> {
        let form = || KnobError::Form { given: text.to_owned() };
        let (name, values) = text.split_once('=').ok_or_else(form)?;
        let knob = OPTIONS.iter().find(|option| option.is_knob && option.name == name).ok_or_else(form)?.name;
        let values: Vec<String> = values.split(',').map(|value| value.trim().to_owned()).collect();
        if values.iter().any(String::is_empty) {
            return Err(form());
        }
        Ok(Self { knob, values })
    }
}

/// A combination of option values with which the scene is rendered.
#[derive(Clone, Debug)]
pub struct Setting {
    /// The knobs and the texts of their values.
    pub knobs: BTreeMap<&'static str, String>,
    /// The options and the limits of the render.
    pub request: Request,
}

impl Setting {
    /// Returns the knobs in the order of their names, as in `photons=1e5 radius=2px`; `default` if there are none.
    pub fn label(&self) -> String {
        if self.knobs.is_empty() {
            return "default".to_owned();
        }
        self.knobs.iter().map(|(knob, value)| format!("{knob}={value}")).collect::<Vec<_>>().join(" ")
    }

    /// Returns the options of `goblet render` as text.
    pub fn options_text(&self) -> String {
        self.knobs.iter().map(|(knob, value)| format!(" --{knob} {value}")).collect()
    }

    fn new(knobs: BTreeMap<&'static str, String>) -> Result<Self, KnobError> {
        let given = |option: &'static RenderOption| Some((option, knobs.get(option.name)?.as_str()));
        let values: Vec<_> = OPTIONS.iter().filter_map(given).collect();
        match Request::from_values(&values) {
            Ok(request) => Ok(Self { knobs, request }),
            Err(reason) => {
                let setting: Vec<String> = knobs.iter().map(|(knob, value)| format!("{knob}={value}")).collect();
                Err(KnobError::Value { setting: setting.join(" "), reason })
            }
        }
    }
}

/// Returns all combinations; the last knob changes fastest. With `each`: the default, and every value alone. In
/// both cases, every setting has the value of each knob with a single value.
///
/// # Errors
/// A value that `goblet render` would refuse, a knob that is there twice, or too many.
pub fn settings(vary: &[Vary], each: bool) -> Result<Vec<Setting>, KnobError> {
    let mut seen = BTreeMap::new();
    for Vary { knob, .. } in vary {
        if seen.insert(*knob, ()).is_some() {
            return Err(KnobError::Twice { knob });
        }
    }
    let combine = |count: usize, vary: &Vary| {
        let values = vary.values.len();
        if each { count.saturating_add(values) } else { count.saturating_mul(values) }
    };
    let count = vary.iter().fold(1, combine);
    if count > MAX_SETTINGS {
        return Err(KnobError::TooMany(count));
    }
    let shared = |vary: &&Vary| vary.values.len() == 1;
    let base: BTreeMap<_, _> = vary.iter().filter(shared).map(|vary| (vary.knob, vary.values[0].clone())).collect();
    if each {
        let alone = |vary: &Vary, value: &String| {
            base.clone().into_iter().chain([(vary.knob, value.clone())]).collect::<BTreeMap<_, _>>()
        };
        let varied = vary.iter().filter(|vary| !shared(vary));
        let values = varied.flat_map(|vary| vary.values.iter().map(move |value| alone(vary, value)));
        return std::iter::once(base.clone()).chain(values).map(Setting::new).collect();
    }
    let mut combinations = vec![BTreeMap::new()];
    for Vary { knob, values } in vary {
        let with = |before: &BTreeMap<&'static str, String>, value: &String| {
            before.iter().map(|(k, v)| (*k, v.clone())).chain([(*knob, value.clone())]).collect()
        };
        combinations =
            combinations.iter().flat_map(|before| values.iter().map(move |value| with(before, value))).collect();
    }
    combinations.into_iter().map(Setting::new).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(vary: &[&str]) -> Result<Vec<String>, KnobError> {
        let vary = vary.iter().map(|text| text.parse()).collect::<Result<Vec<Vary>, _>>()?;
        Ok(settings(&vary, false)?.iter().map(Setting::label).collect())
    }

    #[test]
    fn settings_are_all_combinations() {
        assert_eq!(of(&[]).unwrap(), ["default"]);
        assert_eq!(
            of(&["radius=2px,0.1", "photons=1e5,3"]).unwrap(),
            ["photons=1e5 radius=2px", "photons=3 radius=2px", "photons=1e5 radius=0.1", "photons=3 radius=0.1"]
        );
        let setting = &settings(&["alpha=0.5".parse().unwrap()], false).unwrap()[0];
        assert_eq!(setting.request.options.alpha, Some(0.5));
    }

    #[test]
    fn each_value_can_stand_alone() {
        let vary = ["radius=2px,0.1", "photons=3", "alpha=0.5,1"].map(|text| text.parse().unwrap());
        let labels: Vec<String> = settings(&vary, true).unwrap().iter().map(Setting::label).collect();
        assert_eq!(
            labels,
            ["photons=3", "photons=3 radius=2px", "photons=3 radius=0.1", "alpha=0.5 photons=3", "alpha=1 photons=3"]
        );
    }

    #[test]
    fn what_render_refuses_is_refused() {
        for (vary, words) in [
            (vec!["photons"], "KNOB=VALUE"),
            (vec!["photons="], "KNOB=VALUE"),
            (vec!["photons=1,,2"], "KNOB=VALUE"),
            (vec!["output=a.exr"], "one of iterations, photons"),
            (vec!["seed=1"], "one of iterations, photons"),
            (vec!["photons=1", "photons=2"], "twice"),
            (vec!["alpha=2"], "alpha=2: invalid value '2'"),
            (vec!["newton-segments=8"], "requires --revolution-solver newton"),
        ] {
            let error = of(&vary).unwrap_err().to_string();
            assert!(error.contains(words), "{vary:?}: {error}");
        }
        let many = format!("photons={}", vec!["1"; 257].join(","));
        assert!(of(&[&many]).unwrap_err().to_string().contains("257 settings"));
    }
}
