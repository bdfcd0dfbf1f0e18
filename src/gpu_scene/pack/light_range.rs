//! From where an area light is so large that next-event estimation alone would be noisy.

use glam::{DVec3, Vec3A};
use obvhs::aabb::Aabb;

use crate::kernels::{self, AREA, KIND_SHIFT, SPHERE};

/// Solid angle from which on directions of the bsdf look for a light, too: below it, the
/// distance to the light's points varies little, and so does what they bring.
const LARGE: f64 = 0.5;

/// Fills in the middle of an emitter with these bounds and area, and how far away it is large.
pub(super) fn set_reach(light: &mut kernels::Light, bounds: &Aabb, area: f64) {
    let middle = 0.5 * (bounds.min + bounds.max);
    let radius = 0.5 * f64::from((bounds.max - bounds.min).length());
    // A sphere is sampled by the cone that it fills.
    let is_sphere = light.primitive >> KIND_SHIFT == SPHERE;
    let reach = if is_sphere { 2.0 * radius } else { radius + (area / LARGE).sqrt() };
    light.position = middle.to_array();
    light.reach2 = (reach * reach) as f32;
}

/// A sphere that holds all places from which any area light is large: centre and squared
/// radius.
pub fn sphere_of_reach(lights: &[kernels::Light]) -> ([f32; 3], f32) {
    let area_lights = || lights.iter().filter(|light| light.kind == AREA);
    let count = area_lights().count().max(1) as f64;
    let place = |light: &kernels::Light| Vec3A::from(light.position).as_dvec3();
    let center = area_lights().map(place).sum::<DVec3>() / count;
    let reach = |light: &kernels::Light| place(light).distance(center) + f64::from(light.reach2).sqrt();
    let most = area_lights().map(reach).fold(0.0, f64::max);
    (center.as_vec3().to_array(), (1.00001 * most * most) as f32)
}
