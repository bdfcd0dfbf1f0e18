// go_round: points of the unit circle by their angles.
#version 460
#include "kernel/invocation.glsl"
#include "math/circle.glsl"

BUFFER(float, angles)
UPDATED_BUFFER(vec2, points)

void main() {
    uint i = invocation_index();
    if (i < angles.data.length()) {
        points.data[i] = circle_point(angles.data[i]);
    }
}
