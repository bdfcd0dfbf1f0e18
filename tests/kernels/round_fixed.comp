// round_fixed: converts weights to fixed point and back.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "kernel/invocation.glsl"
#include "lookup/flux.glsl"

layout(std430, set = 1, binding = 0) readonly buffer WeightBlock { float data[]; } weights;
layout(std430, set = 1, binding = 1) buffer FixedBlock { uvec2 data[]; } fixed_points;
layout(std430, set = 1, binding = 2) buffer BackBlock { float data[]; } back;

void main() {
    uint i = invocation_index();
    if (i >= weights.data.length()) {
        return;
    }
    uvec2 fixed_point = to_fixed(weights.data[i]);
    fixed_points.data[i] = fixed_point;
    back.data[i] = from_fixed(fixed_point.x, fixed_point.y);
}
