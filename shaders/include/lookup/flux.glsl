// Fixed-point sums: integers add up to the same bits in any order, floats do not.
//
// A sum has 64 bits in two words, in units of 2^-28 of the mean flux of a photon: a
// photon of weight below 16 touches the high word only when the low one carries. The
// largest sum, 2^36 mean photons on one pixel in one iteration, is out of reach; a
// deposit that would pass it is counted as saturated.

const float FLUX_UNIT = 268435456.0; // 2^28

// A weight in [0, 2^36) as low and high word; rounds to nearest.
uvec2 to_fixed(float weight) {
    float high = floor(weight * 0.0625);
    // Exact but for its last rounding, and below 2^32: a weight below 16 has 24 bits.
    float low = roundEven((weight - 16.0 * high) * FLUX_UNIT);
    return uvec2(uint(low), uint(high));
}

float from_fixed(uint low, uint high) {
    return float(high) * 16.0 + float(low) / FLUX_UNIT;
}
