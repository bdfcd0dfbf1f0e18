// update: turn an iteration's flux into radiance, add it to the image, and shrink the
// pixel's radius.
// One invocation per pixel. Reads visible_*. Updates pixel_states and sum_* (exact, in
// units of push.unit); clears flux_low, flux_high.
//
// Hachisuka and Jensen 2009, eq. 6 to 9, scale the flux of all earlier iterations when the
// radius shrinks: tau' / r'^2 = (tau + phi) / r^2. So tau / r^2 is the sum of phi / r^2 over
// iterations, each with the radius that it had, and the image is the mean of the images of
// its iterations, whatever made their radii (as Knaus and Zwicker 2011, section 3, say it).
#version 460
#extension GL_GOOGLE_include_directive : require
#include "invocation.glsl"
#include "types.glsl"
#include "flux.glsl"
#include "sum.glsl"

layout(std430, set = 1, binding = 0) readonly buffer PositionBlock { vec4 data[]; } visible_positions; // w: squared radius
layout(std430, set = 1, binding = 1) readonly buffer ThroughputBlock { vec4 data[]; } visible_throughputs;
layout(std430, set = 1, binding = 2) readonly buffer RadianceBlock { vec4 data[]; } visible_radiances;
layout(std430, set = 1, binding = 3) buffer FluxLowBlock { uint data[]; } flux_low; // r, g, b, count of each pixel
layout(std430, set = 1, binding = 4) buffer FluxHighBlock { uint data[]; } flux_high; // r, g, b, unused
layout(std430, set = 1, binding = 5) buffer PixelStateBlock { PixelState data[]; } pixel_states;
layout(std430, set = 1, binding = 6) buffer SumRedBlock { uvec4 data[]; } sum_red;
layout(std430, set = 1, binding = 7) buffer SumGreenBlock { uvec4 data[]; } sum_green;
layout(std430, set = 1, binding = 8) buffer SumBlueBlock { uvec4 data[]; } sum_blue;
layout(std430, set = 1, binding = 9) buffer SumSecondBlock { uvec4 data[]; } sum_second; // luminance of the second half
layout(std430, set = 1, binding = 10) buffer CounterBlock { Counters value; } counters;

layout(push_constant) uniform Push {
    vec3 luminance;      // what each channel adds to it
    uint pixel_count;
    float alpha;         // share of an iteration's photons that is kept
    float per_unit;      // one over the unit of the sums, m^2 sr/W
    float flux_scale;    // mean flux of a photon over pi and the unit
    uint half_of_rounds; // 0 or 1
};

// Reads a pixel's flux and count, and clears them.
vec3 take_flux(uint pixel, out uint count) {
    count = flux_low.data[4u * pixel + 3u];
    vec3 flux = vec3(0.0);
    if (count > 0u) {
        flux_low.data[4u * pixel + 3u] = 0u;
        for (uint channel = 0u; channel < 3u; channel++) {
            uint i = 4u * pixel + channel;
            flux[channel] = from_fixed(flux_low.data[i], flux_high.data[i]);
            flux_low.data[i] = 0u;
            flux_high.data[i] = 0u;
        }
    }
    return flux;
}

// The shrinking of a squared radius, and the photons kept: eq. 6 and 7.
void shrink_radius(inout PixelState state, uint count) {
    float photons = float(count);
    float kept = state.photons + alpha * photons;
    state.shrink *= kept / (state.photons + photons);
    state.photons = kept;
}

void main() {
    uint pixel = invocation_index();
    if (pixel >= pixel_count) {
        return;
    }
    uint count;
    vec3 flux = take_flux(pixel, count);
    vec3 radiance = per_unit * visible_radiances.data[pixel].rgb;
    if (count > 0u) {
        float radius2 = visible_positions.data[pixel].w;
        radiance += visible_throughputs.data[pixel].rgb * flux * (flux_scale / radius2);
    }
    if (!all(lessThan(radiance, vec3(MAX_TERM)))) {
        atomicAdd(counters.value.saturated, 1u);
        radiance = mix(vec3(LARGEST_TERM), radiance, lessThan(radiance, vec3(MAX_TERM)));
    }
    sum_red.data[pixel] = add_exactly(sum_red.data[pixel], to_term(radiance.r));
    sum_green.data[pixel] = add_exactly(sum_green.data[pixel], to_term(radiance.g));
    sum_blue.data[pixel] = add_exactly(sum_blue.data[pixel], to_term(radiance.b));

    if (half_of_rounds == 1u) {
        sum_second.data[pixel] = add_exactly(sum_second.data[pixel], to_term(dot(radiance, luminance)));
    }

    if (count > 0u) {
        PixelState state = pixel_states.data[pixel];
        shrink_radius(state, count);
        pixel_states.data[pixel] = state;
    }
}
