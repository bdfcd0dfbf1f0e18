// simulate: runs many iterations of one pixel, as the update pass adds them to its sum and its radius.
#version 460
#include "kernel/invocation.glsl"
#include "lookup/records.glsl"
#include "lookup/shrink.glsl"
#include "math/sum.glsl"
#include "scene/constants.glsl"

TEXELS(uvec4, iterations) // photons; bits of radiance
BUFFER(float, alphas)
UPDATED_TEXELS(PixelState, states)
UPDATED_TEXELS(uvec4, sums)

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
