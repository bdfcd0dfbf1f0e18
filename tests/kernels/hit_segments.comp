// hit_segments: intersects one ray in unit space with one segment of a profile per invocation, by the
// classical solver.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "kernel/invocation.glsl"
#include "scene/scene.glsl"
#include "geometry/intersect.glsl"

struct SegmentRay {
    vec3 origin;
    uint segment;
    vec3 direction;
    float t_max;
};

struct SegmentHit {
    float t;
    uint primitive; // a piece, or NONE
    float x;
    float pad;
};

layout(std430, set = 1, binding = 0) readonly buffer RayBlock { SegmentRay data[]; } rays;
layout(std430, set = 1, binding = 1) buffer HitBlock { SegmentHit data[]; } hits;

void main() {
    uint i = invocation_index();
    if (i >= rays.data.length()) {
        return;
    }
    SegmentRay ray = rays.data[i];
    SegmentHit hit = SegmentHit(ray.t_max, NONE, 0.0, 0.0);
    intersect_segment(ray.segment, ray.origin, ray.direction, 0.0, hit.t, hit.x, hit.primitive);
    hits.data[i] = hit;
}
