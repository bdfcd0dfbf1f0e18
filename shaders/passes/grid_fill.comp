// grid_fill: copies each photon to the range of its cell, so that the photons of a cell are consecutive.
//
// Invocations: one per recorded photon.
// Reads: photons, max_radius2, cells.first. Writes: grid_photons, cells.count (atomic).
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
    uint recorded;  // number of photons
    uint cell_mask; // number of cells less 1; the number is a power of two
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
