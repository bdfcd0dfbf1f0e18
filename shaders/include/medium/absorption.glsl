// How much light is left on its way through a medium.
#include "scene/constants.glsl"

// Above this optical depth no light passes: less than the least normal number of fp32.
const float OPAQUE_DEPTH = 87.0;

// Share of light that is left after a way through a medium, by the law of Beer and Lambert. `absorption` is the
// coefficient per channel, 1/render unit; `way` is in render units.
vec3 absorb(vec3 absorption, float way) {
    // Rounding takes ways below 0, and beyond the largest number.
    vec3 depth = absorption * clamp(way, 0.0, INFINITY_T);
    return mix(exp(-depth), vec3(0.0), greaterThan(depth, vec3(OPAQUE_DEPTH)));
}
