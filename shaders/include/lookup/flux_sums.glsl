// The flux of an iteration: fixed-point sums per pixel. Each channel has a buffer of its own, since a device may bind no
// more than 128 MiB. Where HAS_ROUGH_GATHER, as many sums of rough points follow those of visible points: of photons'
// weights times the BSDF, the eye path's throughput and a factor for the area of the disc (gather_rough.comp). They are
// two's complements, since the throughput has the sign of the pixel filter.
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

// Sums of 0 or more, in units of the mean flux of a photon.
vec3 to_positive_floats(Flux flux) {
    vec3 sum = vec3(0.0);
    for (uint channel = 0u; channel < 3u; channel++) {
        sum[channel] = from_fixed(flux.low[channel], flux.high[channel]);
    }
    return sum;
}

// The opposite number of a sum.
Flux opposite(Flux flux) {
    return Flux(~flux.low + 1u, ~flux.high + mix(uvec3(0u), uvec3(1u), equal(flux.low, uvec3(0u))));
}

// A sum that may be below 0.
vec3 to_signed_floats(Flux flux) {
    bvec3 is_negative = greaterThanEqual(flux.high, uvec3(0x80000000u));
    Flux other = opposite(flux);
    Flux size = Flux(mix(flux.low, other.low, is_negative), mix(flux.high, other.high, is_negative));
    return mix(to_positive_floats(size), -to_positive_floats(size), is_negative);
}

// The flux of photons in units of the mean flux of a photon.
vec3 to_floats(Flux flux) {
    if (HAS_DISPERSION) {
        return to_signed_floats(flux);
    }
    return to_positive_floats(flux);
}
