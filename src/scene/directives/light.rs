//! The `LightSource` and `AreaLightSource` directives, with pbrt-v4's units.
//!
//! pbrt scales the spectrum of every light to luminance 1 and then multiplies it by `scale`. The spectrum
//! of an `rgb` light is a white of luminance 1 times the RGB, so the RGB reaches the film unchanged. A
//! positive `power` or `illuminance` then gives a factor that is computed as if the light were white with
//! value 1. `light_image` describes lights with images.

use std::f64::consts::PI;
use std::path::Path;

use glam::{DAffine3, DVec3};

use crate::image::film::LUMINANCE;
use crate::scene::directives::emission::{by_wavelength, emitted, positive};
use crate::scene::directives::light_image;
use crate::scene::directives::shape::MeshFiles;
use crate::scene::directives::texture::Textures;
use crate::scene::directives::transform;
use crate::scene::format::error::{Location, SceneError};
use crate::scene::format::kind::Kind;
use crate::scene::format::params::ParamList;
use crate::scene::format::registry::{Family, ParamSpec, full, ignored, supported};
use crate::scene::model::{AreaLight, ByWavelength, EmissionImage, Light, Rgb};

const COLOUR: &[Kind] = &[Kind::Rgb, Kind::Spectrum, Kind::Blackbody];

const SCALE: ParamSpec = full("scale", &[Kind::Float]);
const POWER: ParamSpec = full("power", &[Kind::Float]);
const FROM: ParamSpec = full("from", &[Kind::Point3]);
const TO: ParamSpec = full("to", &[Kind::Point3]);
const ILLUMINANCE: ParamSpec = full("illuminance", &[Kind::Float]);
const FILENAME: ParamSpec = full("filename", &[Kind::String]);

/// The lights of pbrt that are not surfaces.
pub(in crate::scene) const FAMILY: Family = Family {
    directive: "LightSource",
    types: &[
        supported("point", &[full("I", COLOUR), SCALE, POWER, FROM]),
        supported(
            "spot",
            &[
                full("I", COLOUR),
                SCALE,
                POWER,
                FROM,
                TO,
                full("coneangle", &[Kind::Float]),
                full("conedeltaangle", &[Kind::Float]),
            ],
        ),
        supported("distant", &[full("L", COLOUR), SCALE, ILLUMINANCE, FROM, TO]),
        supported("infinite", &[full("L", COLOUR), SCALE, ILLUMINANCE, FILENAME, full("portal", &[Kind::Point3])]),
        supported("goniometric", &[full("I", COLOUR), SCALE, POWER, FILENAME]),
        supported("projection", &[SCALE, POWER, full("fov", &[Kind::Float]), FILENAME]),
    ],
};

/// The emitting surfaces of pbrt.
pub(in crate::scene) const AREA_FAMILY: Family = Family {
    directive: "AreaLightSource",
    types: &[supported(
        "diffuse",
        &[
            full("L", COLOUR),
            SCALE,
            POWER,
            full("twosided", &[Kind::Bool]),
            full("filename", &[Kind::String]),
            ignored("nsamples", &[Kind::Integer]),
        ],
    )],
};

/// Returns a light from parameters that [`FAMILY`] has checked. The name of its image file is relative to
/// the directory of `files`.
pub(in crate::scene) fn light(
    name: &str,
    params: &ParamList,
    files: &MeshFiles,
    world_from_light: DAffine3,
    location: &Location,
    warnings: &mut Vec<String>,
) -> Result<Light, SceneError> {
    let light = match name {
        "point" => Light::Point {
            position: world_from_light.transform_point3(from(params)?),
            intensity: emitted(params, "I")? * power(params, 4.0 * PI)?,
        },
        "spot" => spot(params, world_from_light, location)?,
        "distant" => {
            let axis = from(params)? - to(params)?;
            let to_light = direction(axis, world_from_light, location)?;
            Light::Distant {
                direction: -to_light,
                irradiance: emitted(params, "L")? * positive(params, "illuminance")?.unwrap_or(1.0),
            }
        }
        "infinite" if params.get("filename").is_none() && params.get("portal").is_some() => {
            light_image::even_sky(params, world_from_light, location)?
        }
        "infinite" if params.get("filename").is_none() => Light::Infinite {
            // A constant sky of radiance 1 gives a patch that faces up an irradiance of π.
            radiance: emitted(params, "L")? * positive(params, "illuminance")?.map_or(1.0, |e| e / PI),
        },
        _ => {
            let file = light_image::read(name, params, files, location, warnings)?;
            match name {
                "goniometric" => light_image::goniometric(file, params, world_from_light, location)?,
                "projection" => light_image::projection(file, params, world_from_light, location)?,
                _ => light_image::sky(file, params, world_from_light, location)?,
            }
        }
    };
    let emission = emission(&light);
    let position = light.position().unwrap_or_default();
    if !emission.is_finite() || !position.is_finite() {
        return Err(location.invalid(format!(
            "the {name} light's emission {emission} or position {position} overflows; \
             expected smaller numbers"
        )));
    }
    Ok(light)
}

/// Returns the curve of a light over that of daylight, in any unit; `None` if the light is known as RGB only.
pub(in crate::scene) fn curve(params: &ParamList) -> Result<Option<ByWavelength>, SceneError> {
    let name = if params.get("I").is_some() { "I" } else { "L" };
    by_wavelength(params, name)
}

/// Returns the light's intensity, irradiance or radiance; with an image, the maximum over the image.
pub(in crate::scene) fn emission(light: &Light) -> Rgb {
    match light {
        Light::Point { intensity, .. } | Light::Spot { intensity, .. } => *intensity,
        Light::Distant { irradiance, .. } => *irradiance,
        Light::Infinite { radiance } => *radiance,
        Light::Goniometric { image, intensity, .. } | Light::Projection { image, intensity, .. } => {
            *intensity * light_image::brightest(&image.pixels)
        }
        Light::Sky { image, radiance, .. } => *radiance * light_image::brightest(&image.pixels),
    }
}

fn spot(params: &ParamList, world_from_light: DAffine3, location: &Location) -> Result<Light, SceneError> {
    let in_half_turn = |v| v > 0.0 && v <= 180.0;
    let end = params.float_in("coneangle", 30.0, in_half_turn, "an angle above 0, up to 180°")?;
    let delta = params.float_in(
        "conedeltaangle",
        end.min(5.0),
        |v| (0.0..=end).contains(&v),
        "an angle from 0 to coneangle",
    )?;
    let one_minus_cos = |angle: f64| 2.0 * (0.5 * angle.to_radians()).sin().powi(2);
    let [falloff_start, falloff_end] = [end - delta, end].map(one_minus_cos);
    // The integral over directions of the cone with its smooth falloff.
    let cone = PI * (falloff_start + falloff_end);
    let (from, to) = (from(params)?, to(params)?);
    if !transform::is_invertible(&world_from_light) {
        return Err(location.invalid("the transform of the spot light is singular; expected one that can be inverted"));
    }
    Ok(Light::Spot {
        position: world_from_light.transform_point3(from),
        direction: direction(to - from, world_from_light, location)?,
        intensity: emitted(params, "I")? * power(params, cone)?,
        falloff_start,
        falloff_end,
    })
}

/// Returns an area light from parameters that [`AREA_FAMILY`] has checked.
pub(in crate::scene) fn area_light(
    params: &ParamList,
    textures: &mut Textures,
    directory: &Path,
) -> Result<AreaLight, SceneError> {
    let image = emission_image(params, textures, directory)?;
    let power = positive(params, "power")?;
    // The power is that of an emitter with the image's mean luminance everywhere.
    let luminance = image.filter(|_| power.is_some()).map(|image| image.mean.dot(Rgb::from(LUMINANCE)));
    Ok(AreaLight {
        radiance: emitted(params, "L")? / luminance.filter(|luminance| *luminance > 0.0).unwrap_or(1.0),
        power,
        two_sided: params.flag("twosided")?,
        image,
        curve: by_wavelength(params, "L")?,
    })
}

fn emission_image(
    params: &ParamList,
    textures: &mut Textures,
    directory: &Path,
) -> Result<Option<EmissionImage>, SceneError> {
    let Some(param) = params.get("filename") else {
        return Ok(None);
    };
    if params.get("L").is_some() {
        return Err(param.location.invalid(format!("{param} is given beside an L; expected one of them")));
    }
    let name = params.string("filename")?.unwrap_or_default();
    textures.emission(directory.join(name), param).map(Some)
}

fn from(params: &ParamList) -> Result<DVec3, SceneError> {
    Ok(params.point("from")?.unwrap_or(DVec3::ZERO))
}

fn to(params: &ParamList) -> Result<DVec3, SceneError> {
    Ok(params.point("to")?.unwrap_or(DVec3::Z))
}

/// Returns the direction of `axis` in world space, of unit length.
fn direction(axis: DVec3, world_from_light: DAffine3, location: &Location) -> Result<DVec3, SceneError> {
    let axis = axis
        .try_normalize()
        .ok_or_else(|| location.invalid("\"point3 from\" and \"point3 to\" are the same point; expected two"))?;
    let turned = world_from_light.transform_vector3(axis).try_normalize();
    turned.ok_or_else(|| location.invalid("the transform takes the light's direction to 0; expected another one"))
}

/// Returns the factor that scales a light of intensity 1 to the parameter `power`; `directions` is the
/// light's power at intensity 1. Returns 1 without that parameter.
fn power(params: &ParamList, directions: f64) -> Result<f64, SceneError> {
    Ok(positive(params, "power")?.map_or(1.0, |power| power / directions))
}
