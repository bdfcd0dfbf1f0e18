// emit_photons: emits photons, and stores the first rays of their paths.
#version 460
#include "kernel/invocation.glsl"
#include "light/emission.glsl"
#include "math/random.glsl"
#include "scene/scene.glsl"

struct Emitted {
    vec3 origin;
    float pad0;
    vec3 direction;
    float pad1;
    vec3 weight;
    float pad2;
};

UPDATED_BUFFER(Emitted, emitted)

void main() {
    uint i = invocation_index();
    if (i >= emitted.data.length()) {
        return;
    }
    Emission emission = emit(emission_numbers(Random(scene.seed, i)));
    emitted.data[i] = Emitted(emission.ray.origin, 0.0, emission.ray.direction, 0.0, emission.weight, 0.0);
}
