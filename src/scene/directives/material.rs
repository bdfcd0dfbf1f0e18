//! The `Material` and `MakeNamedMaterial` directives.

use std::ops::RangeInclusive;

use crate::scene::directives::bump::{DISPLACEMENT, NORMAL_MAP, bumped};
use crate::scene::directives::texture::Textures;
use crate::scene::format::error::{Location, SceneError};
use crate::scene::format::kind::Kind;
use crate::scene::format::params::{Param, ParamList};
use crate::scene::format::registry::{Family, ParamSpec, full, ignored, not_yet, supported};
use crate::scene::model::{Coat, Index, Input, Material, Metal, Rgb, Roughness, Scattering};
use crate::scene::spectrum::{Spectrum, conductor, conductor_from_reflectance, copper, optional};

const FLOAT: &[Kind] = &[Kind::Float];
const COLOUR: &[Kind] = &[Kind::Rgb, Kind::Spectrum, Kind::Blackbody];
const TEXTURED: &[Kind] = &[Kind::Rgb, Kind::Spectrum, Kind::Blackbody, Kind::Texture];
const NUMBER: &[Kind] = &[Kind::Float, Kind::Texture];
const INDEX: &[Kind] = &[Kind::Float, Kind::Spectrum, Kind::Blackbody];

const ROUGHNESS: ParamSpec = full("roughness", NUMBER);
const U_ROUGHNESS: ParamSpec = full("uroughness", NUMBER);
const V_ROUGHNESS: ParamSpec = full("vroughness", NUMBER);
const REMAP_ROUGHNESS: ParamSpec = full("remaproughness", &[Kind::Bool]);
const REFLECTANCE: ParamSpec = full("reflectance", TEXTURED);
const ALBEDO: ParamSpec = full("albedo", TEXTURED);
const PHASE: ParamSpec = full("g", NUMBER);
/// Over a metal, the little light that a coat scatters goes straight on.
const PHASE_OVER_METAL: ParamSpec = ignored("g", NUMBER);
const THICKNESS: ParamSpec = full("thickness", NUMBER);
const LAYER_DEPTH: ParamSpec = ignored("maxdepth", &[Kind::Integer]);
const LAYER_SAMPLES: ParamSpec = ignored("nsamples", &[Kind::Integer]);

/// The materials of pbrt.
pub(in crate::scene) const FAMILY: Family = Family {
    directive: "Material",
    types: &[
        supported("diffuse", &[REFLECTANCE, DISPLACEMENT, NORMAL_MAP]),
        supported(
            "conductor",
            &[
                full("eta", COLOUR),
                full("k", COLOUR),
                REFLECTANCE,
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
                full("eta", INDEX),
                // An extension of the format: pbrt's dielectrics are untinted.
                full("transmittance", &[Kind::Rgb]),
                ROUGHNESS,
                U_ROUGHNESS,
                V_ROUGHNESS,
                REMAP_ROUGHNESS,
                DISPLACEMENT,
                NORMAL_MAP,
            ],
        ),
        supported("thindielectric", &[full("eta", INDEX), DISPLACEMENT, NORMAL_MAP]),
        supported(
            "diffusetransmission",
            &[REFLECTANCE, full("transmittance", TEXTURED), full("scale", FLOAT), DISPLACEMENT, NORMAL_MAP],
        ),
        supported(
            "coateddiffuse",
            &[
                REFLECTANCE,
                ROUGHNESS,
                U_ROUGHNESS,
                V_ROUGHNESS,
                REMAP_ROUGHNESS,
                full("eta", INDEX),
                THICKNESS,
                ALBEDO,
                PHASE,
                LAYER_DEPTH,
                LAYER_SAMPLES,
                DISPLACEMENT,
                NORMAL_MAP,
            ],
        ),
        supported(
            "coatedconductor",
            &[
                full("conductor.eta", COLOUR),
                full("conductor.k", COLOUR),
                REFLECTANCE,
                full("conductor.roughness", NUMBER),
                full("conductor.uroughness", NUMBER),
                full("conductor.vroughness", NUMBER),
                full("interface.roughness", NUMBER),
                full("interface.uroughness", NUMBER),
                full("interface.vroughness", NUMBER),
                full("interface.eta", INDEX),
                REMAP_ROUGHNESS,
                THICKNESS,
                ALBEDO,
                PHASE_OVER_METAL,
                LAYER_DEPTH,
                LAYER_SAMPLES,
                DISPLACEMENT,
                NORMAL_MAP,
            ],
        ),
        supported("mix", &[full("materials", &[Kind::String]), full("amount", NUMBER)]),
        supported("interface", &[]),
        supported("measured", &[full("filename", &[Kind::String]), DISPLACEMENT, NORMAL_MAP]),
        not_yet("hair"),
        not_yet("subsurface"),
    ],
};

/// Returns the material of surfaces for which no `Material` is in force.
pub(in crate::scene) fn default() -> Material {
    Material::Diffuse { reflectance: Input::Constant(Rgb::splat(0.5)) }
}

/// Returns a material, other than a mix, from parameters that [`FAMILY`] has checked, and warnings.
pub(in crate::scene) fn material(
    name: &str,
    params: &ParamList,
    textures: &mut Textures,
    location: &Location,
) -> Result<(Material, Vec<String>), SceneError> {
    let (material, warnings) = even_material(name, params, textures, location)?;
    Ok((bumped(material, params, textures)?, warnings))
}

/// Returns the material without its bumps.
fn even_material(
    name: &str,
    params: &ParamList,
    textures: &Textures,
    location: &Location,
) -> Result<(Material, Vec<String>), SceneError> {
    let mut warnings = Vec::new();
    let color = |name, default| match params.get(name) {
        Some(param) => textures.color(param),
        None => Ok(Input::Constant(Rgb::splat(default))),
    };
    let roughness = |prefix| roughness(params, prefix, textures);
    let material = match name {
        "conductor" => {
            let metal = metal(params, ["eta", "k"], 1.0, textures, location)?;
            Material::Conductor { metal, roughness: roughness("")? }
        }
        "dielectric" => dielectric(params, roughness("")?)?,
        "thindielectric" => Material::ThinDielectric { eta: index(params, "eta")? },
        "diffusetransmission" => Material::DiffuseTransmission {
            reflectance: color("reflectance", 0.25)?,
            transmittance: color("transmittance", 0.25)?,
            scale: params.not_negative("scale", 1.0)?,
        },
        "coateddiffuse" => Material::CoatedDiffuse {
            reflectance: color("reflectance", 0.5)?,
            coat: coat((params, location), ("eta", false), roughness("")?, textures, &mut warnings)?,
        },
        "coatedconductor" => {
            let coat =
                coat((params, location), ("interface.eta", true), roughness("interface.")?, textures, &mut warnings)?;
            let metal = metal(params, ["conductor.eta", "conductor.k"], coat.eta.mean, textures, location)?;
            Material::CoatedConductor { metal, roughness: roughness("conductor.")?, coat }
        }
        "measured" => measured(params, textures, location)?,
        "interface" => Material::Interface,
        _ => Material::Diffuse { reflectance: color("reflectance", 0.5)? },
    };
    Ok((material, warnings))
}

/// Returns the names of the two materials of a mix, and the probability of the second.
pub(in crate::scene) fn mix(
    params: &ParamList,
    textures: &Textures,
    location: &Location,
) -> Result<([String; 2], Input<f64>), SceneError> {
    let expected = "two names of materials";
    let Some(param) = params.get("materials") else {
        return Err(location.invalid(format!("Material \"mix\" has no \"string materials\"; expected {expected}")));
    };
    let names = param.texts().try_into().map_err(|_| param.bad_value(expected))?;
    let amount = number(params, "amount", textures, 0.5)?;
    if let (Some(param), Input::Constant(value)) = (params.get("amount"), amount)
        && !(0.0..=1.0).contains(&value)
    {
        return Err(param.bad_value("a number from 0 to 1"));
    }
    Ok((names, amount))
}

fn number(params: &ParamList, name: &str, textures: &Textures, default: f64) -> Result<Input<f64>, SceneError> {
    params.get(name).map_or(Ok(Input::Constant(default)), |param| textures.number(param))
}

/// Returns a colour with channels from 0 to 1; `None` if the parameter is absent.
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

/// Returns the roughness of parameters with a prefix: `roughness` for both directions, or separate values.
fn roughness(params: &ParamList, prefix: &str, textures: &Textures) -> Result<Roughness, SceneError> {
    let along = |name: &str| {
        let name = format!("{prefix}{name}");
        let value = params.get(&name).map(|param| textures.number(param)).transpose()?;
        match (params.get(&name), value) {
            (Some(param), Some(Input::Constant(value))) if value < 0.0 => {
                Err(param.bad_value("0 or a number above it"))
            }
            _ => Ok(value),
        }
    };
    let both = along("roughness")?.unwrap_or(Input::Constant(0.0));
    Ok(Roughness {
        u: along("uroughness")?.unwrap_or(both),
        v: along("vroughness")?.unwrap_or(both),
        remap: params.get("remaproughness").is_none() || params.flag("remaproughness")?,
    })
}

/// Returns a metal from its reflectance or its optical constants, which are copper's by default. `outside`
/// is the index of refraction of the medium outside.
fn metal(
    params: &ParamList,
    constants: [&str; 2],
    outside: f64,
    textures: &Textures,
    location: &Location,
) -> Result<Metal, SceneError> {
    let [eta, k] = constants.map(|name| params.get(name));
    if let (Some(constant), Some(_)) = (eta.or(k), params.get("reflectance")) {
        return Err(constant
            .location
            .invalid(format!("{constant} is given beside a reflectance; expected either reflectance, or eta and k")));
    }
    let reflectance = params.get("reflectance").map(|param| textures.color(param)).transpose()?;
    let (eta, k) = match reflectance {
        Some(Input::Constant(reflectance)) => conductor_from_reflectance(reflectance),
        Some(texture) => return Ok(Metal::Reflectance(texture)),
        None => {
            let (copper_eta, copper_k) = copper(location)?;
            let negative = |param: &&Param| param.numbers().iter().any(|v| *v < 0.0);
            if let Some(param) = [eta, k].into_iter().flatten().find(negative) {
                return Err(param.bad_value("no negative value"));
            }
            conductor(&optional(eta)?.unwrap_or(copper_eta), &optional(k)?.unwrap_or(copper_k))
        }
    };
    Ok(Metal::Index { eta: eta / outside, k: k / outside })
}

/// The permitted indices of refraction.
const INDICES: RangeInclusive<f64> = 0.1..=10.0;

/// Returns an index of refraction; 1.5 if the parameter is absent.
fn index(params: &ParamList, name: &str) -> Result<Index, SceneError> {
    let eta = match params.get(name) {
        Some(param) if param.kind != Kind::Float => Spectrum::from_param(param)?.index(INDICES),
        _ => params.float(name)?.unwrap_or(1.5).into(),
    };
    match params.get(name) {
        Some(param) if !INDICES.contains(&eta.mean) => Err(param.bad_value("an index of refraction from 0.1 to 10")),
        _ => Ok(eta),
    }
}

fn measured(params: &ParamList, textures: &Textures, location: &Location) -> Result<Material, SceneError> {
    let (Some(param), Some(name)) = (params.get("filename"), params.string("filename")?) else {
        let expected = "expected the name of a .bsdf file";
        return Err(location.invalid(format!("Material \"measured\" has no \"string filename\"; {expected}")));
    };
    textures.measured(name, &param.location).map(Material::Measured)
}

fn dielectric(params: &ParamList, roughness: Roughness) -> Result<Material, SceneError> {
    let eta = index(params, "eta")?;
    let transmittance = fraction(params, "transmittance")?.unwrap_or(Rgb::ONE);
    // Without a difference of index, microfacets have no effect.
    let roughness = if eta == Index::from(1.0) { Roughness::SMOOTH } else { roughness };
    Ok(Material::Dielectric { eta, transmittance, roughness })
}

/// Maximum fraction of light that the coat of a metal may scatter: its albedo times its optical thickness. Up to this
/// bound the direction of the scattered light matters little.
const MOST_SCATTERED: f64 = 0.1;

/// Returns a coat.
fn coat(
    (params, location): (&ParamList, &Location),
    (eta, over_metal): (&str, bool),
    roughness: Roughness,
    textures: &Textures,
    warnings: &mut Vec<String>,
) -> Result<Coat, SceneError> {
    let thickness = number(params, "thickness", textures, 0.01)?;
    if let (Some(param), Input::Constant(value)) = (params.get("thickness"), thickness)
        && value < 0.0
    {
        return Err(param.bad_value("0 or a number above it"));
    }
    let scattering = scattering(params, textures)?;
    let eta = index(params, eta)?;
    let albedo = params.get("albedo").filter(|_| scattering.is_some());
    // Over a metal, what is scattered has no closed form.
    Ok(match albedo {
        Some(param) if over_metal => {
            let absorbed = 1.0 - straight_on(param, thickness, textures, location, warnings)?;
            Coat { eta, thickness, absorbed, scattering: None, roughness }
        }
        _ => Coat { eta, thickness, absorbed: 1.0, scattering, roughness },
    })
}

/// Returns the scattering inside of a coat; `None` if its albedo is 0.
fn scattering(params: &ParamList, textures: &Textures) -> Result<Option<Scattering>, SceneError> {
    let g = number(params, "g", textures, 0.0)?;
    if let (Some(param), Input::Constant(value)) = (params.get("g"), g)
        && !(-1.0..=1.0).contains(&value)
    {
        return Err(param.bad_value("a number from -1 to 1"));
    }
    let Some(param) = params.get("albedo") else {
        return Ok(None);
    };
    let albedo = textures.color(param)?;
    if let Input::Constant(value) = albedo {
        if value.min_element() < 0.0 || value.max_element() > 1.0 {
            return Err(param.bad_value("channels from 0 to 1"));
        }
        if value == Rgb::ZERO {
            return Ok(None);
        }
    }
    Ok(Some(Scattering { albedo, g }))
}

/// Returns the mean of the albedo of a metal's coat: the share of the extinguished light that goes straight on.
fn straight_on(
    param: &Param,
    thickness: Input<f64>,
    textures: &Textures,
    location: &Location,
    warnings: &mut Vec<String>,
) -> Result<f64, SceneError> {
    let (albedo, is_texture) = textures.mean_color(textures.color(param)?, location)?;
    let mean = albedo.element_sum() / 3.0;
    let (thickness, _) = textures.mean_number(thickness, location)?;
    let scattered = mean * thickness;
    if scattered > MOST_SCATTERED {
        let what = format!(
            "{param} that scatters {scattered:.2} of the light in the coat of a metal, by thickness times albedo,"
        );
        let instead = format!("coats of metals that scatter up to {MOST_SCATTERED}, and any coat of \"coateddiffuse\"");
        return Err(param.location.unsupported(&what, &instead));
    }
    if is_texture {
        warnings.push(format!("{param} is rendered as its mean, {mean:.4}: a coat scatters alike everywhere"));
    }
    if scattered > 0.0 {
        warnings.push(format!("light that {param} scatters inside the coat is rendered as if it went straight on"));
    }
    Ok(mean)
}
