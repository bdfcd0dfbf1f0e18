// draw_pairs: computes random numbers for given seeds, indices and pairs of dimensions.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "kernel/invocation.glsl"
#include "math/random.glsl"

struct Place {
    uint seed;
    uint index;
    uint pair;
    uint pad0;
};

layout(std430, set = 1, binding = 0) readonly buffer PlaceBlock { Place data[]; } places;
layout(std430, set = 1, binding = 1) buffer PairBlock { vec2 data[]; } pairs;

void main() {
    uint i = invocation_index();
    if (i >= places.data.length()) {
        return;
    }
    Place place = places.data[i];
    pairs.data[i] = random_pair(Random(place.seed, place.index), place.pair);
}
