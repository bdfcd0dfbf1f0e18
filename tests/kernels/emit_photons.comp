// emit_photons: emits photons, and stores the first rays of their paths.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "kernel/invocation.glsl"
#include "scene/scene.glsl"
#include "math/random.glsl"
#include "math/sampling.glsl"
#include "geometry/intersect.glsl"
#include "geometry/surface.glsl"
#include "material/texture.glsl"
#include "light/light.glsl"
#include "light/emission.glsl"

struct Emitted {
    vec3 origin;
    float pad0;
    vec3 direction;
    float pad1;
    vec3 weight;
    float pad2;
};

layout(std430, set = 1, binding = 0) buffer EmittedBlock { Emitted data[]; } emitted;

void main() {
    scene = scene_info_at(0u);
    uint i = invocation_index();
    if (i >= emitted.data.length()) {
        return;
    }
    Emission emission = emit(Random(scene.seed, i));
    emitted.data[i] = Emitted(emission.ray.origin, 0.0, emission.ray.direction, 0.0, emission.weight, 0.0);
}
