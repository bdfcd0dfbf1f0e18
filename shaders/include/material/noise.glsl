// Gradient noise, and what textures make of it. Kernels of scenes without such textures leave out this code.
// Perlin, "Improving Noise", SIGGRAPH 2002, with the gradients of pbrt-v4: src/gpu_scene/pack/noise.rs.
#include "math/sampling.glsl"
#include "scene/materials.glsl"
#include "scene/scene.glsl"

// The product of a gradient and an offset. Of the gradient's coordinates, one is 0 and the others are 1 or -1.
float slope_along(uint gradient, vec3 offset) {
    float a = gradient < 8u ? offset.x : offset.y;
    float b = gradient < 4u ? offset.y : offset.z;
    a = (gradient & 1u) != 0u ? -a : a;
    b = (gradient & 2u) != 0u ? -b : b;
    return a + b;
}

// Along an edge of a cell in z: `hash` is that of the edge's x and y, `offset` is from its lower end.
float edge_noise(uint table, uint hash, vec3 offset, float weight) {
    uvec2 gradients = texture_texels_at(table + (hash & 255u)).zw;
    float lower = slope_along(gradients.x, offset);
    float upper = slope_along(gradients.y, offset - vec3(0.0, 0.0, 1.0));
    return mix(lower, upper, weight);
}

// Noise at a point, in about [-1, 1]: 0 where all coordinates are whole, and with a period of 256 in each of them.
float noise(uint table, vec3 p) {
    vec3 corner = floor(p);
    // In [0, 1]. If it were computed from the factors of p, it would miss the rounding of p.
    precise vec3 offset = p - corner;
    // Without an error: 256 is a power of two. Points that are NaN have any cell.
    uvec3 cell = uvec3(corner - 256.0 * floor(corner / 256.0)) & 255u;
    vec3 weight = offset * offset * offset * (offset * (offset * 6.0 - 15.0) + 10.0);
    uvec2 by_x = texture_texels_at(table + cell.x).xy + cell.y;
    uvec2 left = texture_texels_at(table + (by_x.x & 255u)).xy + cell.z;
    uvec2 right = texture_texels_at(table + (by_x.y & 255u)).xy + cell.z;
    float near_left = edge_noise(table, left.x, offset, weight.z);
    float near_right = edge_noise(table, right.x, offset - vec3(1.0, 0.0, 0.0), weight.z);
    float far_left = edge_noise(table, left.y, offset - vec3(0.0, 1.0, 0.0), weight.z);
    float far_right = edge_noise(table, right.y, offset - vec3(1.0, 1.0, 0.0), weight.z);
    return mix(mix(near_left, near_right, weight.x), mix(far_left, far_right, weight.x), weight.y);
}

// The sum of a node's octaves. Textures have no footprint here: none of the octaves is left out.
float sum_of_octaves(TextureNode node, vec3 p) {
    float sum = 0.0;
    float frequency = 1.0;
    float weight = 1.0;
    for (uint i = 0u; i < node.width; i++) {
        float value = noise(node.first, frequency * p);
        sum += weight * (node.kind == TEXTURE_WRINKLED ? abs(value) : value);
        frequency *= 1.99;
        weight *= node.values[0].x;
    }
    // What pbrt-v4 adds for the next octave, as the mean of its magnitude.
    return node.kind == TEXTURE_WRINKLED ? sum + 0.2 * weight : sum;
}

// The weight of a control point in a cubic Bezier curve.
float bezier_weight(int i, float u) {
    float v = 1.0 - u;
    float inner = i == 1 ? 3.0 * u * v * v : 3.0 * u * u * v;
    float outer = i == 0 ? v * v * v : u * u * u;
    return i < 0 || i > 3 ? 0.0 : i == 1 || i == 2 ? inner : outer;
}

// pbrt-v4's color of marble at a phase in radians. Six cubic Bezier curves follow each other, each from four of nine
// control points, and the next starts one point later. Only the points 3, 4 and 7 differ from the others.
vec3 marble_color(float phase) {
    // Devices compute sines of small arguments only.
    phase -= 2.0 * PI * floor(phase / (2.0 * PI) + 0.5);
    float at = clamp(3.0 + 3.0 * sin(phase), 0.0, 6.0);
    int curve = clamp(int(at), 0, 5);
    float u = at - float(curve);
    vec3 color = vec3(0.58, 0.58, 0.6);
    color += bezier_weight(3 - curve, u) * vec3(-0.08, -0.08, -0.1);
    color += bezier_weight(4 - curve, u) * vec3(0.02, 0.01, -0.02);
    color += bezier_weight(7 - curve, u) * vec3(-0.38, -0.38, -0.27);
    return 1.5 * color;
}

// The value of a node that sums octaves.
vec3 noise_value(TextureNode node, vec3 at) {
    float sum = sum_of_octaves(node, at);
    if (node.kind == TEXTURE_MARBLE) {
        return marble_color(at.y + node.values[1].x * sum);
    }
    return vec3(node.kind == TEXTURE_WIND ? abs(sum) : sum);
}

// Whether a point is in a disc of pbrt's `dots`: a unit square about a whole point has one where the noise says so.
bool is_in_dot(uint table, vec2 at) {
    vec2 square = floor(at + 0.5);
    if (noise(table, vec3(square + 0.5, 0.5)) <= 0.0) {
        return false;
    }
    float x = noise(table, vec3(square + vec2(1.5, 2.8), 0.5));
    float y = noise(table, vec3(square + vec2(4.5, 9.8), 0.5));
    vec2 from_center = at - square - 0.15 * vec2(x, y);
    return dot(from_center, from_center) < 0.35 * 0.35;
}
