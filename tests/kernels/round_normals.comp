// round_normals: packs unit vectors into 32 bits and unpacks them.
#version 460
#include "geometry/normal.glsl"
#include "kernel/invocation.glsl"

BUFFER(vec4, normals)
UPDATED_BUFFER(vec4, back)

void main() {
    uint i = invocation_index();
    if (i >= normals.data.length()) {
        return;
    }
    back.data[i] = vec4(unpack_normal(pack_normal(normals.data[i].xyz)), 0.0);
}
