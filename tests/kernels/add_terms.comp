// add_terms: converts radiances to terms, and adds each term to a sum.
#version 460
#include "kernel/invocation.glsl"
#include "math/sum.glsl"

BUFFER(float, values)
BUFFER(uvec4, sums)
UPDATED_BUFFER(uvec4, terms)
UPDATED_BUFFER(uvec4, totals)

void main() {
    uint i = invocation_index();
    if (i >= values.data.length()) {
        return;
    }
    terms.data[i] = to_signed_term(values.data[i]);
    totals.data[i] = add_exactly(sums.data[i], terms.data[i]);
}
