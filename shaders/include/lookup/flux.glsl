// Fixed-point sums of flux: integers have the same sum in any order, floats do not.
//
// With dispersion, weights and sums may be below 0: they are two's complements.
//
// A sum has 64 bits in two words, in units of 2^-28 of the mean flux of a photon. A photon of weight below
// 16 changes the high word only by the carry of the low word. The limit, 2^36 times the mean flux on one
// pixel in one iteration, is out of reach; sums beyond it are counted as saturated.

#include "scene/features.glsl"

const float FLUX_UNIT = 268435456.0; // 2^28

// Converts a weight in [0, 2^36) to a low and a high word, rounded to nearest.
uvec2 to_fixed(float weight) {
    float high = floor(weight * 0.0625);
    // Exact up to the last rounding, and below 2^32, since a weight below 16 has 24 bits.
    float low = roundEven((weight - 16.0 * high) * FLUX_UNIT);
    return uvec2(uint(low), uint(high));
}

// The opposite of a number of two words.
uvec2 opposite(uvec2 words) {
    return uvec2(~words.x + 1u, ~words.y + (words.x == 0u ? 1u : 0u));
}

// Converts a weight of a photon: one in (-2^35, 2^35) with dispersion, else in [0, 2^36).
uvec2 to_words(float weight) {
    if (HAS_DISPERSION) {
        uvec2 size = to_fixed(abs(weight));
        return weight < 0.0 ? opposite(size) : size;
    }
    return to_fixed(weight);
}

// The top bit says whether the sum of two high words, carry included, has overflowed.
uint overflow_of(uint before, uint added, uint sum) {
    if (HAS_DISPERSION) {
        return (before ^ sum) & (added ^ sum);
    }
    return sum < before ? 0x80000000u : 0u;
}

float from_fixed(uint low, uint high) {
    return float(high) * 16.0 + float(low) / FLUX_UNIT;
}
