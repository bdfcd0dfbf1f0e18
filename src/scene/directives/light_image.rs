//! Lights with an image: skies, goniometric lights and projectors, as in pbrt-v4.
//!
//! Images of skies and goniometric lights are square, by the equal-area map of
//! [`crate::geometry::equal_area`]: +z of the light's space is up in a sky, +y is up in a goniometric
//! light. A sky of twice the width, with longitude and latitude, is resampled with the axes of pbrt's own
//! converter: +z is the top row, and the azimuth from +x to +y grows from left to right; no texel's power
//! changes (see `longitudes`). The colour of a direction is that of its texel, without interpolation.
//!
//! The RGB of a file reaches the film unchanged, times `scale`. A `power` is the light's total power, by
//! luminance (goniometric lights are grey: by the mean of channels).

mod longitudes;
mod portal;

use std::f64::consts::{PI, TAU};
use std::path::Path;
use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec2, DVec3};

use crate::base::input::Budget;
use crate::geometry::equal_area;
use crate::image::file::{ImageError, Transfer, Use, read_layers};
use crate::image::film::{Image, LUMINANCE};
use crate::scene::directives::emission::{emitted, positive};
use crate::scene::directives::shape::MeshFiles;
use crate::scene::directives::transform;
use crate::scene::format::error::{Location, SceneError};
use crate::scene::format::params::{Param, ParamList};
use crate::scene::model::{Light, LightImage, Rgb};

/// Maximum number of texels of a light that a device can hold, 512 MiB: 8192 x 4096, or 5792 x 5792.
const MAX_TEXELS: usize = 1 << 25;
/// Maximum side of an image: alias tables store the index of a texel in its row in 16 bits.
const MAX_SIDE: u32 = 1 << 16;

/// Reads the image file that a light names. Negative channels become 0; channels that are not finite are
/// errors.
pub(in crate::scene) fn read(
    name: &str,
    params: &ParamList,
    files: &MeshFiles,
    location: &Location,
    warnings: &mut Vec<String>,
) -> Result<Arc<Image>, SceneError> {
    let (Some(file), Some(param)) = (params.string("filename")?, params.get("filename")) else {
        return Err(location.invalid(format!("the {name} light has no image; expected a \"string filename\"")));
    };
    if params.get("L").is_some() {
        return Err(param.location.invalid("an infinite light has both \"L\" and \"filename\"; expected one of them"));
    }
    let mut image = read_image(&files.directory.join(file), &files.budget, param)?;
    let Image { width, height, .. } = image;
    if image.pixels.len() > MAX_TEXELS || width.max(height) > MAX_SIDE {
        return Err(param.bad_value(&format!("an image of at most {MAX_TEXELS} pixels; it has {width}x{height}")));
    }
    for value in image.pixels.as_flattened_mut() {
        if !value.is_finite() {
            return Err(param.bad_value(&format!("an image without infinities; a channel is {value}")));
        }
        *value = value.max(0.0);
    }
    match name {
        "projection" => Ok(Arc::new(image)),
        "goniometric" if width == height => {
            image.pixels.iter_mut().for_each(|pixel| *pixel = [pixel.iter().sum::<f32>() / 3.0; 3]);
            Ok(Arc::new(image))
        }
        "infinite" if width == height => Ok(Arc::new(image)),
        "infinite" if width == 2 * height => {
            warnings.push(format!(
                "{file} is twice as wide as high: it is read as longitude and latitude, with +z of the light's space at \
                 the top, and resampled to a square; pbrt would refuse it"
            ));
            // The resampled image has about as many pixels.
            let bytes = size_of_val(&image.pixels[..]) as u64;
            files.budget.check(bytes).map_err(param.location.over())?;
            Ok(Arc::new(longitudes::equal_area(&image)))
        }
        _ => Err(not_square(param, &image)),
    }
}

fn not_square(param: &Param, image: &Image) -> SceneError {
    param.bad_value(&format!("a square image, by pbrt's equal-area map; it has {}x{}", image.width, image.height))
}

/// Reads an image of a light; its pixels are charged to the budget.
fn read_image(path: &Path, budget: &Budget, param: &Param) -> Result<Image, SceneError> {
    let layers = read_layers(path, Transfer::Srgb, Use::Light, budget).map_err(|error| match error {
        ImageError::Read { path, reason } => {
            SceneError::Unreadable { path, location: Some(param.location.clone()), source: reason }
        }
        other => param.location.invalid(other.to_string()),
    })?;
    // Lights do not use alpha.
    budget.give_back(layers.alpha.as_ref().map_or(0, |alpha| size_of_val(&alpha[..]) as u64));
    Ok(layers.image)
}

/// Returns a sky. `illuminance` is the irradiance of a patch that faces +z of the light's space. As in
/// pbrt, it is computed as if a texel had half its solid angle.
pub(in crate::scene) fn sky(
    pixels: Arc<Image>,
    params: &ParamList,
    world_from_light: DAffine3,
    location: &Location,
) -> Result<Light, SceneError> {
    let mut radiance = Rgb::splat(params.not_negative("scale", 1.0)?);
    if let Some(illuminance) = positive(params, "illuminance")? {
        let facing = mean(&pixels, |place| equal_area::direction(place).z.max(0.0));
        radiance *= over(illuminance, TAU * facing);
    }
    let image = oriented(pixels, world_from_light.matrix3, location)?;
    Ok(Light::Sky { image, radiance, portal: portal::portal(params)? })
}

/// Returns a sky of the same radiance everywhere, which is seen through a portal. As in pbrt, an `illuminance` is
/// computed as that of an image.
pub(in crate::scene) fn even_sky(
    params: &ParamList,
    world_from_light: DAffine3,
    location: &Location,
) -> Result<Light, SceneError> {
    let even = Image { pixels: vec![[1.0; 3]], ..Image::new(1, 1) };
    let sky = sky(Arc::new(even), params, world_from_light, location)?;
    let (scaled, scale) = (emitted(params, "L")?, params.not_negative("scale", 1.0)?);
    let colour = if scale > 0.0 { scaled / scale } else { Rgb::ZERO };
    let luminance = if params.get("illuminance").is_some() { colour.dot(Rgb::from(LUMINANCE)) } else { 1.0 };
    Ok(match sky {
        Light::Sky { image, radiance, portal } => {
            Light::Sky { image, radiance: radiance * colour * over(1.0, luminance), portal }
        }
        other => other,
    })
}

/// Returns a light whose intensity in each direction is given by an image.
pub(in crate::scene) fn goniometric(
    pixels: Arc<Image>,
    params: &ParamList,
    world_from_light: DAffine3,
    location: &Location,
) -> Result<Light, SceneError> {
    let mut intensity = emitted(params, "I")?;
    if let Some(power) = positive(params, "power")? {
        intensity *= over(power, 4.0 * PI * mean(&pixels, |_| 1.0));
    }
    // The map's z axis is the light's y axis.
    let axes = world_from_light.matrix3;
    let axes = DMat3::from_cols(axes.x_axis, axes.z_axis, axes.y_axis);
    let position = world_from_light.translation;
    Ok(Light::Goniometric { position, image: oriented(pixels, axes, location)?, intensity })
}

/// Returns a light that projects an image along its +z axis; the image's top is at +y.
pub(in crate::scene) fn projection(
    pixels: Arc<Image>,
    params: &ParamList,
    world_from_light: DAffine3,
    location: &Location,
) -> Result<Light, SceneError> {
    let fov = params.float_in("fov", 90.0, |v| v > 0.0 && v < 180.0, "an angle above 0 and below 180°")?;
    // `fov` is the angle of the shorter side.
    let size = DVec2::new(pixels.width.into(), pixels.height.into());
    let half_extent = size / size.min_element() * (0.5 * fov.to_radians()).tan();
    let mut intensity = Rgb::splat(params.not_negative("scale", 1.0)?);
    if let Some(power) = positive(params, "power")? {
        let area = 4.0 * half_extent.element_product();
        intensity *= over(power, area * mean(&pixels, |place| window_cosine(half_extent, place).powi(3)));
    }
    let axes = world_from_light.matrix3;
    let axes = DMat3::from_cols(axes.x_axis, -axes.y_axis, axes.z_axis);
    let position = world_from_light.translation;
    Ok(Light::Projection { position, image: oriented(pixels, axes, location)?, intensity, half_extent })
}

/// Returns the cosine of the angle between a projector's axis and the ray through `place`, in [0, 1]², of
/// its image. Its cube is the ratio of solid angle to area on the window.
pub(crate) fn window_cosine(half_extent: DVec2, place: DVec2) -> f64 {
    ((2.0 * place - 1.0) * half_extent).extend(1.0).length().recip()
}

/// Returns the factor from `emitted` to `wanted`; 0 for a black image, for which `emitted` is 0.
fn over(wanted: f64, emitted: f64) -> f64 {
    if emitted > 0.0 { wanted / emitted } else { 0.0 }
}

/// Returns the mean over an image of luminance times `weight`; the argument of `weight` is the pixel's
/// centre in [0, 1]².
fn mean(image: &Image, weight: impl Fn(DVec2) -> f64) -> f64 {
    let size = DVec2::new(image.width.into(), image.height.into());
    let weighed = image.pixels.iter().enumerate().map(|(i, pixel)| {
        let (x, y) = (i % image.width as usize, i / image.width as usize);
        let place = (DVec2::new(x as f64, y as f64) + 0.5) / size;
        DVec3::from(pixel.map(f64::from)).dot(DVec3::from(LUMINANCE)) * weight(place)
    });
    weighed.sum::<f64>() / image.pixels.len() as f64
}

/// Returns the maximum of each channel over the image.
pub(in crate::scene) fn brightest(image: &Image) -> Rgb {
    image.pixels.iter().fold(Rgb::ZERO, |most, pixel| most.max(Rgb::from(pixel.map(f64::from))))
}

fn oriented(pixels: Arc<Image>, axes: DMat3, location: &Location) -> Result<LightImage, SceneError> {
    if !transform::keeps_angles(&DAffine3::from_mat3(axes)) {
        return Err(location.invalid(
            "the light's transform distorts its image; expected rotations, reflections and uniform scales only",
        ));
    }
    let [x, y, z] = [axes.x_axis, axes.y_axis, axes.z_axis].map(DVec3::normalize);
    Ok(LightImage { pixels, world_from_image: DMat3::from_cols(x, y, z) })
}

#[cfg(test)]
mod tests;
