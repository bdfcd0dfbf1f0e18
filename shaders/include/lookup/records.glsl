// Visible points, photons, and what a pixel keeps between iterations.

// Where a pixel's eye path ended.
struct VisiblePoint {
    vec3 position; // render units
    uint normal;   // of the surface, packed: normal.glsl
};

// A photon where it met a diffuse surface.
struct PhotonRecord {
    vec3 position; // render units
    uint normal;  // packed, on the side that the photon came from
    vec3 weight;  // flux over the mean flux of a photon
    uint cell;    // of the hash grid: cell_mark; and the mark of caustic.glsl
};

// What a pixel keeps between iterations, besides the image. With radii from the data the words have another meaning:
// DiscSums of data_radius.glsl.
struct PixelState {
    uint found_low;  // low word of the number of photons found so far
    uint found_high; // high word of that number
    float shrink;    // factor by which the squared radius has shrunk so far
    float rest;      // what rounding has left out of that factor
};
