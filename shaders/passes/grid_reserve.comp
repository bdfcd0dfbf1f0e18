// grid_reserve: gives each cell of the hash grid its range of entries.
//
// Invocations: one per cell.
// Reads: cells.count. Writes: cells (first; count becomes 0), grid_filled (atomic).
//
// One atomic per occupied cell replaces a prefix sum, which would order the ranges by cell: sums of
// integers are the same in any order.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "kernel/invocation.glsl"
#include "scene/types.glsl"

layout(std430, set = 1, binding = 0) buffer FilledBlock { uint value; } grid_filled; // number of entries given away
layout(std430, set = 1, binding = 1) buffer CellBlock { Cell data[]; } cells;

layout(push_constant) uniform Push {
    uint cell_count;
};

void main() {
    uint cell = invocation_index();
    if (cell >= cell_count) {
        return;
    }
    uint count = cells.data[cell].count;
    if (count > 0u) {
        cells.data[cell] = Cell(atomicAdd(grid_filled.value, count), 0u);
    }
}
