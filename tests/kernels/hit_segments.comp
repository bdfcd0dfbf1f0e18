// hit_segments: intersects one ray in unit space with one segment of a profile per invocation, by the
// classical solver.
#version 460
#include "kernel/invocation.glsl"
#include "revolution/newton.glsl"
#include "scene/constants.glsl"

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

BUFFER(SegmentRay, rays)
UPDATED_BUFFER(SegmentHit, hits)

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
