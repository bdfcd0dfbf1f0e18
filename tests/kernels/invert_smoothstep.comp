// invert_smoothstep: samples the smooth falloff of a spot light.
#version 460
#include "kernel/invocation.glsl"
#include "light/emission.glsl"

BUFFER(float, uniforms)
UPDATED_BUFFER(float, quantiles)

void main() {
    uint i = invocation_index();
    if (i < uniforms.data.length()) {
        quantiles.data[i] = sample_smoothstep(uniforms.data[i]);
    }
}
