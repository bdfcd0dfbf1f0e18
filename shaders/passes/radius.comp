// radius: give each visible point its radius for this iteration.
// One invocation per pixel. Reads visible_throughputs, pixel_states. Writes visible_radii2;
// raises max_radius2. The first radius follows the length of
// the eye path, as the footprint of a pixel does; how much of it is left is either the
// pixel's own affair (Hachisuka and Jensen 2009, eq. 7) or the same for all (Knaus and
// Zwicker 2011, eq. 15).
#version 460
#include "kernel/invocation.glsl"
#include "lookup/records.glsl"
#include "scene/constants.glsl"

STORED_TEXELS(float, visible_radii2) // squared radius, 0 if there is no point
TEXELS(vec4, visible_throughputs) // w: length of the path
UPDATED_TEXELS(PixelState, pixel_states)
UPDATED_VALUE(uint, max_radius2) // bits of a float

layout(push_constant) uniform Push {
    uint pixel_count; // pixels
    float per_length; // first radius over path length
    float least; // least first radius, render units
    float most; // most first radius, render units
    float shrink;       // of the squared radius, for all pixels
    uint first;         // 1 if a pixel's statistics begin here
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
