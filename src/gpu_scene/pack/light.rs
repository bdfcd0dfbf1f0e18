//! Packing of lights, and the tables that choose a light.

use std::f64::consts::PI;
use std::ops::RangeInclusive;

use glam::{DVec2, DVec3};
use obvhs::aabb::Aabb;

use super::light_image::Tables;
use super::light_image::portal::PlacedPortal;
use super::light_range::set_reach;
use super::media::packed_medium;
use super::{PackError, Packer, RenderSpace, light_image, mean};
use crate::gpu_scene::alias;
use crate::kernels::{
    self, AREA, AliasEntry, DISTANT, GONIOMETRIC, INFINITE, NONE, POINT, PORTAL, PROJECTION, SKY, SPOT,
};
use crate::scene::{AreaLight, Light, LightImage, Rgb, Scene};

/// Permitted mean of channels of the power of all lights, W at render scale: products of radiance, distance
/// and radius stay well within the range of fp32.
pub(super) const POWERS: RangeInclusive<f64> = 1e-30..=1e30;

/// Returns the name of a kind of light, as the kernels number it.
pub(crate) fn light_kind(kind: u32) -> &'static str {
    match kind {
        POINT => "point",
        SPOT => "spot",
        DISTANT => "distant",
        INFINITE => "infinite",
        AREA => "area",
        SKY => "sky",
        GONIOMETRIC => "goniometric",
        PROJECTION => "projection",
        PORTAL => "portal",
        _ => "other",
    }
}

impl Packer {
    /// Adds all lights that are not surfaces, skies first.
    pub fn add_lights(&mut self, scene: &Scene, space: &RenderSpace) {
        let lights = scene.lights.iter().zip(scene.light_media.iter().zip(&scene.light_curves));
        let (skies, others): (Vec<_>, Vec<_>) = lights.partition(|(light, _)| matches!(light, Light::Sky { .. }));
        self.sky_count = skies.len() as u32;
        for (light, (medium, curve)) in skies.into_iter().chain(others) {
            let index = self.add_light(light, space);
            self.lights[index as usize].medium = packed_medium(*medium);
            self.light_curves[index as usize].clone_from(curve);
        }
    }

    fn add_light(&mut self, light: &Light, space: &RenderSpace) -> u32 {
        let render_from_world = self.render_from_world;
        let place = |position: DVec3| render_from_world.transform_point3(position).as_vec3().to_array();
        let area_scale = space.scale * space.scale;
        let sphere = 4.0 * PI;
        let (packed, power) = match light {
            Light::Point { position, intensity } => {
                let intensity = *intensity * area_scale;
                let light = kernels::Light { position: place(*position), ..light_of(POINT, intensity) };
                (light, mean(intensity) * sphere)
            }
            Light::Spot { position, direction, intensity, falloff_start, falloff_end } => {
                let intensity = *intensity * area_scale;
                let light = kernels::Light {
                    position: place(*position),
                    direction: direction.as_vec3().to_array(),
                    falloff_start: *falloff_start as f32,
                    falloff_end: *falloff_end as f32,
                    ..light_of(SPOT, intensity)
                };
                (light, mean(intensity) * PI * (falloff_start + falloff_end))
            }
            Light::Distant { direction, irradiance } => {
                let light =
                    kernels::Light { direction: direction.as_vec3().to_array(), ..light_of(DISTANT, *irradiance) };
                (light, mean(*irradiance) * space.shown_to(*direction))
            }
            Light::Goniometric { position, image, intensity } => {
                let intensity = *intensity * area_scale;
                let (primitive, colour) = self.add_light_image(image, None);
                let light =
                    kernels::Light { position: place(*position), primitive, ..light_of(GONIOMETRIC, intensity) };
                (light, mean(intensity * colour) * sphere)
            }
            Light::Projection { position, image, intensity, half_extent } => {
                let intensity = *intensity * area_scale;
                let (primitive, colour) = self.add_light_image(image, Some(*half_extent));
                let light = kernels::Light { position: place(*position), primitive, ..light_of(PROJECTION, intensity) };
                (light, mean(intensity * colour) * 4.0 * half_extent.element_product())
            }
            Light::Sky { image, radiance, portal: Some(portal) } => {
                let portal = PlacedPortal::new(portal, &render_from_world);
                let (packed, colour) = portal.pack(image, self.tables(), &mut self.light_texels);
                self.light_images.push(packed);
                let primitive = self.light_images.len() as u32 - 1;
                let light = kernels::Light { primitive, ..light_of(PORTAL, *radiance) };
                (light, mean(*radiance * colour) * sphere * portal.area())
            }
            Light::Sky { image, radiance, portal: None } => {
                let (primitive, colour) = self.add_light_image(image, None);
                let light = kernels::Light { primitive, ..light_of(SKY, *radiance) };
                (light, mean(*radiance * colour) * sphere * space.mean_shown())
            }
            Light::Infinite { radiance } => {
                self.infinite += *radiance;
                (light_of(INFINITE, *radiance), mean(*radiance) * sphere * space.mean_shown())
            }
        };
        self.push_light(packed, power)
    }

    fn tables(&self) -> Tables {
        if self.is_guided { Tables::Cumulative } else { Tables::Alias }
    }

    /// Adds an image, and returns its index and the mean colour by which the light's power is multiplied.
    fn add_light_image(&mut self, image: &LightImage, window: Option<DVec2>) -> (u32, Rgb) {
        let (packed, colour) = light_image::pack(image, window, self.tables(), &mut self.light_texels);
        self.light_images.push(packed);
        (self.light_images.len() as u32 - 1, colour)
    }

    /// Adds an emitting primitive with an area in square render units, and returns its index among the
    /// lights; `NONE` if the area is 0.
    pub fn add_emitter(&mut self, emission: &AreaLight, primitive: u32, area: f64, bounds: &Aabb) -> u32 {
        if area <= 0.0 {
            return NONE;
        }
        let sides = if emission.two_sided { 2.0 } else { 1.0 };
        let exitance = std::f64::consts::PI * sides;
        let radiance = self.radiance(emission, area);
        let mut light = kernels::Light {
            primitive,
            area: area as f32,
            two_sided: u32::from(emission.two_sided),
            image: emission.image.map_or(NONE, |image| image.texture as u32),
            ..light_of(AREA, radiance)
        };
        set_reach(&mut light, bounds, area);
        if self.is_invisible {
            // No direction sampled from the BSDF finds the light.
            light.reach2 = 0.0;
        }
        let shown = emission.image.map_or(Rgb::ONE, |image| image.mean);
        let index = self.push_light(light, mean(radiance * shown) * exitance * area);
        self.light_curves[index as usize].clone_from(&emission.curve);
        index
    }

    /// Returns the radiance of an emitter; `area` is its whole area in square render units.
    pub fn radiance(&self, emission: &AreaLight, area: f64) -> Rgb {
        let scale = self.render_from_world.matrix3.x_axis.x;
        let sides = if emission.two_sided { 2.0 } else { 1.0 };
        match emission.power {
            Some(power) => emission.radiance * (power * scale * scale / (std::f64::consts::PI * sides * area)),
            None => emission.radiance,
        }
    }

    pub fn push_light(&mut self, light: kernels::Light, power: f64) -> u32 {
        self.lights.push(light);
        self.powers.push(power);
        self.light_curves.push(None);
        self.lights.len() as u32 - 1
    }

    /// Fails if a light, or all light, is outside of fp32's range.
    pub(super) fn check_brightness(&self, mean_power: f64) -> Result<(), PackError> {
        // There are no photons without surfaces, nor without light.
        if mean_power != 0.0 && !self.references.is_empty() && !POWERS.contains(&mean_power) {
            return Err(PackError::Power(mean_power));
        }
        match self.lights.iter().flat_map(|light| light.emission).find(|emission| !emission.is_finite()) {
            Some(emission) => Err(PackError::TooBright(emission.into())),
            None => Ok(()),
        }
    }

    /// Returns the alias tables that choose lights by power: for photons, and for next-event estimation. With a guide the
    /// latter has an entry for each light.
    /// Sets the probabilities of the lights.
    pub fn choose_lights(&mut self) -> (Vec<AliasEntry>, Vec<AliasEntry>) {
        let all: Vec<u32> = (0..self.lights.len() as u32).collect();
        // Constant infinite light is only found by sampling the BSDF.
        let located: Vec<u32> =
            all.iter().copied().filter(|index| self.lights[*index as usize].kind != INFINITE).collect();
        let located_powers: Vec<f64> = located.iter().map(|index| self.powers[*index as usize]).collect();
        let total: f64 = self.powers.iter().sum();
        let located_total: f64 = located_powers.iter().sum();
        for (light, power) in self.lights.iter_mut().zip(&self.powers).filter(|_| total > 0.0) {
            light.emission_pmf = (power / total) as f32;
            if light.kind != INFINITE && located_total > 0.0 {
                light.direct_pmf = (power / located_total) as f32;
            }
        }
        let direct_table = if self.is_guided {
            let chances: Vec<f64> = self.lights.iter().map(|light| light.direct_pmf.into()).collect();
            alias::table_with_chances(&chances)
        } else {
            alias::table(&located_powers, &located)
        };
        (alias::table(&self.powers, &all), direct_table)
    }
}

pub fn light_of(kind: u32, emission: Rgb) -> kernels::Light {
    kernels::Light {
        emission: emission.as_vec3().to_array(),
        kind,
        primitive: NONE,
        image: NONE,
        ..bytemuck::Zeroable::zeroed()
    }
}
