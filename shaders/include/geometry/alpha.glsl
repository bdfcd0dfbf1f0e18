// Intersects rays with the scene, where alpha cuts surfaces away and contact orders them.
#include "geometry/contact.glsl"
#include "geometry/hit.glsl"
#include "geometry/intersect.glsl"
#include "geometry/surface.glsl"
#include "geometry/surface_contact.glsl"
#include "geometry/surface_point.glsl"
#include "material/texture.glsl"
#include "math/random.glsl"
#include "scene/constants.glsl"
#include "scene/features.glsl"
#include "scene/scene.glsl"

// Returns the nearest hit with t < t_max. The t of surfaces in contact differ by roundings only: of
// these, it returns the first in the order of contact.glsl. It repeats the search for surfaces that
// precede the hit until there is none.
Hit intersect_contacts(Ray ray, float t_max) {
    Hit hit = Hit(t_max, NONE, vec2(0.0), NONE);
    Ray wanted = ray;
    for (bool looks = true; looks;) {
        Hit found = traverse(wanted, t_max, false);
        looks = found.primitive != NONE;
        if (looks) {
            hit = found;
            vec3 position = ray.origin + hit.t * ray.direction;
            looks = all(greaterThanEqual(position, scene.contact_lower))
                 && all(lessThanEqual(position, scene.contact_upper));
        }
        // A loop of one round instead of `if`: a CPU driver skips a loop if no lane needs it.
        for (bool near = looks; near; near = false) {
            Surface surface = surface_at(ray, hit);
            float width = contact_width(surface, ray.direction);
            wanted.exits = ray.exits;
            wanted.entries = ray.entries;
            looks = meet_preceding(wanted, surface.layer, dot(ray.direction, surface.normal) > 0.0, hit.t <= width);
            wanted.begin = max(ray.begin, hit.t - width);
            t_max = hit.t + width;
        }
    }
    return hit;
}

// As intersect_contacts, or the nearest hit in a scene without surfaces in contact.
Hit intersect_by_contact_order(Ray ray, float t_max) {
    if (HAS_CONTACTS) {
        return intersect_contacts(ray, t_max);
    }
    return traverse(ray, t_max, false);
}

// Largest number of cut-away surfaces that a ray passes; the next surface stops it.
const uint MAX_CUT_SURFACES = 64u;

// Whether alpha cuts a surface away for a ray: a draw by a hash of the ray, as in pbrt. The next surface
// gets another number, since the ray then has another origin.
bool is_cut_away(Surface surface, Ray ray) {
    uvec3 bits = pcg3d(floatBitsToUint(ray.origin));
    bits = pcg3d(bits ^ floatBitsToUint(ray.direction));
    return to_unit(bits.x) >= opacity(surface);
}

// Returns the nearest hit with t < t_max, where alpha cuts no surface away. The ray goes on behind
// surfaces that are cut away.
Hit intersect_with_alpha(Ray ray, float t_max) {
    vec3 begin = ray.origin;
    float passed = 0.0; // t of the new origin
    Hit hit;
    bool passes = true;
    for (uint i = 0u; passes; i++) {
        hit = intersect_by_contact_order(ray, t_max - passed);
        passes = hit.primitive != NONE && i < MAX_CUT_SURFACES;
        if (passes) {
            Surface surface = surface_at(ray, hit);
            passes = is_cut_away(surface, ray);
            if (passes) {
                ray = spawn_ray(surface, ray.direction, true);
                passed = dot(ray.origin - begin, ray.direction) / dot(ray.direction, ray.direction);
            }
        }
    }
    hit.t += passed;
    return hit;
}

// Returns the nearest hit of a ray with the scene.
Hit intersect(Ray ray) {
    if (HAS_ALPHA) {
        return intersect_with_alpha(ray, INFINITY_T);
    }
    return intersect_by_contact_order(ray, INFINITY_T);
}

// Whether a surface blocks a ray before t = 1.
bool occluded(Ray ray) {
    if (HAS_ALPHA) {
        return intersect_with_alpha(ray, 1.0).primitive != NONE;
    }
    return traverse(ray, 1.0, true).primitive != NONE;
}
