// warp_emission: warps the numbers by which photons begin, and samples lights in the order of the guide.
#version 460
#include "kernel/invocation.glsl"
#include "light/guide.glsl"

struct Warped {
    vec2 light;
    vec2 position;
    vec2 direction;
    float weight;
    uint chosen; // light that light.x samples
};

BUFFER(EmissionNumbers, numbers)
UPDATED_BUFFER(Warped, warped)

void main() {
    uint i = invocation_index();
    if (i >= numbers.data.length()) {
        return;
    }
    EmissionNumbers guided = guide(numbers.data[i]);
    uint count = numbers.data[i].pad; // number of lights
    warped.data[i] = Warped(guided.light, guided.position, guided.direction, guided.weight,
                            sample_guide_light(guided.light.x, count));
}
