// light_layers: the light of an iteration by its ways, its square, and the disc that photons were gathered on, for
// the layers of an image.
//
// Invocations: one per pixel. It runs before the update pass, which clears the flux.
// Reads: visible_radii2, visible_throughputs, visible_radiances, flux_red, flux_green, flux_blue, flux_counts,
//   caustic_red, caustic_green, caustic_blue, counters. Writes: layer_values.
// Units: radiance in the unit 1 / per_unit; radii in render units; densities in a share of the photons per square
//   render unit.
#version 460
#include "kernel/complete.glsl"
#include "kernel/counters.glsl"
#include "kernel/invocation.glsl"
#include "lookup/flux_counts.glsl"
#include "lookup/flux_sums.glsl"
#include "math/sampling.glsl"
#include "scene/constants.glsl"
#include "scene/features.glsl"

TEXELS(float, visible_radii2)
TEXELS(vec4, visible_throughputs)
TEXELS(vec4, visible_radiances)
// As flux_red, and so on, of the photons that are marked: caustic.glsl.
BUFFER(uint, caustic_red)
BUFFER(uint, caustic_green)
BUFFER(uint, caustic_blue)
// What there is for each group of sums (src/image/layers.rs), one group after the other.
STORED_TEXELS(vec4, layer_values)

layout(push_constant) uniform Push {
    vec4 balance[3];    // rows of the white balance
    float per_unit;     // 1 over the unit of the sums, m^2 sr/W
    float flux_scale;   // mean flux of a photon over pi and the unit of the sums
    float per_photon;   // 1 over the photons of an iteration
    uint pixel_count;   // number of pixels: of values of a group
    uint capacity;      // photons that a batch may record
    uint light_group;   // numbers of groups, or NONE
    uint caustic_group; // ..
    uint square_group;  // ..
    float rough_scale;  // as update.comp has it
    uint pad0;          // unused
    uint pad1;          // unused
    uint pad2;          // unused
};

Flux caustic_flux(uint pixel) {
    uint at = 2u * pixel;
    return Flux(uvec3(caustic_red.data[at], caustic_green.data[at], caustic_blue.data[at]),
        uvec3(caustic_red.data[at + 1u], caustic_green.data[at + 1u], caustic_blue.data[at + 1u]));
}

void main() {
    uint pixel = invocation_index();
    if (pixel >= pixel_count || !is_complete(capacity)) {
        return;
    }
    float radius2 = visible_radii2_at(pixel);
    uint count = flux_counts.data[place_of_count(pixel)];
    vec3 direct = per_unit * visible_radiances_at(pixel).rgb;
    vec3 per_flux = vec3(0.0);
    float density = 0.0;
    if (count > 0u) {
        per_flux = visible_throughputs_at(pixel).rgb * (flux_scale / radius2);
        density = float(count) / (PI * radius2) * per_photon;
    }
    vec3 rough = vec3(0.0);
    if (HAS_ROUGH_GATHER) {
        rough = rough_scale * to_signed_floats(load_flux(pixel_count + pixel));
    }
    if (light_group != NONE) {
        store_layer_values(light_group * pixel_count + pixel, vec4(direct, density));
    }
    if (caustic_group != NONE) {
        vec3 radiance = count > 0u ? per_flux * to_floats(caustic_flux(pixel)) : vec3(0.0);
        store_layer_values(caustic_group * pixel_count + pixel, vec4(radiance + rough, 0.0));
    }
    if (square_group != NONE) {
        vec3 radiance = count > 0u ? direct + per_flux * to_floats(load_flux(pixel)) : direct;
        radiance += rough;
        vec3 balanced = vec3(dot(balance[0].xyz, radiance), dot(balance[1].xyz, radiance), dot(balance[2].xyz, radiance));
        store_layer_values(square_group * pixel_count + pixel, vec4(balanced * balanced, sqrt(radius2)));
    }
}
