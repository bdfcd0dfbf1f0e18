// Surfaces in contact: those of different bodies that coincide within the error of positions, as
// the underside of a glass and the table that it stands on. The host finds them
// (src/gpu_scene/pack/contact.rs). Roundings of t must not decide which one a ray meets first, so the order is
//   0. boundaries through which the ray leaves a dielectric,
//   1. surfaces that are no such boundary, by layer,
//   2. boundaries through which it enters a dielectric:
// bodies in contact are apart by a gap of air that has no width, from whichever side they are
// seen. Of a decal and its wall, a lamp and its ceiling, or a pane on a table, the layer says which
// is in front: on either side.
#include "scene/constants.glsl"
#include "scene/features.glsl"
#include "scene/primitives.glsl"

struct Ray {
    vec3 origin;
    vec3 direction;
    float begin;     // t, 0 or less, from which on the ray may meet surfaces in contact with the one that it left
    float otherwise; // the same for all others: 0, or INFINITY_T to meet none of them
    uint exits;      // layers of the surfaces in contact that it may meet where it leaves their inside
    uint entries;    // and where it enters it
    bool to_front;   // it left a sheet on its front, where lower layers are
};

// A ray that has left no surface in contact with others.
Ray free_ray(vec3 origin, vec3 direction) {
    return Ray(origin, direction, 0.0, 0.0, 0u, 0u, false);
}

// What a ray may meet of surfaces in contact, in one word; and a ray from that. Layers are in the
// upper twelve bits of a word.
uint contacts_of(Ray ray) {
    if (HAS_CONTACTS) {
        return ray.exits | ray.entries >> 12u | (ray.to_front ? 1u : 0u);
    }
    return 0u;
}

Ray saved_ray(vec3 origin, vec3 direction, float begin, uint contacts) {
    if (HAS_CONTACTS) {
        uint layers = ~MATERIAL_MASK;
        return Ray(origin, direction, begin, 0.0, contacts & layers, contacts << 12u & layers, (contacts & 1u) != 0u);
    }
    return free_ray(origin, direction);
}

uint layer_of(uint material) {
    return material & ~MATERIAL_MASK;
}

bool is_boundary(uint layer) {
    return (layer & BOUNDARY_LAYERS) != 0u;
}

// Whether a ray may meet at t a primitive of this material whose inside it leaves (or enters) there.
bool may_meet(Ray ray, uint material, bool leaves, float t) {
    if (HAS_CONTACTS) {
        uint layers = leaves ? ray.exits : ray.entries;
        return t > ((material & layers) != 0u ? ray.begin : ray.otherwise);
    }
    return t > 0.0;
}

// The least t at which a ray may meet anything.
float begin_of(Ray ray) {
    if (HAS_CONTACTS) {
        return ray.begin;
    }
    return 0.0;
}

// Has a ray that leaves a surface meet what follows that in the order.
void meet_followers(inout Ray ray, uint layer, bool leaves, bool to_front) {
    uint sheets = layer != 0u ? SHEET_LAYERS : 0u;
    uint boundaries = layer != 0u ? BOUNDARY_LAYERS & ~layer : 0u;
    if (is_boundary(layer)) {
        sheets = leaves ? sheets : 0u;
        boundaries = leaves ? boundaries : 0u;
    } else {
        sheets &= to_front ? layer - 1u : ~(layer | (layer - 1u));
    }
    ray.exits = sheets;
    ray.entries = sheets | boundaries;
    ray.to_front = to_front;
}

// Has a ray meet nothing but what precedes a surface in the order, if there may be any of that; in
// front of that surface, but not where the ray has just left another, what follows that.
bool meet_preceding(inout Ray ray, uint layer, bool leaves, bool is_close) {
    bool precede = layer != 0u && !(is_boundary(layer) && leaves);
    uint sheets = is_boundary(layer) ? SHEET_LAYERS : SHEET_LAYERS & (layer - 1u);
    uint boundaries = BOUNDARY_LAYERS & ~layer;
    ray.exits = (sheets | boundaries) & (is_close ? ray.exits : ~0u);
    ray.entries = sheets & (is_close ? ray.entries : ~0u);
    ray.otherwise = INFINITY_T;
    return precede;
}
