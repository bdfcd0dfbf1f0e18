// What surfaces in contact change where a ray meets a surface and where it leaves one.
#include "geometry/contact.glsl"
#include "geometry/surface_point.glsl"
#include "scene/features.glsl"
#include "scene/primitives.glsl"
#include "scene/scene.glsl"

// The error of a surface in contact is that of the least exact one that it may be in contact with.
float error_in_contact(uint material, float error) {
    return max(error, layer_of(material) != 0u ? scene.contact_error : 0.0);
}

// Sets the material of a primitive, whose error is known.
void set_material(inout Surface surface, uint material) {
    surface.material = material;
    if (HAS_CONTACTS) {
        surface.material = material & MATERIAL_MASK;
        surface.layer = layer_of(material);
        surface.error = error_in_contact(material, surface.error);
        surface.from_behind = false;
    }
}

// Completes a surface that a ray meets at t.
void set_contact(inout Surface surface, Ray ray, float t) {
    if (HAS_CONTACTS) {
        surface.from_behind = ray.to_front && t <= -ray.begin && (surface.layer & SHEET_LAYERS & ray.entries) != 0u;
        surface.error = error_in_contact(surface.layer, surface.error);
    }
}

// Of rays that graze a surface in contact, the longest way along it on which the others are looked
// for, render units.
const float MOST_GRAZING = 0.01;

// t within which surfaces in contact with this one are met by a ray through it.
float contact_width(Surface surface, vec3 direction) {
    float width = 2.0 * normal_error(surface) / abs(dot(direction, surface.normal));
    return min(width, MOST_GRAZING * inversesqrt(dot(direction, direction)));
}

// Lets a ray that starts at a surface meet those that follow in the order of contact, though they
// may lie behind its origin. `passes` where its path goes through the surface.
void see_contacts(inout Ray ray, Surface surface, bool passes) {
    if (HAS_CONTACTS) {
        bool to_front = passes == surface.from_behind;
        meet_followers(ray, surface.layer, dot(ray.direction, surface.normal) > 0.0, to_front);
        ray.begin = surface.layer != 0u ? -contact_width(surface, ray.direction) : 0.0;
    }
}
