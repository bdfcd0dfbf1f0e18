// grid_fill: copies each photon to the range of its cell, so that the photons of a cell are consecutive.
//
// Invocations: one per recorded photon.
// Reads: photons, max_radius2, grid_extent, cells.first. Writes: grid_photons, cells.count (atomic).
#version 460
#include "kernel/invocation.glsl"
#include "lookup/caustic.glsl"
#include "lookup/grid.glsl"
#include "lookup/records.glsl"
#include "scene/constants.glsl"
#include "scene/features.glsl"

TEXELS(PhotonRecord, photons)
VALUE(uint, max_radius2)
VALUE(GridExtent, grid_extent)
UPDATED_BUFFER(Cell, cells)
STORED_TEXELS(PhotonRecord, grid_photons)

void main() {
    float inverse_size = 1.0 / cell_size(max_radius2.value);
    uint i = invocation_index();
    if (i < grid_extent.value.recorded) {
        PhotonRecord photon = photons_at(i);
        ivec3 cell = cell_of(photon.position, inverse_size);
        uint slot = cell_hash(cell, grid_extent.value.cell_mask);
        if (SORTS_ROUGH) {
            // `cell` is the photon's direction.
        } else {
            photon.cell = marked_cell(photon, cell_mark(cell));
        }
        store_grid_photons(cells.data[slot].first + atomicAdd(cells.data[slot].count, 1u), photon);
    }
}
