// Guided emission: warps the numbers by which a photon begins, so that more photons begin where they bring light to
// visible points.
//
// The density of the warped numbers is constant in each leaf of a binary tree over the unit cube of six dimensions,
// which the host learns (src/render/guide). An inner node splits its cell along one axis. Along it, the numbers go
// through the inverse of a cumulative distribution, which keeps evenly spread numbers evenly spread.
#include "math/random.glsl"
#include "scene/constants.glsl"
#include "scene/features.glsl"

// A node of the tree. The root is the first.
struct GuideNode {
    uint axis;   // that an inner node splits: 0 and 1 of light, 2 and 3 of position, 4 and 5 of direction; or LEAF
    uint lower;  // inner node: the node of the lower part; that of the upper part is next
    float at;    // inner node: where it splits, as a share of its extent, in (0, 1)
    float value; // inner node: chance of the lower part, in (0, 1); leaf: 1 over the density
};

export const uint GUIDE_LEAF = 6u; // in place of the axis of an inner node: the node is a leaf

// The numbers by which a photon begins, each in [0, 1).
struct EmissionNumbers {
    vec2 light;     // the light; the side or the face
    vec2 position;  // a point on the light
    vec2 direction; // a direction
    float weight;   // 1 over their density
    uint pad;       // unused
};

// A light in the order of the guide, in which neighbours are near each other.
struct GuideLight {
    float end;  // chance of this light and of those before it
    uint light; // index into lights
    uint pad0;  // unused
    uint pad1;  // unused
};

TEXELS(GuideNode, guide_nodes)
TEXELS(GuideLight, guide_lights)

// The largest number below 1.
const float BELOW_ONE = 0.99999994;

// Warps numbers by the tree.
EmissionNumbers guide(EmissionNumbers numbers) {
    // The numbers within the cell that the descent has got to, and the cell's lower corner and extent.
    vec3 u0 = vec3(numbers.light, numbers.position.x);
    vec3 u1 = vec3(numbers.position.y, numbers.direction);
    vec3 corner0 = vec3(0.0);
    vec3 corner1 = vec3(0.0);
    vec3 extent0 = vec3(1.0);
    vec3 extent1 = vec3(1.0);
    GuideNode node = guide_nodes_at(0u);
    while (node.axis < GUIDE_LEAF) {
        bvec3 is0 = equal(uvec3(node.axis), uvec3(0u, 1u, 2u));
        bvec3 is1 = equal(uvec3(node.axis), uvec3(3u, 4u, 5u));
        vec3 along0 = vec3(is0);
        vec3 along1 = vec3(is1);
        float u = dot(u0, along0) + dot(u1, along1);
        float extent = dot(extent0, along0) + dot(extent1, along1);
        bool is_lower = u < node.value;
        float within = min(is_lower ? u / node.value : (u - node.value) / (1.0 - node.value), BELOW_ONE);
        float offset = is_lower ? 0.0 : node.at * extent;
        float scale = is_lower ? node.at : 1.0 - node.at;
        u0 = mix(u0, vec3(within), is0);
        u1 = mix(u1, vec3(within), is1);
        corner0 += along0 * offset;
        corner1 += along1 * offset;
        extent0 *= mix(vec3(1.0), vec3(scale), is0);
        extent1 *= mix(vec3(1.0), vec3(scale), is1);
        node = guide_nodes_at(is_lower ? node.lower : node.lower + 1u);
    }
    vec3 warped0 = min(corner0 + u0 * extent0, vec3(BELOW_ONE));
    vec3 warped1 = min(corner1 + u1 * extent1, vec3(BELOW_ONE));
    return EmissionNumbers(warped0.xy, vec2(warped0.z, warped1.x), warped1.yz, numbers.weight * node.value, 0u);
}

// Samples a light of `count` by its power, in the order of the guide.
uint sample_guide_light(float u, uint count) {
    uint first = 0u;
    for (uint last = count - 1u; first < last;) {
        uint middle = (first + last) / 2u;
        bool is_before = u >= guide_lights_at(middle).end;
        first = is_before ? middle + 1u : first;
        last = is_before ? last : middle;
    }
    return guide_lights_at(first).light;
}

// The numbers by which the photon of a path begins: the first three pairs of the path.
EmissionNumbers emission_numbers(Random random) {
    EmissionNumbers numbers =
        EmissionNumbers(random_pair(random, 0u), random_pair(random, 1u), random_pair(random, 2u), 1.0, 0u);
    if (HAS_GUIDE) {
        numbers = guide(numbers);
    }
    return numbers;
}
