// update: fold an iteration's flux and count into the pixel's running estimate.
// One invocation per pixel. Reads visible_throughputs. Updates pixel_flux (flux in mean
// photon fluxes times bsdf, squared radius), pixel_photons; clears flux_low, flux_high.
// Hachisuka and Jensen 2009, eq. 6 to 8.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "invocation.glsl"
#include "flux.glsl"

layout(std430, set = 1, binding = 0) readonly buffer ThroughputBlock { vec4 data[]; } visible_throughputs;
layout(std430, set = 1, binding = 1) buffer FluxLowBlock { uint data[]; } flux_low; // r, g, b, count of each pixel
layout(std430, set = 1, binding = 2) buffer FluxHighBlock { uint data[]; } flux_high; // r, g, b, unused
layout(std430, set = 1, binding = 3) buffer PixelFluxBlock { vec4 data[]; } pixel_flux;
layout(std430, set = 1, binding = 4) buffer PixelPhotonBlock { float data[]; } pixel_photons;

layout(push_constant) uniform Push {
    uint pixel_count;
    float alpha; // share of an iteration's photons that is kept
};

void main() {
    uint pixel = invocation_index();
    if (pixel >= pixel_count) {
        return;
    }
    uint count = flux_low.data[4u * pixel + 3u];
    if (count == 0u) {
        return;
    }
    vec3 flux;
    for (uint channel = 0u; channel < 3u; channel++) {
        uint i = 4u * pixel + channel;
        flux[channel] = from_fixed(flux_low.data[i], flux_high.data[i]);
        flux_low.data[i] = 0u;
        flux_high.data[i] = 0u;
    }
    flux_low.data[4u * pixel + 3u] = 0u;
    float before = pixel_photons.data[pixel];
    float photons = float(count);
    float after = before + alpha * photons;
    float shrink = after / (before + photons);
    vec4 estimate = pixel_flux.data[pixel];
    pixel_flux.data[pixel] = vec4((estimate.rgb + visible_throughputs.data[pixel].rgb * flux) * shrink, estimate.w * shrink);
    pixel_photons.data[pixel] = after;
}
