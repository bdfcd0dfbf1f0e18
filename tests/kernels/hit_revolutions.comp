// hit_revolutions: traces rays through the hierarchy, and scatters each at the surface that it hits.
#version 460
#include "geometry/contact.glsl"
#include "geometry/hit.glsl"
#include "geometry/query.glsl"
#include "geometry/quadric.glsl"
#include "geometry/surface.glsl"
#include "geometry/surface_point.glsl"
#include "kernel/invocation.glsl"
#include "material/bsdf.glsl"
#include "scene/constants.glsl"
#include "scene/primitives.glsl"
#include "scene/scene.glsl"

struct BodyRay {
    vec3 origin;
    float t_min; // not used here
    vec3 direction;
    float t_max; // not used here
};

struct Met {
    vec3 position;
    float error;
    vec3 normal;
    float t;
    vec2 uv;
    float x;
    uint primitive; // or NONE
    vec3 next_origin;
    uint transmitted;
    vec3 next_direction; // of the scattered ray
    float pad0;
};

BUFFER(BodyRay, rays)
UPDATED_BUFFER(Met, met)

struct Work {
    uint number;
    bool waits; // for the answer
};

#include "geometry/trace.glsl"

bool next_query(inout Work work, inout Query query, Hit hit) {
    uint i = work.number;
    if (!work.waits) {
        query = nearest_hit(free_ray(rays.data[i].origin, rays.data[i].direction));
        work.waits = true;
        return true;
    }
    if (hit.primitive == NONE) {
        met.data[i] = Met(vec3(0.0), 0.0, vec3(0.0), -1.0, vec2(0.0), 0.0, NONE, vec3(0.0), 0u, vec3(0.0), 0.0);
        return false;
    }
    Ray ray = query.ray;
    Surface surface = surface_at(ray, hit);
    uint piece = hit.primitive & INDEX_MASK;
    uint body = revolution_pieces_at(piece).body;
    vec2 around = transform_point(revolutions_at(body).unit_from_render, surface.position).xy;
    // With the largest random number, light is refracted unless reflection is total.
    Scatter scattered = scatter(materials_at(surface.material), -ray.direction, surface.shading_normal, vec3(0.0),
                                1.0 - ROUNDING, vec2(0.0), RADIANCE);
    met.data[i] = Met(surface.position, surface.error, surface.normal, hit.t,
                      revolution_uv(piece, hit.barycentric.x, around), hit.barycentric.x, hit.primitive,
                      offset_origin(surface, scattered.wi), scattered.eta != 1.0 ? 1u : 0u, scattered.wi, 0.0);
    return false;
}

void main() {
    Work work = Work(invocation_index(), false);
    trace_queries(work, work.number < rays.data.length());
}
