// grid_fill: copy each photon to its cell's range, so that those of a cell are next to each
// other.
// One invocation per recorded photon. Reads photons. Writes grid_photons; updates cells.count
// (atomic).
#version 460
#include "kernel/invocation.glsl"
#include "lookup/grid.glsl"
#include "lookup/records.glsl"
#include "scene/constants.glsl"

TEXELS(PhotonRecord, photons)
VALUE(uint, max_radius2)
UPDATED_BUFFER(Cell, cells)
STORED_TEXELS(PhotonRecord, grid_photons)

layout(push_constant) uniform Push {
    uint recorded; // number of photons
    uint cell_mask; // cells of the table, less 1
};

void main() {
    float inverse_size = 1.0 / cell_size(max_radius2.value);
    uint i = invocation_index();
    if (i < recorded) {
        PhotonRecord photon = photons_at(i);
        ivec3 cell = cell_of(photon.position, inverse_size);
        uint slot = cell_hash(cell, cell_mask);
        photon.cell = cell_mark(cell);
        store_grid_photons(cells.data[slot].first + atomicAdd(cells.data[slot].count, 1u), photon);
    }
}
