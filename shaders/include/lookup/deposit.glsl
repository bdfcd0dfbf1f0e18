// Adds photons to the flux of visible points atomically.
#include "kernel/counters.glsl"
#include "lookup/flux_counts.glsl"
#include "lookup/flux_sums.glsl"

// What to add to the high word of a sum whose low word was `before`.
uint high_word_to_add(uint before, uvec2 fixed_point) {
    return fixed_point.y + (before + fixed_point.x < before ? 1u : 0u);
}

// Counts an overflow of the high word.
void check_sum(uint before, uint high) {
    if (overflow_of(before, high, before + high) >= 0x80000000u) {
        atomicAdd(counters.value.saturated, 1u);
    }
}

// A macro, since GLSL functions cannot take a buffer.
#define ADD_CHANNEL(sums, at, fixed_point) { \
    uint high = high_word_to_add(atomicAdd(sums.data[at], fixed_point.x), fixed_point); \
    if (high > 0u) { \
        check_sum(atomicAdd(sums.data[at + 1u], high), high); \
    } \
}

// Adds a photon to the flux of a pixel; `inner` says whether it is on the inner half of the disc.
void deposit(uint pixel, uvec2 red, uvec2 green, uvec2 blue, bool inner) {
    uint at = 2u * pixel;
    ADD_CHANNEL(flux_red, at, red)
    ADD_CHANNEL(flux_green, at, green)
    ADD_CHANNEL(flux_blue, at, blue)
    uint count = place_of_count(pixel);
    atomicAdd(flux_counts.data[count], 1u);
    if (HAS_DATA_RADII) {
        if (inner) {
            atomicAdd(flux_counts.data[count + 1u], 1u);
        }
    }
}
