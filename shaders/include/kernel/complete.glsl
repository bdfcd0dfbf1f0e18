// Tells whether an iteration may be added to the image.
#include "kernel/counters.glsl"
#include "scene/features.glsl"

// Whether the passes before, in the same submission, have done all. If not, the host runs the iteration again.
// `capacity` is the number of photons that a batch may record, on diffuse and on rough surfaces each.
bool is_complete(uint capacity) {
    if (HAS_ROUGH_GATHER) {
        if (counters.value.recorded_rough > capacity) {
            return false;
        }
    }
    return counters.value.recorded <= capacity && (counters.value.interrupted | counters.value.unfinished) == 0u;
}
