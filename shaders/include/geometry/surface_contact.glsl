// Surfaces in contact (contact.glsl), where a ray meets a surface and where it leaves one.
#include "geometry/contact.glsl"
#include "geometry/surface_point.glsl"
#include "scene/features.glsl"
#include "scene/primitives.glsl"
#include "scene/scene.glsl"

// Position error of a primitive. In contact, it is at least the largest error of any surface in contact.
float error_in_contact(uint material, float error) {
    return max(error, layer_of(material) != 0u ? scene.contact_error : 0.0);
}

// Sets the material and the layer of a primitive; surface.error must be set.
void set_material(inout Surface surface, uint material) {
    surface.material = material;
    if (HAS_CONTACTS) {
        surface.material = material & MATERIAL_MASK;
        surface.layer = layer_of(material);
        surface.error = error_in_contact(material, surface.error);
        surface.from_behind = false;
    }
}

// Sets how a surface in contact was met by a ray at t.
void set_contact(inout Surface surface, Ray ray, float t) {
    if (HAS_CONTACTS) {
        surface.from_behind = ray.to_front && t <= -ray.begin && (surface.layer & SHEET_LAYERS & ray.entries) != 0u;
        surface.error = error_in_contact(surface.layer, surface.error);
    }
}

// Longest part of a ray that grazes a surface in contact on which the other surfaces are searched for,
// render units.
const float MOST_GRAZING = 0.01;

// Largest difference in t at which a ray through this surface meets the surfaces in contact with it.
float contact_width(Surface surface, vec3 direction) {
    float width = 2.0 * normal_error(surface) / abs(dot(direction, surface.normal));
    return min(width, MOST_GRAZING * inversesqrt(dot(direction, direction)));
}

// Sets which surfaces in contact a ray that starts at a surface may meet: those that follow in the order
// of contact, even slightly behind its origin. `passes`: its path crosses the surface.
void set_ray_contacts(inout Ray ray, Surface surface, bool passes) {
    if (HAS_CONTACTS) {
        bool to_front = passes == surface.from_behind;
        meet_followers(ray, surface.layer, dot(ray.direction, surface.normal) > 0.0, to_front);
        ray.begin = surface.layer != 0u ? -contact_width(surface, ray.direction) : 0.0;
    }
}
