// cross_media: computes what media leave of light.
#version 460
#include "kernel/invocation.glsl"
#include "medium/absorption.glsl"

struct WayThrough {
    vec3 absorption;
    float way;
};

BUFFER(WayThrough, ways)
UPDATED_BUFFER(vec4, shares) // w is unused

void main() {
    uint i = invocation_index();
    if (i >= ways.data.length()) {
        return;
    }
    shares.data[i] = vec4(absorb(ways.data[i].absorption, ways.data[i].way), 0.0);
}
