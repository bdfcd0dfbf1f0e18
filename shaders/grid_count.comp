// grid_count: count the visible points in each cell of the hash grid.
// One invocation per pixel. Reads visible_*. Updates cells.count (atomic).
#version 460
#extension GL_GOOGLE_include_directive : require
#include "invocation.glsl"
#include "types.glsl"
#include "grid.glsl"

layout(std430, set = 1, binding = 0) readonly buffer PositionBlock { vec4 data[]; } visible_positions;
layout(std430, set = 1, binding = 1) readonly buffer GridInfoBlock { GridInfo value; } grid_info;
layout(std430, set = 1, binding = 2) buffer CellBlock { Cell data[]; } cells;

layout(push_constant) uniform Push {
    uint pixel_count;
    uint cell_mask;
};

void main() {
    uint pixel = invocation_index();
    if (pixel >= pixel_count || visible_positions.data[pixel].w == 0.0) {
        return;
    }
    float inverse_size = 1.0 / cell_size(grid_info.value.max_radius2);
    ivec3 cell = cell_of(visible_positions.data[pixel].xyz, inverse_size);
    atomicAdd(cells.data[cell_hash(cell, cell_mask)].count, 1u);
}
