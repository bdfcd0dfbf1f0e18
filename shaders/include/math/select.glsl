// Selections that compile to one instruction. min and max take three on some CPU drivers, which handle NaN
// in them; `precise` keeps a comparison and a selection from becoming min or max.

vec4 lesser(vec4 a, vec4 b) {
    precise vec4 least = mix(b, a, lessThan(a, b));
    return least;
}

vec4 greater(vec4 a, vec4 b) {
    precise vec4 most = mix(b, a, greaterThan(a, b));
    return most;
}

// A component, by its index.
uint pick(uvec4 v, uint index) {
    uint low = index == 0u ? v.x : v.y;
    uint high = index == 2u ? v.z : v.w;
    return index < 2u ? low : high;
}
