// tree_fill: copy each visible point to its node, so that a walk reads a node from
// consecutive memory.
// One invocation per node. Reads visible_*, tree_nodes. Writes tree_points.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "invocation.glsl"
#include "types.glsl"

layout(std430, set = 1, binding = 0) readonly buffer PositionBlock { vec4 data[]; } visible_positions;
layout(std430, set = 1, binding = 1) readonly buffer VisibleNormalBlock { uint data[]; } visible_normals;
layout(std430, set = 1, binding = 2) readonly buffer TreeNodeBlock { uint data[]; } tree_nodes; // pixel, axis
STORED_TEXELS(1, 3, TreePoint, tree_points)

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
    vec4 visible = visible_positions.data[pixel];
    store_tree_points(index, TreePoint(visible.xyz, visible.w, visible_normals.data[pixel], node, 0u, 0u));
}
