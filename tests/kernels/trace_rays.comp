// trace_rays: traces rays through the hierarchy, for the nearest hit, for any hit, or for both.
#version 460
#include "geometry/contact.glsl"
#include "geometry/hit.glsl"
#include "geometry/query.glsl"
#include "kernel/invocation.glsl"
#include "scene/features.glsl"

struct TracedRay {
    vec3 origin;
    float t_max;
    vec3 direction;
    float pad0;
};

struct TracedHit {
    vec2 barycentric;
    float t;
    uint primitive; // or NONE
};

// What is asked about each ray; a sum of these.
export const uint ASKS_NEAREST = 1u; // its nearest hit
export const uint ASKS_ANY = 2u;     // whether there is any

// Texels, as the passes' own arrays: on a CPU, buffers would take as long as a short walk.
TEXELS(TracedRay, rays)
STORED_TEXELS(TracedHit, hits)
STORED_TEXELS(uint, any_hits)

layout(push_constant) uniform Push {
    uint count; // of rays
    uint asks;  // ASKS_NEAREST, ASKS_ANY or both
};

// Rays number, number + stride, and so on; of each first the nearest hit, then any hit.
struct Work {
    uint number;
    uint stride;
    bool any_hit;
    bool waits; // for an answer
};

#include "geometry/trace.glsl"

Query query_of_ray(Work work) {
    TracedRay traced = rays_at(work.number);
    Query query = query_of(free_ray(traced.origin, traced.direction), traced.t_max, work.any_hit);
    if (HAS_PASSABLE) {
        query.any_hit = false; // surfaces are passed one after the other
    }
    return query;
}

bool next_query(inout Work work, inout Query query, Hit hit) {
    bool asks_both = asks == (ASKS_NEAREST | ASKS_ANY);
    if (work.waits && work.any_hit) {
        store_any_hits(work.number, hit.primitive);
    } else if (work.waits) {
        store_hits(work.number, TracedHit(hit.barycentric, hit.t, hit.primitive));
    }
    work.number += work.waits && (work.any_hit || !asks_both) ? work.stride : 0u;
    work.any_hit = asks_both ? work.waits && !work.any_hit : asks == ASKS_ANY;
    work.waits = true;
    bool has_ray = work.number < count;
    if (has_ray) {
        query = query_of_ray(work);
    }
    return has_ray;
}

void main() {
    uint stride = gl_NumWorkGroups.x * gl_NumWorkGroups.y * gl_WorkGroupSize.x;
    Work work = Work(invocation_index(), stride, false, false);
    trace_queries(work, work.number < count);
}
