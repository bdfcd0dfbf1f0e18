// grid_fill: copy each visible point to its cell's range, so that a photon reads the
// points of a cell from consecutive memory.
// One invocation per pixel. Reads visible_*. Writes grid_*; updates cells.count (atomic).
#version 460
#extension GL_GOOGLE_include_directive : require
#include "invocation.glsl"
#include "types.glsl"
#include "grid.glsl"

layout(std430, set = 1, binding = 0) readonly buffer PositionBlock { vec4 data[]; } visible_positions;
layout(std430, set = 1, binding = 1) readonly buffer VisibleNormalBlock { uint data[]; } visible_normals;
layout(std430, set = 1, binding = 2) readonly buffer GridInfoBlock { GridInfo value; } grid_info;
layout(std430, set = 1, binding = 3) buffer CellBlock { Cell data[]; } cells;
layout(std430, set = 1, binding = 4) buffer GridPositionBlock { vec4 data[]; } grid_positions; // w: squared radius
layout(std430, set = 1, binding = 5) buffer GridOwnerBlock { uvec2 data[]; } grid_owners; // packed normal, pixel

layout(push_constant) uniform Push {
    uint pixel_count;
    uint cell_mask;
};

void main() {
    uint pixel = invocation_index();
    if (pixel >= pixel_count || visible_positions.data[pixel].w == 0.0) {
        return;
    }
    vec4 position = visible_positions.data[pixel];
    float inverse_size = 1.0 / cell_size(grid_info.value.max_radius2);
    uint cell = cell_hash(cell_of(position.xyz, inverse_size), cell_mask);
    uint entry = cells.data[cell].first + atomicAdd(cells.data[cell].count, 1u);
    grid_positions.data[entry] = position;
    grid_owners.data[entry] = uvec2(visible_normals.data[pixel], pixel);
}
