// layer_sums: adds what an iteration has for a group of layers to the exact sums of the group.
//
// Invocations: one per pixel. It runs after the update pass, in the same submission.
// Reads: layer_values, counters. Writes: layer_x, layer_y, layer_z, layer_w (exact, see sum.glsl).
// Units: those of the values.
#version 460
#include "kernel/complete.glsl"
#include "kernel/counters.glsl"
#include "kernel/invocation.glsl"
#include "math/sum.glsl"
#include "scene/constants.glsl"

TEXELS(vec4, layer_values)
GROUPED_UPDATED_TEXELS(layer_sums, uvec4, layer_x)
GROUPED_UPDATED_TEXELS(layer_sums, uvec4, layer_y)
GROUPED_UPDATED_TEXELS(layer_sums, uvec4, layer_z)
GROUPED_UPDATED_TEXELS(layer_sums, uvec4, layer_w)

layout(push_constant) uniform Push {
    uint pixel_count; // number of pixels
    uint group;       // number of the group in layer_values
    uint capacity;    // photons that a batch may record
    uint pad0;        // unused
};

// A value that is no number counts as 0, and one that is too large as the largest.
uvec4 term_of(float value) {
    return isnan(value) ? uvec4(0u) : to_signed_term(clamp(value, -LARGEST_TERM, LARGEST_TERM));
}

void main() {
    uint pixel = invocation_index();
    if (pixel >= pixel_count || !is_complete(capacity)) {
        return;
    }
    vec4 value = layer_values_at(group * pixel_count + pixel);
    store_layer_x(pixel, add_exactly(layer_x_at(pixel), term_of(value.x)));
    store_layer_y(pixel, add_exactly(layer_y_at(pixel), term_of(value.y)));
    store_layer_z(pixel, add_exactly(layer_z_at(pixel), term_of(value.z)));
    store_layer_w(pixel, add_exactly(layer_w_at(pixel), term_of(value.w)));
}
