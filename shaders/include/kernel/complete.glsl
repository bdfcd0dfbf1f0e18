// Tells whether an iteration may be added to the image.
#include "kernel/counters.glsl"

// Whether the passes before, in the same submission, have done all. If not, the host runs the iteration again.
// `capacity` is the number of photons that a batch may record.
bool is_complete(uint capacity) {
    return counters.value.recorded <= capacity && (counters.value.interrupted | counters.value.unfinished) == 0u;
}
