// Assigns pixels to invocations. Those of a subgroup have a compact block of the image, so that their
// paths meet the same surfaces.

const uint TILE_BITS = 3u; // 8 x 8 pixels

// The even bits 0, 2 and 4 of a number, as bits 0, 1 and 2.
uint even_bits(uint x) {
    x &= 0x15u;
    x = (x | (x >> 1u)) & 0x13u;
    return (x | (x >> 2u)) & 0x07u;
}

// Number of invocations for an image: that of the pixels of whole tiles.
uint invocations_by_tile(uint width, uint height) {
    return ((width + 7u) >> TILE_BITS) * ((height + 7u) >> TILE_BITS) << (2u * TILE_BITS);
}

// The pixel of an invocation, or NONE if it is outside of the image. Tiles are in row order, the pixels of
// a tile in Z order.
uint pixel_of(uint invocation, uint width, uint height) {
    uint tiles = (width + 7u) >> TILE_BITS;
    uint tile = invocation >> (2u * TILE_BITS);
    uint x = ((tile % tiles) << TILE_BITS) + even_bits(invocation);
    uint y = ((tile / tiles) << TILE_BITS) + even_bits(invocation >> 1u);
    return x < width && y < height ? y * width + x : NONE;
}
