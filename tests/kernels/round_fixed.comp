// round_fixed: converts weights to fixed point and back.
#version 460
#include "kernel/invocation.glsl"
#include "lookup/flux.glsl"

BUFFER(float, weights)
UPDATED_BUFFER(uvec2, fixed_points)
UPDATED_BUFFER(float, back)

void main() {
    uint i = invocation_index();
    if (i >= weights.data.length()) {
        return;
    }
    uvec2 fixed_point = to_fixed(weights.data[i]);
    fixed_points.data[i] = fixed_point;
    back.data[i] = from_fixed(fixed_point.x, fixed_point.y);
}
