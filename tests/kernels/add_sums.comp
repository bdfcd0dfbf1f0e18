// add_sums: adds pairs of 128-bit sums.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "kernel/invocation.glsl"
#include "math/sum.glsl"

layout(std430, set = 1, binding = 0) readonly buffer LeftBlock { uvec4 data[]; } left;
layout(std430, set = 1, binding = 1) readonly buffer RightBlock { uvec4 data[]; } right;
layout(std430, set = 1, binding = 2) buffer TotalBlock { uvec4 data[]; } totals;

void main() {
    uint i = invocation_index();
    if (i < left.data.length()) {
        totals.data[i] = add_exactly(left.data[i], right.data[i]);
    }
}
