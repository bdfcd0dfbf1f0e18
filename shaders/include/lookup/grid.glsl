// The hash grid over photons.
#include "scene/features.glsl"

// A cell of the hash grid over photons.
struct Cell {
    uint first; // into grid_photons
    uint count; // photons in the cell
};

float cell_size(uint max_radius2) {
    // Below this, coordinates in cells would pass what fp32 can tell apart.
    return max(CELL_SCALE * 2.0 * sqrt(uintBitsToFloat(max_radius2)), 9.5367431640625e-7);
}

ivec3 cell_of(vec3 position, float inverse_size) {
    return ivec3(floor(position * inverse_size));
}

// Teschner and others, "Optimized Spatial Hashing", 2003, with a finisher that spreads
// neighbouring cells over a table of a power of two.
uint cell_hash(ivec3 cell, uint mask) {
    uvec3 c = uvec3(cell) * uvec3(73856093u, 19349663u, 83492791u);
    uint h = c.x ^ c.y ^ c.z;
    h ^= h >> 15u;
    h *= 0x2c1b3c6du;
    h ^= h >> 12u;
    return h & mask;
}

// Tells cells apart that are less than 1024 cells from each other along each axis.
uint cell_mark(ivec3 cell) {
    uvec3 low = uvec3(cell) & 1023u;
    return low.x | low.y << 10u | low.z << 20u;
}
