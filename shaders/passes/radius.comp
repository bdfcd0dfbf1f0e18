// radius: gives each visible point its gather radius for this iteration.
//
// Invocations: one per pixel.
// Reads: visible_throughputs (w: length of the eye path), pixel_states.
// Writes: visible_radii2, max_radius2 (atomic); pixel_states where `first` is 1.
// Units: lengths in render units.
// Source: the first radius is proportional to the length of the eye path, as the footprint of a pixel
//   is. It then shrinks per pixel (Hachisuka and Jensen 2009, equation 7) or by the same factor for
//   all pixels (Knaus and Zwicker 2011, equation 15); and with radii from the data by another factor
//   besides (data_radius.glsl).
#version 460
#include "kernel/invocation.glsl"
#include "lookup/data_radius.glsl"
#include "lookup/records.glsl"
#include "scene/constants.glsl"
#include "scene/features.glsl"

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
    uint width;         // of the image, pixels
    float iterations;   // number of this iteration among those of the pixels' statistics, from 1
};

// Pixels between those whose statistics are pooled: neighbours share photons.
const int POOL_STEP = 2;

// The factor of a pixel's squared radius that the photons of earlier iterations tell, of the pixel and eight around
// it. `radius2` is the squared radius of the global schedule.
float factor_of_data(uint pixel, float radius2) {
    ivec2 last = ivec2(width, pixel_count / width) - 1;
    ivec2 centre = ivec2(pixel % width, pixel / width);
    DiscPool pool = DiscPool(0.0, 0.0, 0.0, 0.0);
    for (int y = -1; y <= 1; y++) {
        for (int x = -1; x <= 1; x++) {
            uvec2 at = uvec2(clamp(centre + POOL_STEP * ivec2(x, y), ivec2(0), last));
            add_pixel(pool, disc_sums(pixel_states_at(at.y * width + at.x)), radius2);
        }
    }
    return factor_of(pool, iterations);
}

void main() {
    uint pixel = invocation_index();
    if (pixel >= pixel_count) {
        return;
    }
    PixelState state = pixel_states_at(pixel);
    if (first != 0u) {
        state = first_state();
        store_pixel_states(pixel, state);
    }
    float path_length = visible_throughputs_at(pixel).w;
    float radius = clamp(per_length * path_length, least, most);
    float radius2 = radius * radius * shrink;
    if (HAS_DATA_RADII) {
        radius2 *= first != 0u ? 1.0 : factor_of_data(pixel, radius2);
    } else {
        radius2 *= state.shrink;
    }
    radius2 = path_length > 0.0 ? radius2 : 0.0;
    store_visible_radii2(pixel, radius2);
    if (floatBitsToUint(radius2) > max_radius2.value) {
        atomicMax(max_radius2.value, floatBitsToUint(radius2));
    }
}
