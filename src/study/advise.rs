//! Finds the settings to use for a time or an error, and predicts their error and time.
//!
//! A probe renders a few iterations at three radii and with fewer eye paths. A model is fitted to the probe
//! ([`Model`]). The model has three parts of the error (noise of eye paths, noise of photons, blur), their
//! dependence on the settings, and the time of an iteration. The settings with the best prediction are then
//! rendered for a few iterations, which correct the model for these settings.
//!
//! The predicted settings include the numbers of photons and eye paths that a render with `auto` would choose.
//!
//! A probe has a limited time. Kernels are compiled once, for the trial of `auto`. The rest of the time is divided
//! between the renders: one share for each of the four of the model, and three for the one that corrects it. If a share
//! is too short for a few iterations of the full image, the renders have fewer pixels, each as wide as one of the full
//! image, and fewer photons in proportion. Their noise and their time are then scaled to those of the full image.

mod goal;
mod model;
mod probe;

use std::sync::Arc;

use goblet_host::Device;

pub use goal::{Goal, Length};
pub use model::{Choice, Expected, Model, Parts};
use probe::Probe;

use crate::render::activity::Observer;
use crate::render::counts;
use crate::render::error::RenderError;
use crate::render::options::Options;
use crate::scene::Scene;

/// Settings with a prediction of their error and time.
#[derive(Clone, Debug)]
pub struct Advice {
    /// The settings.
    pub options: Options,
    /// Prediction of the model, corrected by a short render of these settings.
    pub expected: Expected,
    /// Prediction for the scene's own settings and the same goal, by the same model.
    pub by_default: Expected,
    /// The numbers of photons and eye paths that a render with `auto` takes, and why.
    pub auto: counts::Choice,
    /// Duration of the probe in seconds.
    pub probe_seconds: f64,
}

/// Settings with fewer iterations than this are not advised, unless the default settings have fewer, too.
const FEW: u32 = 8;
/// Settings whose render would take this many times longer than its time are not advised, unless the default settings do.
const LATE: f64 = 1.5;
/// The default settings are advised unless others reduce the error or the time by more than this share.
const WORTH_IT: f64 = 0.05;

/// Probes a scene, and returns the options of a choice of settings and a prediction for that number of
/// iterations. `base` has the options that stay as they are, such as the resolution.
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
    let mut probe = Probe::new(device, scene, base, length, Observer::default());
    let model = probe.model()?;
    let corrected = probe.correct(&model, choice)?;
    Ok((probe.options(choice), corrected.after(choice, iterations)))
}

/// Probes a scene, and returns the best settings for a goal. `base` has the options that stay as they are,
/// such as the resolution. `observer` is told what is done.
///
/// # Errors
/// The scene or the device is at fault.
pub fn advise(
    device: &Arc<Device>,
    scene: &Scene,
    base: &Options,
    goal: Goal,
    length: Length,
    observer: Observer,
) -> Result<Advice, RenderError> {
    let mut probe = Probe::new(device, scene, base, length, observer);
    let auto = probe.auto()?;
    let model = probe.model()?;
    let by_default = model.expect(Choice::DEFAULT, goal);
    // With few iterations the error is not predictable: one more or less changes it too much.
    let enough = FEW.min(by_default.iterations);
    let of_auto = [0.5, 1.0, 2.0].map(|radius| Choice {
        eye_paths: auto.taken.eye_paths,
        radius,
        photons: auto.taken.photons as f64 / auto.usual.photons as f64,
    });
    // A render ends after an iteration: one of many photons may end long after the time.
    let latest = match goal {
        Goal::Time(seconds) => (LATE * seconds).max(by_default.seconds),
        Goal::Error(_) => f64::INFINITY,
    };
    let choices = Choice::all().chain(of_auto).map(|choice| (choice, model.expect(choice, goal)));
    let best = choices.filter(|(_, expected)| expected.iterations >= enough && expected.seconds <= latest);
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
        auto,
        probe_seconds: probe.seconds(),
    })
}
