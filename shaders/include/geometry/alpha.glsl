// Rays against what is there of the surfaces, in the order in which surfaces in contact are met.
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

// The nearest hit with t < t_max. Of surfaces in contact, whose t differ by roundings, the first in
// their order: what precedes a hit there is looked for until nothing does.
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
        // A loop of one round: on a processor, lanes that need none of it skip it together.
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

Hit intersect_in_order(Ray ray, float t_max) {
    if (HAS_CONTACTS) {
        return intersect_contacts(ray, t_max);
    }
    return traverse(ray, t_max, false);
}

// Surfaces that a ray passes where they are cut away, at most; the next one stops it.
const uint MAX_CUT_SURFACES = 64u;

// Whether a surface lets a ray pass. By a hash of the ray, as in pbrt: the next surface gets
// another number, since the ray begins elsewhere then.
bool lets_pass(Surface surface, Ray ray) {
    uvec3 bits = pcg3d(floatBitsToUint(ray.origin));
    bits = pcg3d(bits ^ floatBitsToUint(ray.direction));
    return to_unit(bits.x) >= opacity(surface);
}

// The nearest hit with t < t_max on what is there. A ray goes on behind a surface that lets it
// pass.
Hit intersect_opaque(Ray ray, float t_max) {
    vec3 begin = ray.origin;
    float passed = 0.0; // in lengths of the direction
    Hit hit;
    bool passes = true;
    for (uint i = 0u; passes; i++) {
        hit = intersect_in_order(ray, t_max - passed);
        passes = hit.primitive != NONE && i < MAX_CUT_SURFACES;
        if (passes) {
            Surface surface = surface_at(ray, hit);
            passes = lets_pass(surface, ray);
            if (passes) {
                ray = leave(surface, ray.direction, true);
                passed = dot(ray.origin - begin, ray.direction) / dot(ray.direction, ray.direction);
            }
        }
    }
    hit.t += passed;
    return hit;
}

Hit intersect(Ray ray) {
    if (HAS_ALPHA) {
        return intersect_opaque(ray, INFINITY_T);
    }
    return intersect_in_order(ray, INFINITY_T);
}

// Whether anything stands in a ray's way before t = 1.
bool occluded(Ray ray) {
    if (HAS_ALPHA) {
        return intersect_opaque(ray, 1.0).primitive != NONE;
    }
    return traverse(ray, 1.0, true).primitive != NONE;
}
