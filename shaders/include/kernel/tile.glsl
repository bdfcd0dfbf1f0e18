// Invocations by pixels: those of a subgroup take a compact block of the image, so that they
// meet the same surfaces.
#include "scene/constants.glsl"

// Pixels along an edge of a tile.
export const uint TILE = 8u;

// Every second bit of a number of up to six bits.
uint even_bits(uint x) {
    x &= 0x15u;
    x = (x | (x >> 1u)) & 0x13u;
    return (x | (x >> 2u)) & 0x07u;
}

// Invocations that take the pixels of an image: whole tiles.
uint invocations_by_tile(uint width, uint height) {
    return ((width + TILE - 1u) / TILE) * ((height + TILE - 1u) / TILE) * (TILE * TILE);
}

// The pixel of an invocation, or NONE: by tiles along rows, in each along a Z curve.
uint pixel_of(uint invocation, uint width, uint height) {
    uint tiles = (width + TILE - 1u) / TILE;
    uint tile = invocation / (TILE * TILE);
    uint x = (tile % tiles) * TILE + even_bits(invocation);
    uint y = (tile / tiles) * TILE + even_bits(invocation >> 1u);
    return x < width && y < height ? y * width + x : NONE;
}
