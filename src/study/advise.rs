//! Which settings to use for a time or an error, and what to expect of them.
//!
//! A probe renders a few iterations at three radii and with fewer eye paths. From that a
//! model of the error is fitted ([`Model`]): what part is noise of eye paths, noise of photons
//! and blur, how each depends on the settings, and what an iteration takes. The settings that
//! the model likes best are then rendered for a moment, to correct what it says of them.

mod model;
mod probe;

use std::sync::Arc;
use std::time::Duration;

use goblet_host::Device;
use serde::Serialize;

pub use model::{Choice, Model, Parts};
use probe::Probe;

use crate::render::options::Options;
use crate::render::renderer::RenderError;
use crate::scene::Scene;

/// What a user wants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Goal {
    /// The least error after so many seconds of iterations.
    Time(f64),
    /// A relative error, as soon as possible.
    Error(f64),
}

/// How long a probe is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Length {
    /// About so long in all.
    Time(Duration),
    /// Iterations of each of its renders, an even number from 2. What is expected of settings does
    /// not depend on how fast the device is, then.
    Iterations(u32),
}

/// What to expect of settings.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Expected {
    /// To be rendered.
    pub iterations: u32,
    /// Seconds of iterations.
    pub seconds: f64,
    /// The root mean square over pixels of the error over the luminance, of noise and blur;
    /// dark pixels count as in [`crate::image::estimate::Estimate::relative_error`], and the 0.1 % worst
    /// are left out, as in [`crate::image::compare::Gates`].
    pub error: f64,
    /// Shares of the squared error.
    pub parts: Parts,
}

/// Settings, and what to expect of them.
#[derive(Clone, Debug)]
pub struct Advice {
    /// How to render.
    pub options: Options,
    /// By the model, corrected by a moment's render of these settings.
    pub expected: Expected,
    /// What the scene's own settings would do for the same goal, by the same model.
    pub by_default: Expected,
    /// Seconds that the probe has taken.
    pub probe_seconds: f64,
}

/// Settings with fewer iterations than this are left to scenes where that cannot be helped.
const FEW: u32 = 8;
/// A gain of error or time below this is no reason to leave the defaults.
const WORTH_IT: f64 = 0.05;

/// Probes, and says what to expect of settings after some iterations, and their options. `base` has
/// what is not to be changed, such as the resolution.
///
/// # Errors
/// The scene or the device is at fault.
pub fn expect(
    device: &Arc<Device>,
    scene: &Scene,
    base: &Options,
    choice: Choice,
    iterations: u32,
    length: Length,
) -> Result<(Options, Expected), RenderError> {
    let mut probe = Probe::new(device, scene, base, length);
    let model = probe.model()?;
    let corrected = probe.correct(&model, choice)?;
    Ok((probe.options(choice), corrected.after(choice, iterations)))
}

/// Probes, and advises. `base` has what is not to be changed, such as the
/// resolution.
///
/// # Errors
/// The scene or the device is at fault.
pub fn advise(
    device: &Arc<Device>,
    scene: &Scene,
    base: &Options,
    goal: Goal,
    length: Length,
) -> Result<Advice, RenderError> {
    let mut probe = Probe::new(device, scene, base, length);
    let model = probe.model()?;
    let by_default = model.expect(Choice::DEFAULT, goal);
    // A few long iterations are a matter of luck: one more or less is half of the error.
    let enough = FEW.min(by_default.iterations);
    let choices = Choice::all().map(|choice| (choice, model.expect(choice, goal)));
    let best = choices.filter(|(_, expected)| expected.iterations >= enough);
    let better = |a: &(Choice, Expected), b: &(Choice, Expected)| match goal {
        Goal::Time(_) => a.1.error.total_cmp(&b.1.error),
        Goal::Error(_) => a.1.seconds.total_cmp(&b.1.seconds),
    };
    let (choice, expected) = best.min_by(better).unwrap_or((Choice::DEFAULT, by_default));
    let gain = match goal {
        Goal::Time(_) => 1.0 - expected.error / by_default.error,
        Goal::Error(_) => 1.0 - expected.seconds / by_default.seconds,
    };
    let choice = if gain > WORTH_IT { choice } else { Choice::DEFAULT };
    let corrected = probe.correct(&model, choice)?;
    Ok(Advice {
        options: probe.options(choice),
        expected: corrected.expect(choice, goal),
        by_default: corrected.expect(Choice::DEFAULT, goal),
        probe_seconds: probe.seconds(),
    })
}
