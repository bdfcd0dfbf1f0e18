// What a visible point gathers from photons: sums of fixed-point weights, and their number.
// The kernel binds flux_low, flux_high and counters.
#include "flux.glsl"
#include "disc.glsl"

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
    uint at = 4u * pixel;
    bool saturated = sum.bits >= 0x80000000u;
    for (uint channel = 0u; channel < 3u; channel++) {
        uint low = flux_low.data[at + channel] + sum.low[channel];
        uint high = sum.high[channel] + (low < sum.low[channel] ? 1u : 0u);
        uint total = flux_high.data[at + channel] + high;
        flux_low.data[at + channel] = low;
        flux_high.data[at + channel] = total;
        saturated = saturated || total < high;
    }
    flux_low.data[at + 3u] += sum.count;
    if (saturated) {
        atomicAdd(counters.value.saturated, 1u);
    }
}
