// Surfaces in contact: surfaces of different bodies that coincide within the error of positions, such as
// the underside of a glass and the table that it stands on. The host finds them
// (src/gpu_scene/pack/contact.rs). Rounding of t must not decide which of them a ray meets first. The
// order is
//   0. boundaries through which the ray leaves a dielectric,
//   1. sheets, which are surfaces that bound no dielectric, by layer,
//   2. boundaries through which the ray enters a dielectric.
// So bodies in contact are separated by a gap of air without width, seen from any side. The layer tells
// which of two sheets is in front, for rays from either side: a decal before its wall, a lamp before its
// ceiling, a pane on a table.
#include "scene/constants.glsl"
#include "scene/features.glsl"
#include "scene/media.glsl"
#include "scene/primitives.glsl"

struct Ray {
    vec3 origin;
    vec3 direction;
    float begin;     // least t, 0 or less, of surfaces in contact with the surface that the ray left
    float otherwise; // least t of all other surfaces: 0, or INFINITY_T to exclude them
    uint exits;      // layers of the surfaces in contact that the ray may meet from their inside
    uint entries;    // layers of the surfaces in contact that the ray may meet from their outside
    bool to_front;   // the ray left a sheet on its front, where sheets of lower layers are
    uint medium;     // HAS_MEDIA: index of the medium that the ray starts in
    bool is_endless; // HAS_MEDIA: the ray asks about a light that is infinitely far away
};

// A ray that starts at no surface in contact with others.
Ray free_ray(vec3 origin, vec3 direction) {
    return Ray(origin, direction, 0.0, 0.0, 0u, 0u, false, VACUUM, false);
}

// Packs the layers that a ray may meet, and its side of a sheet, into one word; saved_ray unpacks them.
// Layers are the upper twelve bits of a word.
uint contacts_of(Ray ray) {
    if (HAS_CONTACTS) {
        return ray.exits | ray.entries >> 12u | (ray.to_front ? 1u : 0u);
    }
    return 0u;
}

Ray saved_ray(vec3 origin, vec3 direction, float begin, uint contacts, uint medium) {
    Ray ray = free_ray(origin, direction);
    ray.medium = medium;
    if (HAS_CONTACTS) {
        uint layers = ~MATERIAL_MASK;
        ray.begin = begin;
        ray.exits = contacts & layers;
        ray.entries = contacts << 12u & layers;
        ray.to_front = (contacts & 1u) != 0u;
    }
    return ray;
}

uint layer_of(uint material) {
    return material & ~MATERIAL_MASK;
}

bool is_boundary(uint layer) {
    return (layer & BOUNDARY_LAYERS) != 0u;
}

// Whether a ray may meet a primitive of this material at t. `leaves`: the ray comes from its inside.
bool may_meet(Ray ray, uint material, bool leaves, float t) {
    if (HAS_CONTACTS) {
        uint layers = leaves ? ray.exits : ray.entries;
        return t > ((material & layers) != 0u ? ray.begin : ray.otherwise);
    }
    return t > 0.0;
}

// The least t at which a ray may meet a surface.
float begin_of(Ray ray) {
    if (HAS_CONTACTS) {
        return ray.begin;
    }
    return 0.0;
}

// Restricts a ray that starts at a surface: of surfaces in contact, it may meet those that follow this
// surface in the order.
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

// Restricts a ray to the surfaces that precede a given surface in the order. Returns false if there can be
// none. `is_close`: the ray started at another surface in contact, so that the restriction by that
// surface holds as well.
bool meet_preceding(inout Ray ray, uint layer, bool leaves, bool is_close) {
    bool precede = layer != 0u && !(is_boundary(layer) && leaves);
    uint sheets = is_boundary(layer) ? SHEET_LAYERS : SHEET_LAYERS & (layer - 1u);
    uint boundaries = BOUNDARY_LAYERS & ~layer;
    ray.exits = (sheets | boundaries) & (is_close ? ray.exits : ~0u);
    ray.entries = sheets & (is_close ? ray.entries : ~0u);
    ray.otherwise = INFINITY_T;
    return precede;
}
