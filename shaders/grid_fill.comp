// grid_fill: copy each photon to its cell's range, so that those of a cell are next to each
// other.
// One invocation per recorded photon. Reads photons. Writes grid_photons; updates cells.count
// (atomic).
#version 460
#extension GL_GOOGLE_include_directive : require
#include "invocation.glsl"
#include "types.glsl"
#include "grid.glsl"

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
        uint cell = cell_hash(cell_of(photon.position, inverse_size), cell_mask);
        store_grid_photons(cells.data[cell].first + atomicAdd(cells.data[cell].count, 1u), photon);
    }
}
