// round_normals: packs unit vectors into 32 bits and unpacks them.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "kernel/invocation.glsl"
#include "geometry/normal.glsl"

layout(std430, set = 1, binding = 0) readonly buffer NormalBlock { vec4 data[]; } normals;
layout(std430, set = 1, binding = 1) buffer BackBlock { vec4 data[]; } back;

void main() {
    uint i = invocation_index();
    if (i >= normals.data.length()) {
        return;
    }
    back.data[i] = vec4(unpack_normal(pack_normal(normals.data[i].xyz)), 0.0);
}
