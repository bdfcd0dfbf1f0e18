// What rough points have gathered: sums per pixel, in the units of flux.glsl, of photons' weights times the BSDF, the eye
// path's throughput and a factor for the area of the disc (gather_rough.comp). They are two's complements, since the
// throughput has the sign of the pixel filter.
#include "lookup/flux.glsl"
#include "lookup/flux_sums.glsl"

// The opposite number of a sum.
Flux opposite(Flux flux) {
    return Flux(~flux.low + 1u, ~flux.high + mix(uvec3(0u), uvec3(1u), equal(flux.low, uvec3(0u))));
}

// A sum that may be below 0.
vec3 to_signed_floats(Flux flux) {
    bvec3 is_negative = greaterThanEqual(flux.high, uvec3(0x80000000u));
    Flux other = opposite(flux);
    Flux size = Flux(mix(flux.low, other.low, is_negative), mix(flux.high, other.high, is_negative));
    return mix(to_floats(size), -to_floats(size), is_negative);
}
