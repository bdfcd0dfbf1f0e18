// draw_pairs: computes random numbers for given seeds, indices and pairs of dimensions.
#version 460
#include "kernel/invocation.glsl"
#include "math/random.glsl"

struct Place {
    uint seed;
    uint index;
    uint pair;
    uint pad0;
};

BUFFER(Place, places)
UPDATED_BUFFER(vec2, pairs)

void main() {
    uint i = invocation_index();
    if (i >= places.data.length()) {
        return;
    }
    Place place = places.data[i];
    pairs.data[i] = random_pair(Random(place.seed, place.index), place.pair);
}
