// Assigns pixels to invocations. Those of a subgroup have a compact block of the image, so that their
// paths meet the same surfaces.
#include "scene/constants.glsl"

// Pixels along an edge of a tile.
export const uint TILE = 8u;

// The even bits 0, 2 and 4 of a number, as bits 0, 1 and 2.
uint even_bits(uint x) {
    x &= 0x15u;
    x = (x | (x >> 1u)) & 0x13u;
    return (x | (x >> 2u)) & 0x07u;
}

// Number of invocations for an image: that of the pixels of whole tiles.
uint invocations_by_tile(uint width, uint height) {
    return ((width + TILE - 1u) / TILE) * ((height + TILE - 1u) / TILE) * (TILE * TILE);
}

// The pixel of an invocation, or NONE if it is outside of the image. Tiles are in row order, the pixels of
// a tile in Z order.
uint pixel_of(uint invocation, uint width, uint height) {
    uint tiles = (width + TILE - 1u) / TILE;
    uint tile = invocation / (TILE * TILE);
    uint x = (tile % tiles) * TILE + even_bits(invocation);
    uint y = (tile / tiles) * TILE + even_bits(invocation >> 1u);
    return x < width && y < height ? y * width + x : NONE;
}
