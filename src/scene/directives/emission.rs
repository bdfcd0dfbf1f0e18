//! Parameters that several kinds of lights have.

use crate::scene::format::error::SceneError;
use crate::scene::format::params::ParamList;
use crate::scene::model::{ByWavelength, Rgb};
use crate::scene::spectrum::{Spectrum, optional};

/// Returns the light's colour, `scale` included. `name` is the colour's parameter; white is the default.
pub(in crate::scene) fn emitted(params: &ParamList, name: &str) -> Result<Rgb, SceneError> {
    let rgb = optional(params.get(name))?.map_or(Rgb::ONE, |s: Spectrum| s.light());
    if let Some(param) = params.get(name).filter(|_| rgb.min_element() < 0.0) {
        return Err(param.bad_value("channels of 0 or more"));
    }
    let emitted = rgb * params.not_negative("scale", 1.0)?;
    match params.get(name).or(params.get("scale")) {
        Some(param) if !emitted.is_finite() => Err(param.bad_value("a smaller value")),
        _ => Ok(emitted),
    }
}

/// Returns the light's curve over that of daylight, in any unit; `None` if it has the curve of daylight or is known as RGB.
pub(in crate::scene) fn by_wavelength(params: &ParamList, name: &str) -> Result<Option<ByWavelength>, SceneError> {
    Ok(optional(params.get(name))?.and_then(|spectrum| spectrum.over_daylight()))
}

/// Returns a parameter's value if it is above 0. As in pbrt, a value of 0 or less counts as absent.
pub(in crate::scene) fn positive(params: &ParamList, name: &str) -> Result<Option<f64>, SceneError> {
    Ok(params.float(name)?.filter(|value| *value > 0.0))
}
