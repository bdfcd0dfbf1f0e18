// The flux of an iteration: fixed-point sums per pixel. Each channel has a buffer of its own, since a device may bind no
// more than 128 MiB. Where HAS_ROUGH_GATHER, as many sums of rough points follow those of visible points:
// rough_flux.glsl.
#include "lookup/flux.glsl"
#include "scene/features.glsl"

// Low and high word of each pixel.
UPDATED_BUFFER(uint, flux_red)
UPDATED_BUFFER(uint, flux_green)
UPDATED_BUFFER(uint, flux_blue)

// Where flux_counts has the number of a pixel's photons. With radii from the data, the number of those on the inner
// half of the disc follows it.
uint place_of_count(uint pixel) {
    if (HAS_DATA_RADII) {
        return 2u * pixel;
    }
    return pixel;
}

struct Flux {
    uvec3 low; // red, green, blue
    uvec3 high;
};

Flux load_flux(uint pixel) {
    uint at = 2u * pixel;
    return Flux(uvec3(flux_red.data[at], flux_green.data[at], flux_blue.data[at]),
        uvec3(flux_red.data[at + 1u], flux_green.data[at + 1u], flux_blue.data[at + 1u]));
}

void store_flux(uint pixel, Flux flux) {
    uint at = 2u * pixel;
    flux_red.data[at] = flux.low.r;
    flux_red.data[at + 1u] = flux.high.r;
    flux_green.data[at] = flux.low.g;
    flux_green.data[at + 1u] = flux.high.g;
    flux_blue.data[at] = flux.low.b;
    flux_blue.data[at + 1u] = flux.high.b;
}

// The flux in units of the mean flux of a photon.
vec3 to_floats(Flux flux) {
    vec3 sum = vec3(0.0);
    for (uint channel = 0u; channel < 3u; channel++) {
        sum[channel] = from_fixed(flux.low[channel], flux.high[channel]);
    }
    return sum;
}
