//! `Material` and `MakeNamedMaterial`.

use super::error::{Location, SceneError};
use super::model::{Input, Material, Rgb};
use super::params::ParamList;
use super::registry::{Family, Kind, ParamSpec, full, ignored, later, not_yet, supported};
use super::spectrum::{Spectrum, conductor, conductor_from_reflectance, copper, optional};
use super::texture::Textures;

const COLOUR: &[Kind] = &[Kind::Rgb, Kind::Spectrum];
const TEXTURED_COLOUR: &[Kind] = &[Kind::Rgb, Kind::Spectrum, Kind::Texture];
const NUMBER: &[Kind] = &[Kind::Float];

const DISPLACEMENT: ParamSpec = later("displacement", &[Kind::Float, Kind::Texture]);
const NORMAL_MAP: ParamSpec = later("normalmap", &[Kind::String]);
const ROUGHNESS: ParamSpec = full("roughness", NUMBER);
const U_ROUGHNESS: ParamSpec = full("uroughness", NUMBER);
const V_ROUGHNESS: ParamSpec = full("vroughness", NUMBER);
/// How roughness is measured is of no matter while there is none.
const REMAP_ROUGHNESS: ParamSpec = ignored("remaproughness", &[Kind::Bool]);

/// The materials of pbrt.
pub(super) const FAMILY: Family = Family {
    directive: "Material",
    types: &[
        supported("diffuse", &[full("reflectance", TEXTURED_COLOUR), DISPLACEMENT, NORMAL_MAP]),
        supported(
            "conductor",
            &[
                full("eta", COLOUR),
                full("k", COLOUR),
                full("reflectance", COLOUR),
                ROUGHNESS,
                U_ROUGHNESS,
                V_ROUGHNESS,
                REMAP_ROUGHNESS,
                DISPLACEMENT,
                NORMAL_MAP,
            ],
        ),
        supported(
            "dielectric",
            &[
                full("eta", &[Kind::Float, Kind::Spectrum]),
                // Goblet's own: pbrt's dielectrics are untinted.
                full("transmittance", &[Kind::Rgb]),
                ROUGHNESS,
                U_ROUGHNESS,
                V_ROUGHNESS,
                REMAP_ROUGHNESS,
                DISPLACEMENT,
                NORMAL_MAP,
            ],
        ),
        not_yet("coateddiffuse"),
        not_yet("coatedconductor"),
        not_yet("diffusetransmission"),
        not_yet("hair"),
        not_yet("interface"),
        not_yet("measured"),
        not_yet("mix"),
        not_yet("subsurface"),
        not_yet("thindielectric"),
    ],
};

/// What surfaces are made of where no `Material` is in force.
pub(super) fn default() -> Material {
    Material::Diffuse { reflectance: Input::Constant(Rgb::splat(0.5)) }
}

/// Makes a material from parameters that [`FAMILY`] has checked.
pub(super) fn material(
    name: &str,
    params: &ParamList,
    location: &Location,
    textures: &Textures,
) -> Result<Material, SceneError> {
    match name {
        "conductor" => {
            require_smooth(params)?;
            smooth_conductor(params, location)
        }
        "dielectric" => {
            require_smooth(params)?;
            smooth_dielectric(params)
        }
        _ => match params.get("reflectance") {
            Some(param) => Ok(Material::Diffuse { reflectance: textures.color(param)? }),
            None => Ok(default()),
        },
    }
}

fn reflectance(params: &ParamList) -> Result<Option<Rgb>, SceneError> {
    fraction(params, "reflectance")
}

/// A colour with channels from 0 to 1.
fn fraction(params: &ParamList, name: &str) -> Result<Option<Rgb>, SceneError> {
    let Some(param) = params.get(name) else {
        return Ok(None);
    };
    let rgb = Spectrum::from_param(param)?.reflectance();
    if rgb.min_element() < 0.0 || rgb.max_element() > 1.0 {
        return Err(param.bad_value("channels from 0 to 1"));
    }
    Ok(Some(rgb))
}

fn require_smooth(params: &ParamList) -> Result<(), SceneError> {
    for name in ["roughness", "uroughness", "vroughness"] {
        let value = params.not_negative(name, 0.0)?;
        if let Some(param) = params.get(name).filter(|_| value != 0.0) {
            let what = format!("{param} {value}");
            return Err(param.location.unsupported(&what, "a roughness of 0"));
        }
    }
    Ok(())
}

fn smooth_conductor(params: &ParamList, location: &Location) -> Result<Material, SceneError> {
    let constant = params.get("eta").or(params.get("k"));
    if let (Some(constant), Some(_)) = (constant, params.get("reflectance")) {
        return Err(constant
            .location
            .invalid(format!("{constant} is given beside a reflectance; expected either reflectance, or eta and k")));
    }
    let (eta, k) = if let Some(reflectance) = reflectance(params)? {
        conductor_from_reflectance(reflectance)
    } else {
        let (copper_eta, copper_k) = copper(location)?;
        for param in ["eta", "k"].into_iter().filter_map(|n| params.get(n)) {
            if param.numbers().iter().any(|v| *v < 0.0) {
                return Err(param.bad_value("no negative value"));
            }
        }
        conductor(&optional(params.get("eta"))?.unwrap_or(copper_eta), &optional(params.get("k"))?.unwrap_or(copper_k))
    };
    Ok(Material::Conductor { eta, k })
}

fn smooth_dielectric(params: &ParamList) -> Result<Material, SceneError> {
    let eta = match params.get("eta") {
        Some(param) if param.kind == Kind::Spectrum => Spectrum::from_param(param)?.photopic_mean(),
        _ => params.float("eta")?.unwrap_or(1.5),
    };
    if let Some(param) = params.get("eta").filter(|_| !(0.1..=10.0).contains(&eta)) {
        return Err(param.bad_value("an index of refraction from 0.1 to 10"));
    }
    Ok(Material::Dielectric { eta, transmittance: fraction(params, "transmittance")?.unwrap_or(Rgb::ONE) })
}
