// trace_rays: traces rays through the hierarchy, for the nearest hit and for any hit.
#version 460
#include "geometry/contact.glsl"
#include "geometry/hit.glsl"
#include "geometry/intersect.glsl"
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

void main() {
    uint i = invocation_index();
    if (i >= rays.data.length()) {
        return;
    }
    Ray ray = free_ray(rays.data[i].origin, rays.data[i].direction);
    Hit hit = traverse(ray, rays.data[i].t_max, false);
    hits.data[i] = TracedHit(hit.barycentric, hit.t, hit.primitive);
    any_hits.data[i] = traverse(ray, rays.data[i].t_max, true).primitive;
}
