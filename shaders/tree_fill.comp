// tree_fill: copy each visible point to its node, so that a walk reads a node from
// consecutive memory.
// One invocation per node. Reads visible_*, tree_nodes. Writes tree_positions, tree_owners.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "invocation.glsl"
#include "types.glsl"

layout(std430, set = 1, binding = 0) readonly buffer PositionBlock { vec4 data[]; } visible_positions;
layout(std430, set = 1, binding = 1) readonly buffer VisibleNormalBlock { uint data[]; } visible_normals;
layout(std430, set = 1, binding = 2) readonly buffer TreeNodeBlock { uint data[]; } tree_nodes; // pixel, axis
layout(std430, set = 1, binding = 3) buffer TreePositionBlock { vec4 data[]; } tree_positions; // w: squared radius
layout(std430, set = 1, binding = 4) buffer TreeOwnerBlock { uvec2 data[]; } tree_owners; // packed normal; pixel, axis

layout(push_constant) uniform Push {
    uint node_count;
};

void main() {
    uint index = invocation_index();
    if (index >= node_count) {
        return;
    }
    uint node = tree_nodes.data[index];
    uint pixel = node & PIXEL_MASK;
    tree_positions.data[index] = visible_positions.data[pixel];
    tree_owners.data[index] = uvec2(visible_normals.data[pixel], node);
}
