// Sums of the photons that a visible point gathers, in fixed point (flux.glsl).
#include "kernel/counters.glsl"
#include "lookup/flux_counts.glsl"
#include "lookup/flux_sums.glsl"

struct Gathered {
    uvec3 low; // red, green, blue
    uvec3 high;
    uint count; // number of photons
    uint bits;  // if the top bit is set, a sum may have overflowed
    uint inner; // number of photons on the inner half of the disc, for radii from the data
};

Gathered nothing_gathered() {
    return Gathered(uvec3(0u), uvec3(0u), 0u, 0u, 0u);
}

// Adds a photon if it is on the disc.
void gather_photon(inout Gathered sum, uvec3 low, uvec3 high, bool on_disc) {
    low = on_disc ? low : uvec3(0u);
    high = on_disc ? high : uvec3(0u);
    uvec3 before = sum.high;
    sum.low += low;
    sum.high += high + mix(uvec3(0u), uvec3(1u), lessThan(sum.low, low));
    uvec3 bits = sum.high;
    if (HAS_DISPERSION) {
        bits = (before ^ sum.high) & (high ^ sum.high);
    }
    sum.bits |= bits.x | bits.y | bits.z;
    sum.count += on_disc ? 1u : 0u;
}

// Adds to the flux of a pixel, which no other invocation changes.
void add_to_pixel(Gathered sum, uint pixel) {
    Flux before = load_flux(pixel);
    uvec3 low = before.low + sum.low;
    uvec3 high = sum.high + mix(uvec3(0u), uvec3(1u), lessThan(low, sum.low));
    uvec3 total = before.high + high;
    store_flux(pixel, Flux(low, total));
    uint at = place_of_count(pixel);
    flux_counts.data[at] += sum.count;
    if (HAS_DATA_RADII) {
        flux_counts.data[at + 1u] += sum.inner;
    }
    uint bits = sum.bits;
    for (uint channel = 0u; channel < 3u; channel++) {
        bits |= overflow_of(before.high[channel], high[channel], total[channel]);
    }
    if (bits >= 0x80000000u) {
        atomicAdd(counters.value.saturated, 1u);
    }
}
