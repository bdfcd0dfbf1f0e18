// grid_reserve: give each cell its range of entries.
// One invocation per cell. Updates cells (first set, count back to 0) and grid_filled (atomic). A prefix sum would order the ranges by cell; sums of integers do not ask for
// an order, so that one atomic per occupied cell serves.
#version 460
#include "kernel/invocation.glsl"
#include "lookup/grid.glsl"

UPDATED_VALUE(uint, grid_filled) // entries handed out
UPDATED_BUFFER(Cell, cells)

layout(push_constant) uniform Push {
    uint cell_count; // cells of the table
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
