// run_textures: evaluates textures at given points of surfaces.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "kernel/invocation.glsl"
#include "scene/scene.glsl"
#include "math/sampling.glsl"
#include "geometry/intersect.glsl"
#include "geometry/surface.glsl"
#include "material/texture.glsl"

struct TexturedPoint {
    vec3 position;
    uint first; // node of the texture
    vec3 normal;
    float pad0;
    vec2 uv;
    vec2 pad1;
};

layout(std430, set = 1, binding = 0) readonly buffer PointBlock { TexturedPoint data[]; } points;
layout(std430, set = 1, binding = 1) buffer ValueBlock { vec4 data[]; } values;

void main() {
    uint i = invocation_index();
    if (i >= points.data.length()) {
        return;
    }
    Surface surface;
    surface.position = points.data[i].position;
    surface.normal = points.data[i].normal;
    surface.uv = points.data[i].uv;
    values.data[i] = vec4(textured(points.data[i].first, vec3(-7.0), surface), 0.0);
}
