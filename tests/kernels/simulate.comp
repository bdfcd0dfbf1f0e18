// simulate: runs many iterations of one pixel, as the update pass adds them to its sum and its radius.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "kernel/invocation.glsl"
#include "scene/types.glsl"
#include "math/sum.glsl"
#include "lookup/shrink.glsl"

TEXELS(1, 0, uvec4, iterations) // photons; bits of radiance
layout(std430, set = 1, binding = 1) readonly buffer AlphaBlock { float data[]; } alphas;
UPDATED_TEXELS(1, 2, PixelState, states)
UPDATED_TEXELS(1, 3, uvec4, sums)

// Number of iterations given for each pixel; they are repeated.
const uint PERIOD = 2500u;
// Rounds of the loop: fewer than the 65,535 that llvmpipe allows an invocation.
const uint ROUNDS = 62500u;

void main() {
    uint pixel = invocation_index();
    if (pixel >= alphas.data.length()) {
        return;
    }
    PixelState state = states_at(pixel);
    uvec4 sum = sums_at(pixel);
    for (uint i = 0u; i < ROUNDS; i++) {
        uvec4 iteration = iterations_at(pixel * PERIOD + i % PERIOD);
        sum = add_exactly(sum, to_term(uintBitsToFloat(iteration.y)));
        if (iteration.x > 0u) {
            shrink_radius(state, iteration.x, alphas.data[pixel]);
        }
    }
    store_states(pixel, state);
    store_sums(pixel, sum);
}
