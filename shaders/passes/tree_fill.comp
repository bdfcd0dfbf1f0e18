// tree_fill: copies each visible point to its node of the kd-tree, so that a walk reads a node from
// consecutive memory.
//
// Invocations: one per node.
// Reads: visible_points, visible_radii2, tree_nodes. Writes: tree_points.
// Units: lengths in render units.
#version 460
#include "kernel/invocation.glsl"
#include "lookup/records.glsl"
#include "lookup/tree.glsl"
#include "scene/constants.glsl"

TEXELS(VisiblePoint, visible_points)
TEXELS(float, visible_radii2)
BUFFER(uint, tree_nodes) // pixel, and above it the axis
STORED_TEXELS(TreePoint, tree_points)

layout(push_constant) uniform Push {
    uint node_count; // nodes of the tree
};

void main() {
    uint index = invocation_index();
    if (index >= node_count) {
        return;
    }
    uint node = tree_nodes.data[index];
    uint pixel = node & PIXEL_MASK;
    VisiblePoint point = visible_points_at(pixel);
    store_tree_points(index, TreePoint(point.position, visible_radii2_at(pixel), point.normal, node, 0u, 0u));
}
