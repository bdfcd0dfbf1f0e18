// A photon's weight on a visible point, added by many photons at once.
// The kernel binds flux_low, flux_high and counters.

#include "flux.glsl"
#include "disc.glsl"

void add_channel(uint index, uvec2 fixed_point) {
    uint low = atomicAdd(flux_low.data[index], fixed_point.x);
    uint high = fixed_point.y + (low + fixed_point.x < low ? 1u : 0u);
    if (high > 0u) {
        uint before = atomicAdd(flux_high.data[index], high);
        if (before + high < before) {
            atomicAdd(counters.value.saturated, 1u);
        }
    }
}

void deposit(uint pixel, uvec2 red, uvec2 green, uvec2 blue) {
    add_channel(4u * pixel, red);
    add_channel(4u * pixel + 1u, green);
    add_channel(4u * pixel + 2u, blue);
    atomicAdd(flux_low.data[4u * pixel + 3u], 1u);
}
