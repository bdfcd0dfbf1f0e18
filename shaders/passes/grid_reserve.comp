// grid_reserve: gives each cell of the hash grid its range of entries.
//
// Invocations: one per cell.
// Reads: cells.count, grid_extent. Writes: cells (first; count becomes 0), grid_filled (atomic).
//
// One atomic per occupied cell replaces a prefix sum, which would order the ranges by cell: sums of
// integers are the same in any order.
#version 460
#include "kernel/invocation.glsl"
#include "lookup/grid.glsl"

UPDATED_VALUE(uint, grid_filled) // number of entries given away
UPDATED_BUFFER(Cell, cells)
VALUE(GridExtent, grid_extent)

void main() {
    uint cell = invocation_index();
    if (cell > grid_extent.value.cell_mask) {
        return;
    }
    uint count = cells.data[cell].count;
    if (count > 0u) {
        cells.data[cell] = Cell(atomicAdd(grid_filled.value, count), 0u);
    }
}
