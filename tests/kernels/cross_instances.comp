// cross_instances: traces rays to surfaces through the hierarchy, and second rays that leave from there.
#version 460
#include "geometry/contact.glsl"
#include "geometry/hit.glsl"
#include "geometry/query.glsl"
#include "geometry/surface.glsl"
#include "geometry/surface_point.glsl"
#include "kernel/invocation.glsl"
#include "scene/constants.glsl"

struct CrossingRay {
    vec3 origin;
    float pad0;
    vec3 direction;
    float pad1;
    vec3 leaving; // direction of the second ray, on either side
    float pad2;
};

struct Crossing {
    vec3 position;
    float t;       // negative if nothing is met
    vec3 normal;
    float error;
    vec3 shading_normal;
    float t_again; // of the second ray, on the side of the surface's normal; negative if none
};

BUFFER(CrossingRay, rays)
UPDATED_BUFFER(Crossing, crossings)

struct Work {
    uint number;
    uint asked; // number of queries
};

#include "geometry/trace.glsl"

bool next_query(inout Work work, inout Query query, Hit hit) {
    uint i = work.number;
    work.asked++;
    if (work.asked == 1u) {
        query = nearest_hit(free_ray(rays.data[i].origin, rays.data[i].direction));
        return true;
    }
    if (work.asked == 3u) {
        crossings.data[i].t_again = hit.primitive == NONE ? -1.0 : hit.t;
        return false;
    }
    if (hit.primitive == NONE) {
        crossings.data[i] = Crossing(vec3(0.0), -1.0, vec3(0.0), 0.0, vec3(0.0), -1.0);
        return false;
    }
    Surface surface = surface_at(query.ray, hit);
    vec3 leaving = rays.data[i].leaving;
    leaving = dot(leaving, surface.normal) < 0.0 ? -leaving : leaving;
    crossings.data[i] = Crossing(surface.position, hit.t, surface.normal, surface.error, surface.shading_normal, -1.0);
    query = nearest_hit(free_ray(offset_origin(surface, leaving), leaving));
    return true;
}

void main() {
    Work work = Work(invocation_index(), 0u);
    trace_queries(work, work.number < rays.data.length());
}
