// trace_rays: traces rays through the hierarchy, for the nearest hit and for any hit.
#version 460
#include "geometry/contact.glsl"
#include "geometry/hit.glsl"
#include "geometry/query.glsl"
#include "kernel/invocation.glsl"

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

BUFFER(TracedRay, rays)
UPDATED_BUFFER(TracedHit, hits)
UPDATED_BUFFER(uint, any_hits)

// Rays number, number + stride, and so on; of each first the nearest hit, then any hit.
struct Work {
    uint number;
    uint stride;
    bool any_hit;
    bool waits; // for an answer
};

#include "geometry/trace.glsl"

Query query_of_ray(Work work) {
    Ray ray = free_ray(rays.data[work.number].origin, rays.data[work.number].direction);
    return query_of(ray, rays.data[work.number].t_max, work.any_hit);
}

bool next_query(inout Work work, inout Query query, Hit hit) {
    if (work.waits && work.any_hit) {
        any_hits.data[work.number] = hit.primitive;
        work.number += work.stride;
    } else if (work.waits) {
        hits.data[work.number] = TracedHit(hit.barycentric, hit.t, hit.primitive);
    }
    work.any_hit = work.waits && !work.any_hit;
    work.waits = true;
    bool has_ray = work.number < rays.data.length();
    if (has_ray) {
        query = query_of_ray(work);
    }
    return has_ray;
}

void main() {
    uint stride = gl_NumWorkGroups.x * gl_NumWorkGroups.y * gl_WorkGroupSize.x;
    Work work = Work(invocation_index(), stride, false, false);
    trace_queries(work, work.number < rays.data.length());
}
