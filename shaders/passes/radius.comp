// radius: gives each visible point its gather radius for this iteration.
//
// Invocations: one per pixel.
// Reads: visible_throughputs (w: length of the eye path), pixel_states.
// Writes: visible_radii2, max_radius2 (atomic); pixel_states where `first` is 1.
// Units: lengths in render units.
// Source: the first radius is proportional to the length of the eye path, as the footprint of a pixel
//   is. It then shrinks per pixel (Hachisuka and Jensen 2009, equation 7) or by the same factor for
//   all pixels (Knaus and Zwicker 2011, equation 15).
#version 460
#include "kernel/invocation.glsl"
#include "lookup/records.glsl"
#include "scene/constants.glsl"

STORED_TEXELS(float, visible_radii2) // squared radius; 0 if the pixel has no visible point
TEXELS(vec4, visible_throughputs) // w: length of the eye path
UPDATED_TEXELS(PixelState, pixel_states)
UPDATED_VALUE(uint, max_radius2) // bits of a float

layout(push_constant) uniform Push {
    uint pixel_count;   // number of pixels
    float per_length;   // first radius over the length of the eye path
    float least;        // least first radius, render units
    float most;         // largest first radius, render units
    float shrink;       // factor of the squared radius, the same for all pixels
    uint first;         // 1 if the pixels' statistics begin with this iteration
};

void main() {
    uint pixel = invocation_index();
    if (pixel >= pixel_count) {
        return;
    }
    PixelState state = pixel_states_at(pixel);
    if (first != 0u) {
        state = PixelState(0u, 0u, 1.0, 0.0);
        store_pixel_states(pixel, state);
    }
    float path_length = visible_throughputs_at(pixel).w;
    float radius = clamp(per_length * path_length, least, most);
    float radius2 = path_length > 0.0 ? radius * radius * shrink * state.shrink : 0.0;
    store_visible_radii2(pixel, radius2);
    if (floatBitsToUint(radius2) > max_radius2.value) {
        atomicMax(max_radius2.value, floatBitsToUint(radius2));
    }
}
