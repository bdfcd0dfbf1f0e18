//! The region in which an area light looks so large that next-event estimation alone would be noisy.

use glam::{DVec3, Vec3A};
use obvhs::aabb::Aabb;

use crate::kernels::{self, AREA, KIND_SHIFT, SPHERE};

/// Solid angle above which lights are also searched by sampling the BSDF. Below it, the distance to the
/// light's points varies little, and so does the contribution of a sample.
const LARGE: f64 = 0.5;

/// Sets the middle of an emitter with these bounds and area, and the squared distance up to which it is
/// large.
pub(super) fn set_reach(light: &mut kernels::Light, bounds: &Aabb, area: f64) {
    let middle = 0.5 * (bounds.min + bounds.max);
    let radius = 0.5 * f64::from((bounds.max - bounds.min).length());
    // A sphere is sampled by its cone of directions.
    let is_sphere = light.primitive >> KIND_SHIFT == SPHERE;
    let reach = if is_sphere { 2.0 * radius } else { radius + (area / LARGE).sqrt() };
    light.position = middle.to_array();
    light.reach2 = (reach * reach) as f32;
}

/// Returns a sphere that contains all places from which any area light is large: its centre and squared
/// radius, in render units.
pub fn sphere_of_reach(lights: &[kernels::Light]) -> ([f32; 3], f32) {
    let area_lights = || lights.iter().filter(|light| light.kind == AREA);
    let count = area_lights().count().max(1) as f64;
    let place = |light: &kernels::Light| Vec3A::from(light.position).as_dvec3();
    let center = area_lights().map(place).sum::<DVec3>() / count;
    let reach = |light: &kernels::Light| place(light).distance(center) + f64::from(light.reach2).sqrt();
    let most = area_lights().map(reach).fold(0.0, f64::max);
    (center.as_vec3().to_array(), (1.00001 * most * most) as f32)
}
