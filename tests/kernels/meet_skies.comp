// meet_skies: evaluates the radiance of infinite lights in given directions.
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

struct Escape {
    vec3 direction;
    float bsdf_pdf;
};

layout(std430, set = 1, binding = 0) readonly buffer EscapeBlock { Escape data[]; } escapes;
layout(std430, set = 1, binding = 1) buffer RadianceBlock { vec4 data[]; } radiances;

void main() {
    scene = scene_info_at(0u);
    uint i = invocation_index();
    if (i < escapes.data.length()) {
        radiances.data[i] = vec4(radiance_from_infinity(escapes.data[i].direction, escapes.data[i].bsdf_pdf), 0.0);
    }
}
