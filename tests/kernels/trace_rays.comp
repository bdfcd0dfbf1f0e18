// trace_rays: traces rays through the hierarchy, for the nearest hit and for any hit.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "kernel/invocation.glsl"
#include "scene/scene.glsl"
#include "geometry/intersect.glsl"

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

layout(std430, set = 1, binding = 0) readonly buffer RayBlock { TracedRay data[]; } rays;
layout(std430, set = 1, binding = 1) buffer HitBlock { TracedHit data[]; } hits;
layout(std430, set = 1, binding = 2) buffer AnyBlock { uint data[]; } any_hits;

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
