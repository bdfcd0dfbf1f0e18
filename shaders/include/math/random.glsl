// Random numbers as functions of (seed, index, dimension) alone. No state is shared, so that neither
// threads nor batches change an image.
//
// Each of the first LOW_DISCREPANCY_PAIRS pairs of dimensions is a (0,2)-sequence: Owen-scrambled Sobol
// points with an index shuffled per pair (Burley, "Practical Hash-based Owen Scrambling", JCGT 2020).
// Later pairs are hashed (Jarzynski and Olano, "Hash Functions for GPU Rendering", JCGT 2020).
#include "scene/features.glsl"

// The numbers of one path.
struct Random {
    uint seed;
    uint index; // of the point in the sequence
};

uint hash(uint x) {
    x = x * 747796405u + 2891336453u;
    x = ((x >> ((x >> 28u) + 4u)) ^ x) * 277803737u;
    return (x >> 22u) ^ x;
}

uint hash(uint a, uint b) {
    return hash(a ^ hash(b));
}

uvec3 pcg3d(uvec3 v) {
    v = v * 1664525u + 1013904223u;
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v ^= v >> 16u;
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    return v;
}

// Seed of one half of the rounds. The two halves have independent numbers, so that the difference of
// their images is noise.
uint seed_of_half(uint seed, uint half_of_rounds) {
    return seed ^ (half_of_rounds * 0x9e3779b9u);
}

// Owen scrambling of a number whose bits are in reverse order.
uint scramble_reversed(uint x, uint seed) {
    x += seed;
    x ^= x * 0x6c50b47cu;
    x ^= x * 0xb82f1e52u;
    x ^= x * 0xc7afe638u;
    x ^= x * 0x8d22f6e6u;
    return x;
}

// The second Sobol dimension, with its bits in reverse order: the product of Pascal's triangle modulo 2
// and the index. By Lucas' theorem that is an exclusive or over supersets of bits.
uint pascal(uint x) {
    x ^= (x >> 1u) & 0x55555555u;
    x ^= (x >> 2u) & 0x33333333u;
    x ^= (x >> 4u) & 0x0f0f0f0fu;
    x ^= (x >> 8u) & 0x00ff00ffu;
    x ^= (x >> 16u) & 0x0000ffffu;
    return x;
}

// A number in [0, 1) from the upper 24 bits: a multiple of ROUNDING.
float to_unit(uint bits) {
    return float(bits >> 8u) * 5.9604644775390625e-8;
}

// Two independent numbers in [0, 1) for a pair of dimensions.
vec2 hashed_pair(Random random, uint pair) {
    uvec3 bits = pcg3d(uvec3(random.seed, random.index, pair));
    return vec2(to_unit(bits.x), to_unit(bits.y));
}

// Two numbers in [0, 1) for a pair of dimensions: a point of a sequence.
vec2 sequence_pair(Random random, uint pair) {
    uvec3 seeds = pcg3d(uvec3(random.seed, 0x9e3779b9u, pair));
    uint index = bitfieldReverse(scramble_reversed(bitfieldReverse(random.index), seeds.x));
    uint x = bitfieldReverse(scramble_reversed(index, seeds.y));
    uint y = bitfieldReverse(scramble_reversed(pascal(index), seeds.z));
    return vec2(to_unit(x), to_unit(y));
}

// Two numbers in [0, 1) for a pair of dimensions.
vec2 random_pair(Random random, uint pair) {
    if (pair >= LOW_DISCREPANCY_PAIRS) {
        return hashed_pair(random, pair);
    }
    return sequence_pair(random, pair);
}

// The pair of the wavelength: no path has so many bounces.
const uint PAIR_WAVELENGTH = 0xffffffffu;

// A number in [0, 1) for the wavelength of a path: paths are spread evenly over it.
float random_wavelength(Random random) {
    uint sequences = LOW_DISCREPANCY_PAIRS;
    return sequences > 0u ? sequence_pair(random, PAIR_WAVELENGTH).x : hashed_pair(random, PAIR_WAVELENGTH).x;
}
