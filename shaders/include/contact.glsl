// Surfaces in contact: those of different bodies that coincide within the error of positions, as
// the underside of a glass and the table that it stands on. The host finds them
// (src/pack/contact.rs). Roundings of t must not decide which one a ray meets first, so the order is
//   0. boundaries through which the ray leaves a dielectric,
//   1. surfaces that are no such boundary, by layer,
//   2. boundaries through which it enters a dielectric:
// bodies in contact are apart by a gap of air that has no width, from whichever side they are
// seen. Of a decal and its wall, a lamp and its ceiling, or a pane on a table, the layer says which
// is in front: on either side.

struct Ray {
    vec3 origin;
    vec3 direction;
    float begin; // t, 0 or less, from which on there may be surfaces in contact with the one that it left
    uint after;  // place in the order of the surface that it left, and TO_FRONT; or 0
    uint before; // of a ray that looks for what precedes a hit: the hit's place; else 0
};

// A ray that has left no surface in contact with others.
Ray free_ray(vec3 origin, vec3 direction) {
    return Ray(origin, direction, 0.0, 0u, 0u);
}

const uint PLACE_LAYER_SHIFT = 8u;
const uint PLACE_KEY_MASK = 255u;
const uint LAST_KEY = MAX_LAYER + 1u;
// Set where a ray leaves a surface that is no boundary on its front, on which lower layers are.
const uint TO_FRONT = 0x80000000u;

uint layer_of(uint material) {
    return material >> LAYER_SHIFT & MAX_LAYER;
}

bool is_boundary(uint material) {
    return (material & IS_BOUNDARY) != 0u;
}

// Place in the order along a ray that leaves (or enters) the inside of a primitive, from the
// primitive's material.
uint contact_place(uint material, bool leaves) {
    uint layer = layer_of(material);
    uint key = is_boundary(material) ? (leaves ? 0u : LAST_KEY) : layer;
    return layer << PLACE_LAYER_SHIFT | key;
}

// Whether two places are of surfaces in contact that are of different bodies.
bool are_in_contact(uint one, uint other) {
    uint one_layer = one >> PLACE_LAYER_SHIFT & MAX_LAYER;
    uint other_layer = other >> PLACE_LAYER_SHIFT & MAX_LAYER;
    return one_layer != 0u && other_layer != 0u && one_layer != other_layer;
}

// Whether the first of two places comes first.
bool precedes(uint first, uint second) {
    return are_in_contact(first, second) && (first & PLACE_KEY_MASK) < (second & PLACE_KEY_MASK);
}

// Whether a ray that has left a surface comes to another in contact.
bool follows(uint after, uint place) {
    uint left = after & PLACE_KEY_MASK;
    uint key = place & PLACE_KEY_MASK;
    bool in_front = key == LAST_KEY || (key > 0u && key < left);
    return are_in_contact(after, place) && ((after & TO_FRONT) != 0u ? in_front : key > left);
}

// Whether a ray meets at t a surface that is in front of the one it has left.
bool comes_from_behind(Ray ray, uint place, float t) {
    uint left = ray.after & PLACE_KEY_MASK;
    return t <= -ray.begin && left <= MAX_LAYER && (place & PLACE_KEY_MASK) > 0u && precedes(place, ray.after);
}

// Whether a ray may meet at t a primitive of this material whose inside it leaves (or enters) there.
bool may_meet(Ray ray, uint material, bool leaves, float t) {
    if (HAS_CONTACTS) {
        uint place = contact_place(material, leaves);
        bool ahead = t > 0.0 || follows(ray.after, place);
        bool wanted = ray.before == 0u || precedes(place, ray.before);
        return t > ray.begin && ahead && wanted;
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
