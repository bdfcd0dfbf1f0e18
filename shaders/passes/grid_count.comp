// grid_count: counts the photons in each cell of the hash grid.
//
// Invocations: one per recorded photon.
// Reads: photons, max_radius2, grid_extent. Writes: cells.count (atomic).
#version 460
#include "kernel/invocation.glsl"
#include "lookup/grid.glsl"
#include "lookup/records.glsl"
#include "scene/constants.glsl"

TEXELS(PhotonRecord, photons)
VALUE(uint, max_radius2)
VALUE(GridExtent, grid_extent)
UPDATED_BUFFER(Cell, cells)

void main() {
    float inverse_size = 1.0 / cell_size(max_radius2.value);
    uint i = invocation_index();
    if (i < grid_extent.value.recorded) {
        ivec3 cell = cell_of(photons_at(i).position, inverse_size);
        atomicAdd(cells.data[cell_hash(cell, grid_extent.value.cell_mask)].count, 1u);
    }
}
