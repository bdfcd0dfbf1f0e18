// Exact sums of radiance. Integers have the same sum in any order, so that iterations can be divided among
// any number of shards.
//
// A sum is a two's complement integer of 128 bits, lowest word first, in units of 2^-FRACTION_BITS of a radiance that
// is typical of the scene; src/image/estimate.rs reads it. Terms are below 2^39, so that 2^32 of them do
// not overflow.

// Bits of a sum behind the point.
export const uint FRACTION_BITS = 56u;
const float MAX_TERM = 549755813888.0;     // 2^39
const float LARGEST_TERM = 549755781120.0; // the largest float below MAX_TERM

// Converts a number in [0, 2^39) to fixed point, rounded to nearest. All steps but that rounding are
// exact: scaling by powers of two, floors, and differences with fewer bits than their terms.
uvec4 to_term(float value) {
    float high = floor(value * exp2(float(FRACTION_BITS) - 64.0)); // in 2^8
    value -= high * 256.0;
    float middle = floor(value * exp2(float(FRACTION_BITS - 32u))); // in 2^-24
    value -= middle * 5.9604644775390625e-8;
    float low = roundEven(value * exp2(float(FRACTION_BITS))); // in 2^-56
    return uvec4(uint(low), uint(middle), uint(high), 0u);
}

// The sum of two 128-bit integers.
uvec4 add_exactly(uvec4 a, uvec4 b) {
    uvec4 sum = a + b;
    uint carry = sum.x < b.x ? 1u : 0u;
    uint over = sum.y < b.y ? 1u : 0u;
    sum.y += carry;
    carry = over + (sum.y < carry ? 1u : 0u);
    over = sum.z < b.z ? 1u : 0u;
    sum.z += carry;
    sum.w += over + (sum.z < carry ? 1u : 0u);
    return sum;
}

// Converts a number in (-2^39, 2^39) to fixed point, in two's complement.
uvec4 to_signed_term(float value) {
    uvec4 term = to_term(abs(value));
    return value < 0.0 ? add_exactly(~term, uvec4(1u, 0u, 0u, 0u)) : term;
}
