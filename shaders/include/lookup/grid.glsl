// The hash grid over photons.
#include "scene/features.glsl"

// A cell of the hash grid over photons.
struct Cell {
    uint first; // into grid_photons
    uint count; // photons in the cell
};

// What the photons of a batch make of the grid: grid_size.comp.
struct GridExtent {
    uvec3 by_photon; // workgroups of a dispatch of one invocation per photon
    uint recorded;   // photons
    uvec3 by_cell;   // workgroups of a dispatch of one invocation per cell
    uint cell_mask;  // number of cells less 1; the number is a power of two
};

// Width of a cell in render units; max_radius2 has the bits of a float.
float cell_size(uint max_radius2) {
    // In narrower cells, fp32 could not tell neighbouring coordinates apart.
    return max(CELL_SCALE * 2.0 * sqrt(uintBitsToFloat(max_radius2)), 9.5367431640625e-7);
}

ivec3 cell_of(vec3 position, float inverse_size) {
    return ivec3(floor(position * inverse_size));
}

// Index of a cell in a table of mask + 1 cells, a power of two (Teschner and others, "Optimized Spatial
// Hashing", 2003). The last three steps spread neighbouring cells over the table.
uint cell_hash(ivec3 cell, uint mask) {
    uvec3 c = uvec3(cell) * uvec3(73856093u, 19349663u, 83492791u);
    uint h = c.x ^ c.y ^ c.z;
    h ^= h >> 15u;
    h *= 0x2c1b3c6du;
    h ^= h >> 12u;
    return h & mask;
}

// A number that differs between any two cells less than 1024 cells apart along each axis.
uint cell_mark(ivec3 cell) {
    uvec3 low = uvec3(cell) & 1023u;
    return low.x | low.y << 10u | low.z << 20u;
}
