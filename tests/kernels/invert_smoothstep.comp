// invert_smoothstep: samples the smooth falloff of a spot light.
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

layout(std430, set = 1, binding = 0) readonly buffer UniformBlock { float data[]; } uniforms;
layout(std430, set = 1, binding = 1) buffer QuantileBlock { float data[]; } quantiles;

void main() {
    uint i = invocation_index();
    if (i < uniforms.data.length()) {
        quantiles.data[i] = sample_smoothstep(uniforms.data[i]);
    }
}
