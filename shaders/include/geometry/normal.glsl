// Packs unit vectors into 32 bits by the octahedral map (Cigolle and others, "A Survey of Efficient
// Representations for Independent Unit Vectors", JCGT 2014).

vec2 fold(vec2 v) {
    return (1.0 - abs(v.yx)) * vec2(v.x >= 0.0 ? 1.0 : -1.0, v.y >= 0.0 ? 1.0 : -1.0);
}

uint pack_normal(vec3 n) {
    vec2 v = n.xy / (abs(n.x) + abs(n.y) + abs(n.z));
    return packSnorm2x16(n.z < 0.0 ? fold(v) : v);
}

vec3 unpack_normal(uint packed) {
    vec2 v = vec2(int(packed << 16u) >> 16, int(packed) >> 16) * (1.0 / 32767.0);
    float z = 1.0 - abs(v.x) - abs(v.y);
    vec3 n = vec3(z < 0.0 ? fold(v) : v, z);
    return n * inversesqrt(dot(n, n));
}
