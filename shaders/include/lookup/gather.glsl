// What a visible point gathers from photons: sums of fixed-point weights, and their number.
#include "kernel/counters.glsl"
#include "lookup/flux_sums.glsl"

struct Gathered {
    uvec3 low; // red, green, blue
    uvec3 high;
    uint count;
    uint bits; // that any high word has had: with the top one, a sum may have passed its end
};

Gathered nothing_gathered() {
    return Gathered(uvec3(0u), uvec3(0u), 0u, 0u);
}

void gather(inout Gathered sum, uvec3 low, uvec3 high, bool wanted) {
    low = wanted ? low : uvec3(0u);
    high = wanted ? high : uvec3(0u);
    sum.low += low;
    sum.high += high + mix(uvec3(0u), uvec3(1u), lessThan(sum.low, low));
    sum.bits |= sum.high.x | sum.high.y | sum.high.z;
    sum.count += wanted ? 1u : 0u;
}

// Adds to a pixel's sums, which no other invocation touches.
void keep(Gathered sum, uint pixel) {
    Flux before = load_flux(pixel);
    uvec3 low = before.low + sum.low;
    uvec3 high = sum.high + mix(uvec3(0u), uvec3(1u), lessThan(low, sum.low));
    uvec3 total = before.high + high;
    store_flux(pixel, Flux(low, total));
    flux_counts.data[pixel] += sum.count;
    if (sum.bits >= 0x80000000u || any(lessThan(total, high))) {
        atomicAdd(counters.value.saturated, 1u);
    }
}
