// add_sums: adds pairs of 128-bit sums.
#version 460
#include "kernel/invocation.glsl"
#include "math/sum.glsl"

BUFFER(uvec4, left)
BUFFER(uvec4, right)
UPDATED_BUFFER(uvec4, totals)

void main() {
    uint i = invocation_index();
    if (i < left.data.length()) {
        totals.data[i] = add_exactly(left.data[i], right.data[i]);
    }
}
