// What is asked of the scene about a ray: its nearest hit, or whether anything blocks it. Where alpha cuts
// surfaces away, surfaces only bound media, or surfaces are in contact, an answer takes several walks through the
// hierarchy.
#include "geometry/contact.glsl"
#include "geometry/hit.glsl"
#include "geometry/intersect.glsl"
#include "geometry/surface.glsl"
#include "geometry/surface_contact.glsl"
#include "geometry/surface_point.glsl"
#include "material/texture.glsl"
#include "math/random.glsl"
#include "medium/medium.glsl"
#include "scene/constants.glsl"
#include "scene/features.glsl"
#include "scene/scene.glsl"
#include "spectrum/spread.glsl"
#include "spectrum/wavelength.glsl"

struct Query {
    Ray ray;      // that is walked now
    float t_max;  // hits are nearer; negative where nothing is asked
    bool any_hit; // any hit will do
    Ray whole;    // HAS_CONTACTS: the ray as it was asked about, or from behind the surface passed last
    Hit nearest;  // HAS_CONTACTS: of the walks so far
    vec3 begin;   // HAS_PASSABLE: origin of the ray as it was asked about
    float passed; // HAS_PASSABLE: t of the origin of `whole` on it
    uint cuts;    // HAS_ALPHA: surfaces cut away so far
    float end;    // HAS_PASSABLE: t_max as it was asked about
    vec3 kept;    // HAS_INTERFACES: share of light that media up to the origin of `whole` leave
    Split split;  // HAS_MEDIA: of the path that asks
};

Query query_of(Ray ray, float t_max, bool any_hit) {
    return Query(ray, t_max, any_hit, ray, no_hit(t_max), ray.origin, 0.0, 0u, t_max, vec3(1.0), no_split());
}

// Asks for the nearest hit of a ray with the scene.
Query nearest_hit(Ray ray) {
    return query_of(ray, INFINITY_T, false);
}

// Asks whether a surface blocks a ray before t = 1.
Query blocks(Ray ray) {
    Query query = query_of(ray, 1.0, true);
    if (HAS_PASSABLE) {
        query.any_hit = false; // surfaces are passed one after the other
    }
    return query;
}

// The ray that a query was asked about. Not where rays pass surfaces.
Ray asked_ray(Query query) {
    if (HAS_CONTACTS) {
        return query.whole;
    }
    return query.ray;
}

// Asks nothing.
Query no_query() {
    return query_of(free_ray(vec3(0.0), vec3(0.0)), -1.0, true);
}

// The t of surfaces in contact differ by roundings only: of these, the first in the order of contact.glsl
// is the hit. Searches for surfaces that precede the hit until there is none. Returns whether another walk
// is needed.
bool look_for_preceding(inout Query query, inout Hit hit) {
    bool looks = hit.primitive != NONE;
    if (looks) {
        query.nearest = hit;
        vec3 position = query.whole.origin + hit.t * query.whole.direction;
        looks = all(greaterThanEqual(position, scene.contact_lower)) && all(lessThanEqual(position, scene.contact_upper));
    }
    // A loop of one round instead of `if`: a CPU driver skips a loop if no lane needs it.
    for (bool near = looks; near; near = false) {
        Surface surface = surface_at(query.whole, hit);
        float width = contact_width(surface, query.whole.direction);
        query.ray.exits = query.whole.exits;
        query.ray.entries = query.whole.entries;
        looks = meet_preceding(query.ray, surface.layer, dot(query.whole.direction, surface.normal) > 0.0, hit.t <= width);
        query.ray.begin = max(query.whole.begin, hit.t - width);
        query.t_max = hit.t + width;
    }
    hit = query.nearest;
    return looks;
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

// Whether a ray passes a surface: alpha cuts it away, or it only bounds media. Sets the surface's media for it.
bool passes_surface(inout Surface surface, inout Query query) {
    bool passes = false;
    if (HAS_ALPHA) {
        passes = query.cuts < MAX_CUT_SURFACES && is_cut_away(surface, query.whole);
        query.cuts += passes ? 1u : 0u;
        surface.media = uvec2(query.ray.medium);
    }
    if (HAS_INTERFACES) {
        if (!passes) {
            passes = only_bounds_media(surface);
            set_media(surface, query.ray.medium);
        }
    }
    return passes;
}

// Share of light that is left of a query's ray up to t on `whole`.
vec3 transmittance_to(Query query, float t) {
    float way = t * length(query.ray.direction);
    Hue hue = no_hue();
    if (HAS_DISPERSION) {
        hue = hue_along(query.split, query.passed + t);
    }
    vec3 kept = transmittance(query.ray.medium, way, hue);
    if (HAS_INTERFACES) {
        kept *= query.kept;
    }
    return kept;
}

// Share of light that media leave on the part of a ray that an answer is about.
vec3 transmittance_of(Query query, Hit hit) {
    float t = hit.t;
    if (HAS_INTERFACES) {
        t -= query.passed;
    }
    return transmittance_to(query, query.ray.is_endless ? INFINITY_T : t);
}

// Goes on behind a surface that the ray passes. Returns whether another walk is needed.
bool pass_surface(inout Query query, inout Hit hit) {
    bool passes = hit.primitive != NONE;
    // As above, a loop of one round.
    for (bool looks = passes; looks; looks = false) {
        Surface surface = surface_at(query.whole, hit);
        passes = passes_surface(surface, query);
        if (passes) {
            Ray ray = spawn_ray(surface, query.whole.direction, true);
            ray.is_endless = query.ray.is_endless;
            float passed = dot(ray.origin - query.begin, ray.direction) / dot(ray.direction, ray.direction);
            vec3 kept = vec3(1.0);
            if (HAS_INTERFACES) {
                kept = transmittance_to(query, hit.t);
            }
            query = Query(ray, query.end - passed, query.any_hit, ray, no_hit(query.end - passed), query.begin,
                          passed, query.cuts, query.end, kept, query.split);
        }
    }
    if (!passes) {
        hit.t += query.passed;
    }
    return passes;
}

// Decides, after a walk that found `hit`, whether another walk is needed. If not, `hit` is the answer.
bool is_answered(inout Query query, inout Hit hit) {
    bool is_open = false;
    if (HAS_CONTACTS) {
        is_open = !query.any_hit && look_for_preceding(query, hit);
    }
    if (HAS_PASSABLE) {
        is_open = is_open || pass_surface(query, hit);
    }
    return !is_open;
}
