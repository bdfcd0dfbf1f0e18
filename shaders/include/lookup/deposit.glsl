// A photon's weight on a visible point, added by many photons at once.
#include "kernel/counters.glsl"
#include "lookup/flux_sums.glsl"

// The low word of a sum was `before`: what is to be added to the high one.
uint carried(uint before, uvec2 fixed_point) {
    return fixed_point.y + (before + fixed_point.x < before ? 1u : 0u);
}

void check_sum(uint before, uint high) {
    if (before + high < before) {
        atomicAdd(counters.value.saturated, 1u);
    }
}

// Functions cannot take a buffer.
#define ADD_CHANNEL(sums, at, fixed_point) { \
    uint high = carried(atomicAdd(sums.data[at], fixed_point.x), fixed_point); \
    if (high > 0u) { \
        check_sum(atomicAdd(sums.data[at + 1u], high), high); \
    } \
}

void deposit(uint pixel, uvec2 red, uvec2 green, uvec2 blue) {
    uint at = 2u * pixel;
    ADD_CHANNEL(flux_red, at, red)
    ADD_CHANNEL(flux_green, at, green)
    ADD_CHANNEL(flux_blue, at, blue)
    atomicAdd(flux_counts.data[pixel], 1u);
}
