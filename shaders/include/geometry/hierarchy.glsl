// The hierarchy that rays walk: its inner nodes, and the place that a ray has come to in it.
#include "geometry/contact.glsl"
#include "geometry/instance.glsl"
#include "geometry/intersect.glsl"
#include "math/select.glsl"
#include "scene/constants.glsl"
#include "scene/features.glsl"
#include "scene/primitives.glsl"
#include "scene/scene.glsl"

// The space that a ray is traced in: render space, or that of an instance's object.
struct Space {
    Ray ray;       // in that space
    Shear shear;   // of the ray
    vec3 inverse;  // of the ray's direction
    uvec3 near;    // first_planes, unless FEW_REGISTERS
    uint instance; // NONE for render space
};

// Of a node's planes, those that a ray crosses first, per axis.
uvec3 first_planes(vec3 inverse) {
    return uvec3(0u, 1u, 2u) + mix(uvec3(0u), uvec3(3u), lessThan(inverse, vec3(0.0)));
}

// Takes a ray in render space into an instance, or leaves it there for NONE.
Space enter_space(uint instance, Ray ray) {
    Ray local = ray;
    if (HAS_INSTANCES && instance != NONE) {
        local = ray_into_instance(instance, ray);
    }
    vec3 inverse = inverse_direction(local);
    return Space(local, shear_of(local.direction), inverse, first_planes(inverse), instance);
}

// The children of a node that a ray enters, nearest first.
struct Entered {
    uint first; // reference to the nearest one
    uint count; // of them
    uint order; // their slots, two bits each, from the lowest on
};

// Sorts two keys.
void sort(inout uint a, inout uint b) {
    uint least = min(a, b);
    b = max(a, b);
    a = least;
}

// Finds the children of an inner node that a ray enters before t_max.
Entered enter_children(uint node, Space space, float t_max) {
    vec3 o = space.ray.origin;
    vec3 inverse = space.inverse;
    uint planes = node * BVH_PLANES;
    uvec3 near = space.near;
    if (FEW_REGISTERS) {
        near = first_planes(inverse);
    }
    uvec3 far = uvec3(3u, 5u, 7u) - near;
    vec4 x0 = (bvh_planes_at(planes + near.x) - o.x) * inverse.x;
    vec4 y0 = (bvh_planes_at(planes + near.y) - o.y) * inverse.y;
    vec4 z0 = (bvh_planes_at(planes + near.z) - o.z) * inverse.z;
    vec4 x1 = (bvh_planes_at(planes + far.x) - o.x) * inverse.x;
    vec4 y1 = (bvh_planes_at(planes + far.y) - o.y) * inverse.y;
    vec4 z1 = (bvh_planes_at(planes + far.z) - o.z) * inverse.z;
    vec4 t_near = greater(greater(x0, y0), greater(z0, vec4(begin_of(space.ray))));
    vec4 t_far = lesser(lesser(x1, y1), z1);
    t_far = lesser(vec4(widen(t_far.x), widen(t_far.y), widen(t_far.z), widen(t_far.w)), vec4(t_max));
    bvec4 enters = lessThanEqual(t_near, t_far);
    // Keys sort as the t do; the lowest bits, which hardly matter, are the slot.
    uvec4 keys = floatBitsToUint(greater(t_near, vec4(0.0))) & ~3u;
    keys = mix(uvec4(~3u), keys, enters) | uvec4(0u, 1u, 2u, 3u);
    sort(keys.x, keys.y);
    sort(keys.z, keys.w);
    sort(keys.x, keys.z);
    sort(keys.y, keys.w);
    sort(keys.y, keys.z);
    uvec4 entered = mix(uvec4(0u), uvec4(1u), enters);
    uvec4 slots = keys & 3u;
    uvec4 children = bvh_children_at(node);
    return Entered(pick(children, slots.x), entered.x + entered.y + entered.z + entered.w,
                   slots.x | slots.y << 2u | slots.z << 4u | slots.w << 6u);
}

// A group is a run of children of one node, in the order in which a ray enters them: the node, then the
// slots of up to three of them, two bits each, then their number in two bits. 0 is an empty group.
uint group_of(uint node, uint order, uint count) {
    return count == 0u ? 0u : node << 8u | (order & 0x3fu) << 2u | count;
}

// Takes the first child out of a group that is not empty, and returns the reference to it.
uint take_child(inout uint group) {
    uint child = pick(bvh_children_at(group >> 8u), group >> 2u & 3u);
    group = group_of(group >> 8u, group >> 4u & 0xfu, (group & 3u) - 1u);
    return child;
}
