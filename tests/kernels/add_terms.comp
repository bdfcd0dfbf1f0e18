// add_terms: converts radiances to terms, and adds each term to a sum.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "kernel/invocation.glsl"
#include "math/sum.glsl"

layout(std430, set = 1, binding = 0) readonly buffer ValueBlock { float data[]; } values;
layout(std430, set = 1, binding = 1) readonly buffer SumBlock { uvec4 data[]; } sums;
layout(std430, set = 1, binding = 2) buffer TermBlock { uvec4 data[]; } terms;
layout(std430, set = 1, binding = 3) buffer TotalBlock { uvec4 data[]; } totals;

void main() {
    uint i = invocation_index();
    if (i >= values.data.length()) {
        return;
    }
    terms.data[i] = to_signed_term(values.data[i]);
    totals.data[i] = add_exactly(sums.data[i], terms.data[i]);
}
