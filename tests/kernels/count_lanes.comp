// count_lanes: counts the invocations of each subgroup that run together.
#version 460
#include "kernel/invocation.glsl"
#include "kernel/subgroup.glsl"
#extension GL_KHR_shader_subgroup_ballot : require

UPDATED_BUFFER(uint, counted) // by a ballot of all lanes
UPDATED_BUFFER(uint, told)    // by subgroup_lanes

void main() {
    uint i = invocation_index();
    uvec4 lanes = subgroupBallot(true);
    if (i < counted.data.length()) {
        counted.data[i] = uint(bitCount(lanes.x) + bitCount(lanes.y) + bitCount(lanes.z) + bitCount(lanes.w));
        told.data[i] = subgroup_lanes();
    }
}
