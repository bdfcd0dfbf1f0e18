// grid_fill: copy each photon to its cell's range, so that those of a cell are next to each
// other.
// One invocation per recorded photon. Reads photons. Writes grid_photons; updates cells.count
// (atomic).
#version 460
#extension GL_GOOGLE_include_directive : require
#include "kernel/invocation.glsl"
#include "scene/types.glsl"
#include "lookup/grid.glsl"

TEXELS(1, 0, PhotonRecord, photons)
layout(std430, set = 1, binding = 1) readonly buffer MaxRadiusBlock { uint value; } max_radius2;
layout(std430, set = 1, binding = 2) buffer CellBlock { Cell data[]; } cells;
STORED_TEXELS(1, 3, PhotonRecord, grid_photons)

layout(push_constant) uniform Push {
    uint recorded;
    uint cell_mask;
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
