//! Options that differ between two renders, in words, with the options to give.

use std::fmt;

use crate::image::layers::Group;
use crate::render::aov::AOVS;
use crate::render::options::request::Request;
use crate::render::options::table::{Effect, OPTIONS};
use crate::scene::shorten;

/// The names of values of an identity that need words of their own.
pub(in crate::render) const RESOLUTION: &str = "resolution";
pub(in crate::render) const PHOTONS: &str = "photons per iteration";
pub(in crate::render) const EYE_PATHS: &str = "eye paths per iteration";
pub(in crate::render) const INTEGRATOR: &str = "integrator";
pub(in crate::render) const ROUND: &str = "iterations per round";
pub(in crate::render) const LAYERS: &str = "layers";
const SOLVER: &str = "revolution solver";

/// A value that differs between two renders.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// The name of the value.
    pub name: String,
    /// The value of this render, or of the files before; `None` if it has none.
    pub here: Option<String>,
    /// The value of the checkpoint; `None` if it has none.
    pub there: Option<String>,
    /// The options that give the value of the checkpoint, such as `--alpha 0.5`; empty if it is not one of options.
    pub options: String,
}

/// What a checkpoint does not belong to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum To {
    /// The render that is to continue it.
    Render,
    /// The checkpoints with which it is to be merged.
    Others,
}

/// The options in which a checkpoint differs from what it is to belong to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Differences {
    /// What it is to belong to.
    pub to: To,
    /// The differences, at least one.
    pub all: Vec<Difference>,
}

impl fmt::Display for Differences {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, difference) in self.all.iter().enumerate() {
            f.write_str(if i == 0 { "" } else { "; " })?;
            difference.write(self.to, f)?;
        }
        let known: Vec<&str> =
            self.all.iter().map(|it| it.options.as_str()).filter(|options| !options.is_empty()).collect();
        let others = self.all.iter().any(|it| it.options.is_empty());
        match (self.to, known.is_empty()) {
            (To::Render, false) => write!(f, "; expected {}", known.join(" "))?,
            (To::Others, _) => f.write_str("; expected shards of one render, with the same scene and options")?,
            (To::Render, true) => {}
        }
        if self.to == To::Render && others {
            f.write_str(if known.is_empty() { "; expected " } else { ", and " })?;
            f.write_str("the scene file as it was")?;
        }
        Ok(())
    }
}

impl Difference {
    fn write(&self, to: To, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Names and values from a file may be of any length.
        let text = |value: &Option<String>| value.as_deref().map_or_else(|| "none".to_owned(), shorten);
        let (here, there, name) = (text(&self.here), text(&self.there), shorten(&self.name));
        let is_size = self.name == RESOLUTION;
        match to {
            To::Render if is_size => write!(f, "the checkpoint is {there}; this render is {here}"),
            To::Others if is_size => write!(f, "its image is {there}; that of the files before it is {here}"),
            To::Render => write!(f, "{name}: the checkpoint was made with {there}, and this render has {here}"),
            To::Others => write!(f, "{name}: it was made with {there}, and the files before it with {here}"),
        }
    }
}

/// Returns the options that give a value of an identity, which is `None` if it has none; empty if no option does.
/// `photons` is the number of photons of an iteration.
pub(in crate::render) fn options_for(name: &str, value: Option<&str>, photons: Option<&str>) -> String {
    let Some(value) = value else {
        return if name == LAYERS { "no --aov".to_owned() } else { String::new() };
    };
    let option = OPTIONS.iter().find(|option| matches!(option.effect, Effect::Image(other, _) if other == name));
    let value = match name {
        LAYERS => return options_for_layers(value),
        SOLVER if value.starts_with("newton") => return options_for_newton(value),
        ROUND => {
            let product = value.parse::<u64>().ok().zip(photons.and_then(|photons| photons.parse().ok()));
            product.map(|(length, photons): (u64, u64)| length.saturating_mul(photons).to_string())
        }
        _ => Some(value.to_owned()),
    };
    // A value from a file may be anything.
    let accepted = option.zip(value).filter(|(option, value)| option.set(&mut Request::default(), value).is_ok());
    accepted.map(|(option, value)| format!("--{} {value}", option.name)).unwrap_or_default()
}

/// The same for `newton, Both, 16 segments`.
fn options_for_newton(value: &str) -> String {
    let words: Vec<&str> = value.split([',', ' ']).filter(|word| !word.is_empty()).collect();
    let [solver, envelopes, segments, _] = words[..] else { return String::new() };
    let envelopes = envelopes.to_lowercase();
    format!("--revolution-solver {solver} --newton-envelopes {envelopes} --newton-segments {segments}")
}

/// The same for the names of groups of layers.
fn options_for_layers(value: &str) -> String {
    let mut names: Vec<&str> = Vec::new();
    for group in value.split(", ").filter_map(|name| Group::ALL.into_iter().find(|group| group.name() == name)) {
        let has_it = |name: &&str| AOVS.iter().any(|aov| aov.name == *name && aov.groups.has(group));
        if !names.iter().any(has_it) {
            names.extend(AOVS.iter().find(|aov| aov.groups.has(group)).map(|aov| aov.name));
        }
    }
    names.iter().map(|name| format!("--aov {name}")).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_value_has_the_options_that_give_it() {
        for (name, value, expected) in [
            (RESOLUTION, "320x240", "--resolution 320x240"),
            ("alpha", "0.6666666666666666", "--alpha 0.6666666666666666"),
            ("radius", "3px", "--radius 3px"),
            ("radius", "0.5", "--radius 0.5"),
            (PHOTONS, "500", "--photons 500"),
            (EYE_PATHS, "8", "--eye-paths 8"),
            (INTEGRATOR, "ppm", "--integrator ppm"),
            (ROUND, "16", "--photons-per-round 8000"),
            (SOLVER, "certified", "--revolution-solver certified"),
            (
                SOLVER,
                "newton, Both, 16 segments",
                "--revolution-solver newton --newton-envelopes both --newton-segments 16",
            ),
            (SOLVER, "newton", ""),
            ("direct light", "nee", "--direct nee"),
            ("guide", "off", "--guide off"),
            ("seed", "-1", ""),
            ("alpha", "\u{1b}[2J", ""),
            ("white balance", "5000 K", ""),
            ("unheard of", "1", ""),
        ] {
            assert_eq!(options_for(name, Some(value), Some("500")), expected, "{name} {value}");
        }
        assert_eq!(options_for(ROUND, Some("16"), None), "");
        assert_eq!(options_for(LAYERS, Some("N, unheard of"), None), "--aov N");
        assert_eq!(options_for(LAYERS, None, None), "no --aov");
        assert_eq!(options_for("white balance", None, None), "");
    }

    #[test]
    fn every_option_of_an_identity_is_found_by_its_name() {
        let of_image = OPTIONS.iter().filter_map(|option| match option.effect {
            Effect::Image(name, _) => Some(name),
            Effect::PartOf | Effect::End | Effect::Cost => None,
        });
        let names: Vec<&str> = of_image.collect();
        for name in [RESOLUTION, PHOTONS, EYE_PATHS, INTEGRATOR, ROUND, SOLVER] {
            assert!(names.contains(&name), "{name}: {names:?}");
        }
    }
}
