// follow_photons: follows photons as the photon pass does, and stores the rays of their paths. Those of an
// invocation are `stride` apart, in the order in which it traces them.
#version 460
#include "geometry/contact.glsl"
#include "geometry/hit.glsl"
#include "geometry/query.glsl"
#include "geometry/surface.glsl"
#include "geometry/surface_point.glsl"
#include "kernel/invocation.glsl"
#include "light/emission.glsl"
#include "material/bsdf.glsl"
#include "material/layers.glsl"
#include "material/material.glsl"
#include "math/random.glsl"
#include "scene/constants.glsl"
#include "scene/features.glsl"
#include "scene/materials.glsl"
#include "scene/scene.glsl"

struct TracedRay {
    vec3 origin;
    float t_max;
    vec3 direction;
    float pad0;
};

STORED_TEXELS(TracedRay, rays)

layout(push_constant) uniform Push {
    uint count; // of rays
};

struct Work {
    uint number;  // of its next ray
    uint stride;
    uint photon;  // number of the photon to begin next
    bool alive;   // it follows a path
    Ray ray;      // of that path
    vec3 weight;  // of that path
    uint depth;   // segments of that path
    Random random;
};

#include "geometry/trace.glsl"

// Scatters a photon at a surface. Returns false if Russian roulette ends the path.
bool bounce(inout Work work, Surface surface) {
    Material material = material_at(surface);
    vec3 wo = -work.ray.direction;
    uint pair = 3u + 2u * work.depth;
    vec2 u = random_pair(work.random, pair + 1u);
    if (HAS_LAYERS) {
        material = choose_lobe(material, abs(dot(wo, surface.shading_normal)), u.x);
    }
    vec2 u_direction = random_pair(work.random, pair);
    Scatter scattered = scatter(material, wo, surface.shading_normal, surface.tangent, u.x, u_direction, FLUX);
    float before = max(work.weight.x, max(work.weight.y, work.weight.z));
    work.weight *= scattered.weight;
    float after = max(work.weight.x, max(work.weight.y, work.weight.z));
    work.weight *= after < before ? before / max(after, 1.0e-30) : 1.0;
    work.ray = spawn_ray(surface, scattered.wi, crosses_surface(surface, wo, scattered.wi));
    return u.y * before < after;
}

bool next_query(inout Work work, inout Query query, Hit hit) {
    if (work.alive) {
        bool goes_on = hit.primitive != NONE && work.depth + 1u < scene.max_depth;
        if (goes_on) {
            goes_on = bounce(work, surface_at(work.ray, hit));
        }
        work.depth++;
        work.alive = goes_on;
    }
    if (!work.alive) {
        work.random = Random(~scene.seed, work.photon);
        Emission emission = emit(emission_numbers(work.random));
        work.ray = emission.ray;
        work.weight = emission.weight;
        work.depth = 0u;
        work.photon += work.stride;
        work.alive = true;
    }
    bool has_ray = work.number < count;
    if (has_ray) {
        store_rays(work.number, TracedRay(work.ray.origin, INFINITY_T, work.ray.direction, 0.0));
        query = nearest_hit(work.ray);
    }
    work.number += work.stride;
    return has_ray;
}

void main() {
    uint number = invocation_index();
    uint stride = gl_NumWorkGroups.x * gl_NumWorkGroups.y * gl_WorkGroupSize.x;
    Ray none = free_ray(vec3(0.0), vec3(0.0));
    Work work = Work(number, stride, number, false, none, vec3(0.0), 0u, Random(0u, 0u));
    trace_queries(work, number < count);
}
