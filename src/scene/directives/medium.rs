//! The `MakeNamedMedium` directive.

mod presets;

use crate::scene::format::error::{Location, SceneError};
use crate::scene::format::kind::Kind;
use crate::scene::format::lexer::shorten;
use crate::scene::format::params::{Param, ParamList};
use crate::scene::format::registry::{Family, full, ignored, not_yet, supported};
use crate::scene::model::{Medium, Rgb};
use crate::scene::spectrum::{Spectrum, optional};
use presets::preset_absorption;

const COLOUR: &[Kind] = &[Kind::Rgb, Kind::Spectrum, Kind::Blackbody];
const FLOAT: &[Kind] = &[Kind::Float];

/// The media of pbrt.
pub(in crate::scene) const FAMILY: Family = Family {
    directive: "MakeNamedMedium",
    types: &[
        supported(
            "homogeneous",
            &[
                full("sigma_a", COLOUR),
                full("sigma_s", COLOUR),
                full("scale", FLOAT),
                full("preset", &[Kind::String]),
                full("Le", COLOUR),
                full("Lescale", FLOAT),
                // The phase function of a medium that does not scatter.
                ignored("g", FLOAT),
            ],
        ),
        not_yet("cloud"),
        not_yet("nanovdb"),
        not_yet("rgbgrid"),
        not_yet("uniformgrid"),
    ],
};

/// pbrt's default absorption coefficient: whole milk's, in 1/mm.
const DEFAULT_ABSORPTION: Rgb = Rgb::new(0.0011, 0.0024, 0.014);

/// Returns a medium from parameters that [`FAMILY`] has checked, `None` if it is like a vacuum, and a warning.
pub(in crate::scene) fn medium(
    name: &str,
    params: &ParamList,
    location: &Location,
) -> Result<(Option<Medium>, Option<String>), SceneError> {
    let preset = params.string("preset")?.filter(|preset| !preset.is_empty());
    let of_preset = preset.and_then(preset_absorption);
    let warning = preset.filter(|_| of_preset.is_none()).map(|preset| {
        format!("there is no \"string preset\" {:?}; as in pbrt, the other parameters count", shorten(preset))
    });
    let scale = params.not_negative("scale", 1.0)?;
    let absorption = scale * coefficient(params.get("sigma_a"))?.unwrap_or(DEFAULT_ABSORPTION);
    if let Some(param) = params.get("sigma_a").or(params.get("scale")).filter(|_| !absorption.is_finite()) {
        return Err(param.bad_value("a smaller value"));
    }
    let scattering = coefficient(params.get("sigma_s"))?;
    if scale > 0.0 {
        if let (Some(param), Some(Rgb { x, y, z })) = (params.get("preset"), of_preset) {
            let instead = format!("absorption alone, with \"rgb sigma_a\" [ {x} {y} {z} ] \"rgb sigma_s\" [ 0 0 0 ]");
            let what = format!("{param} stands for a medium that scatters: scattering");
            return Err(param.location.unsupported(&what, &instead));
        }
        let instead = "absorption alone, with \"rgb sigma_s\" [ 0 0 0 ]";
        match (params.get("sigma_s"), scattering) {
            (_, Some(Rgb::ZERO)) => {}
            (Some(param), _) => {
                return Err(param.location.unsupported(&format!("{param} above 0: scattering"), instead));
            }
            (None, _) => {
                let what = format!("MakeNamedMedium \"{}\" without sigma_s scatters: scattering", shorten(name));
                return Err(location.unsupported(&what, instead));
            }
        }
    }
    check_emission(params)?;
    let curve = optional(params.get("sigma_a"))?.and_then(|spectrum| spectrum.coefficients());
    let by_wavelength = curve.map(|curve| curve.scaled(scale));
    Ok((Some(Medium { absorption, by_wavelength }).filter(|_| absorption != Rgb::ZERO), warning))
}

/// Returns a coefficient per channel; `None` if the parameter is absent.
fn coefficient(param: Option<&Param>) -> Result<Option<Rgb>, SceneError> {
    let value = optional(param)?.map(|spectrum| spectrum.coefficient());
    match (param, value) {
        (Some(param), Some(value)) if value.min_element() < 0.0 => Err(param.bad_value("channels of 0 or more")),
        _ => Ok(value),
    }
}

/// Fails if the medium emits light.
fn check_emission(params: &ParamList) -> Result<(), SceneError> {
    let emission = optional(params.get("Le"))?.map_or(Rgb::ZERO, |spectrum: Spectrum| spectrum.light());
    let scale = params.not_negative("Lescale", 1.0)?;
    match params.get("Le") {
        Some(param) if emission.min_element() < 0.0 => Err(param.bad_value("channels of 0 or more")),
        Some(param) if emission * scale != Rgb::ZERO => {
            let what = format!("{param} above 0: emission of a medium");
            Err(param.location.unsupported(&what, "media that emit nothing, and surfaces with an AreaLightSource"))
        }
        _ => Ok(()),
    }
}
