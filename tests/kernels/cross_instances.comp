// cross_instances: traces rays to surfaces through the hierarchy, and second rays that leave from there.
#version 460
#include "geometry/alpha.glsl"
#include "geometry/contact.glsl"
#include "geometry/hit.glsl"
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

void main() {
    uint i = invocation_index();
    if (i >= rays.data.length()) {
        return;
    }
    Ray ray = free_ray(rays.data[i].origin, rays.data[i].direction);
    Hit hit = intersect(ray);
    if (hit.primitive == NONE) {
        crossings.data[i] = Crossing(vec3(0.0), -1.0, vec3(0.0), 0.0, vec3(0.0), -1.0);
        return;
    }
    Surface surface = surface_at(ray, hit);
    vec3 leaving = rays.data[i].leaving;
    leaving = dot(leaving, surface.normal) < 0.0 ? -leaving : leaving;
    Hit again = intersect(free_ray(offset_origin(surface, leaving), leaving));
    float t_again = again.primitive == NONE ? -1.0 : again.t;
    crossings.data[i] =
        Crossing(surface.position, hit.t, surface.normal, surface.error, surface.shading_normal, t_again);
}
