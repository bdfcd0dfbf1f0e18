// Intersects rays with the scene: one bounding volume hierarchy over all kinds of primitives.
#include "geometry/contact.glsl"
#include "geometry/hit.glsl"
#include "geometry/instance.glsl"
#include "geometry/quadric.glsl"
#include "revolution/newton.glsl"
#include "revolution/ray.glsl"
#include "revolution/revolution.glsl"
#include "revolution/rings.glsl"
#include "scene/constants.glsl"
#include "scene/features.glsl"
#include "scene/primitives.glsl"
#include "scene/scene.glsl"

// The shear that makes a ray the z axis. z is the longest axis of its direction.
struct Shear {
    bool along_z;
    bool along_y; // else along x
    float inverse;
    vec2 shear;
};

Shear shear_of(vec3 d) {
    vec3 size = abs(d);
    Shear shear;
    shear.along_z = size.z >= size.x && size.z >= size.y;
    shear.along_y = !shear.along_z && size.y >= size.x;
    shear.inverse = 1.0 / (shear.along_z ? d.z : shear.along_y ? d.y : d.x);
    shear.shear = (shear.along_z ? d.xy : shear.along_y ? d.zx : d.yz) * shear.inverse;
    return shear;
}

// Permutes axes cyclically, so that z is the longest axis of the ray's direction.
vec3 permute_axes(Shear shear, vec3 v) {
    return shear.along_z ? v : shear.along_y ? v.zxy : v.yzx;
}

// Intersects a triangle without gaps at its edges (Woop and others, "Watertight Ray/Triangle
// Intersection", JCGT 2013). A vertex is sheared to the same point in all of its triangles, and the
// sign of an edge function is right or 0, since rounding keeps the order of the two products: no ray
// slips through an edge or a vertex of a closed mesh. `precise` forbids fused multiply-adds, which
// would break both.
bool intersect_triangle(Triangle triangle, Ray ray, Shear shear, inout Hit hit) {
    vec3 v0 = permute_axes(shear, triangle.p0 - ray.origin);
    vec3 v1 = permute_axes(shear, triangle.p1 - ray.origin);
    vec3 v2 = permute_axes(shear, triangle.p2 - ray.origin);
    precise vec2 a = v0.xy - shear.shear * v0.z;
    precise vec2 b = v1.xy - shear.shear * v1.z;
    precise vec2 c = v2.xy - shear.shear * v2.z;
    precise float u = c.x * a.y - c.y * a.x;
    precise float v = a.x * b.y - a.y * b.x;
    precise float w = b.x * c.y - b.y * c.x;
    bool inside = !(min(min(u, v), w) < 0.0 && max(max(u, v), w) > 0.0);
    // The hit point comes from the two shorter edges, which meet at p0 (src/gpu_scene/pack.rs). In
    // needles, edge functions are differences of large products: by these the point would be anywhere
    // along the needle, and a ray would meet the needle that it leaves. Clamping keeps the point of a
    // sliver in the triangle. A triangle seen edge-on has no area and is not met.
    vec2 ab = b - a;
    vec2 ac = c - a;
    float area = ab.x * ac.y - ab.y * ac.x;
    float per_area = 1.0 / area;
    float to_p1 = clamp((a.y * ac.x - a.x * ac.y) * per_area, 0.0, 1.0);
    float to_p2 = clamp((a.x * ab.y - a.y * ab.x) * per_area, 0.0, 1.0 - to_p1);
    float t = (v0.z + to_p1 * (v1.z - v0.z) + to_p2 * (v2.z - v0.z)) * shear.inverse;
    bool leaves = (area > 0.0) == (shear.inverse > 0.0);
    if (!(inside && area != 0.0 && may_meet(ray, triangle.material, leaves, t) && t < hit.t)) {
        return false;
    }
    hit.t = t;
    hit.barycentric = vec2(to_p1, to_p2);
    return true;
}

bool intersect_quadric(uint index, bool sphere, Ray ray, inout Hit hit) {
    Quadric quadric = quadrics_at(index);
    Ray local = ray_in(quadric.object_from_render, ray);
    return sphere ? intersect_sphere(quadric, local, hit.t) : intersect_disk(quadric, local, hit.t);
}

// Whether a primitive reference in the hierarchy is a body of revolution for the solver that renders.
bool is_body(uint primitive) {
    uint kind = primitive >> KIND_SHIFT;
    if (REVOLUTION_NEWTON || is_triangle(kind)) {
        return false;
    }
    return is_revolution(kind);
}

// Tests a primitive that is not such a body. For the classical solver that is also a segment of a
// profile.
bool test_primitive(uint primitive, Ray ray, Shear shear, inout Hit hit) {
    uint kind = primitive >> KIND_SHIFT;
    uint index = primitive & INDEX_MASK;
    bool found = false;
    if (is_triangle(kind)) {
        found = intersect_triangle(triangles_at(index), ray, shear, hit);
    } else if (REVOLUTION_NEWTON && is_revolution(kind)) {
        found = meet_segment(index, ray, hit, primitive);
    } else if (HAS_QUADRICS) {
        found = intersect_quadric(index, is_sphere(kind), ray, hit);
    }
    if (found) {
        hit.primitive = primitive;
    }
    return found;
}

// Tests one primitive, named by a reference as in Hit.
bool intersect_primitive(uint primitive, Ray ray, Shear shear, inout Hit hit) {
    uint index = primitive & INDEX_MASK;
    if (!is_body(primitive)) {
        return test_primitive(primitive, ray, shear, hit);
    }
    RevolutionRay body_ray = revolution_ray(revolution_pieces_at(index).body, ray);
    bool found = intersect_revolution(index, body_ray, begin_of(ray), hit.t, hit.barycentric.x);
    if (found) {
        hit.primitive = primitive;
    }
    return found;
}

// Returns the t at which a ray enters a box, or INFINITY_T if it misses the box. The far side is
// widened by the rounding error of three operations (Ize, "Robust BVH Ray Traversal", 2013).
float intersect_box(vec3 lower, vec3 upper, Ray ray, vec3 inverse, float t_max) {
    vec3 a = (lower - ray.origin) * inverse;
    vec3 b = (upper - ray.origin) * inverse;
    vec3 near = min(a, b);
    vec3 far = max(a, b);
    if (HAS_CONTACTS) {
        far += abs(far) * (8.0 * ROUNDING);
    } else {
        far *= 1.0 + 8.0 * ROUNDING;
    }
    float t_near = max(max(near.x, near.y), max(near.z, begin_of(ray)));
    float t_far = min(min(far.x, far.y), min(far.z, t_max));
    return t_near <= t_far ? t_near : INFINITY_T;
}

// Tests all pieces of a body of revolution.
bool test_body(uint body, Ray ray, bool any_hit, inout Hit hit) {
    RevolutionRay body_ray = revolution_ray(body, ray);
    uint first = revolutions_at(body).first_piece;
    Pieces candidates = pieces_met(body_ray, first, revolutions_at(body).piece_count, begin_of(ray), hit.t);
    uint piece;
    bool found = intersect_pieces(candidates, body_ray, begin_of(ray), any_hit, hit.t, hit.barycentric.x, piece);
    if (found) {
        hit.primitive = REVOLUTION << KIND_SHIFT | piece;
    }
    return found;
}

// 1 over the direction. Components of 0 become tiny, so that no slab test computes 0 times infinity.
vec3 inverse_direction(Ray ray) {
    return 1.0 / mix(ray.direction, vec3(1.0e-20), equal(ray.direction, vec3(0.0)));
}

// Tests all bodies. Each lane visits only those whose boxes it enters, without waiting for other lanes.
void test_all_bodies(Ray ray, bool any_hit, inout Hit hit) {
    vec3 inverse = inverse_direction(ray);
    uint bodies = 0u;
    for (uint i = 0u; i < FLAT_REVOLUTIONS; i++) {
        if (intersect_box(revolutions_at(i).lower, revolutions_at(i).upper, ray, inverse, hit.t) < INFINITY_T) {
            bodies |= 1u << i;
        }
    }
    while (bodies != 0u && !(any_hit && hit.primitive != NONE)) {
        uint body = findLSB(bodies);
        bodies &= bodies - 1u;
        test_body(body, ray, any_hit, hit);
    }
}

// As traverse, but without a hierarchy, for scenes of a few primitives: every lane tests all of them,
// so that lanes do not diverge.
Hit test_all(Ray ray, float t_max, bool any_hit) {
    Hit hit = Hit(t_max, NONE, vec2(0.0), NONE);
    Shear shear = shear_of(ray.direction);
    for (uint i = 0u; i < FLAT_TRIANGLES; i++) {
        if (intersect_triangle(triangles_at(i), ray, shear, hit)) {
            hit.primitive = TRIANGLE << KIND_SHIFT | i;
        }
    }
    for (uint i = 0u; i < FLAT_QUADRICS; i++) {
        uint kind = quadrics_at(i).kind;
        if (intersect_quadric(i, is_sphere(kind), ray, hit)) {
            hit.primitive = kind << KIND_SHIFT | i;
        }
    }
    if (HAS_REVOLUTIONS) {
        test_all_bodies(ray, any_hit, hit);
    }
    return hit;
}

// The space that a ray is traced in: render space, or that of an instance's object.
struct Space {
    Ray ray;       // in that space
    Shear shear;   // of the ray
    vec3 inverse;  // of the ray's direction
    uint instance; // NONE for render space
};

// Takes a ray in render space into an instance, or leaves it there for NONE.
Space enter_space(uint instance, Ray ray) {
    Ray local = ray;
    if (HAS_INSTANCES && instance != NONE) {
        local = ray_into_instance(instance, ray);
    }
    return Space(local, shear_of(local.direction), inverse_direction(local), instance);
}

// The children of an inner node in the order in which a ray enters their boxes. A t is INFINITY_T if
// the ray misses that box.
struct Children {
    uint near;
    uint far;
    float t_near;
    float t_far;
};

Children sort_children(uint node, Space space, float t_max) {
    BvhPair pair = bvh_pairs_at(node);
    float t_left = intersect_box(pair.left_lower.xyz, pair.left_upper.xyz, space.ray, space.inverse, t_max);
    float t_right = intersect_box(pair.right_lower.xyz, pair.right_upper.xyz, space.ray, space.inverse, t_max);
    uint left = floatBitsToUint(pair.left_lower.w);
    uint right = floatBitsToUint(pair.right_lower.w);
    bool left_first = t_left <= t_right;
    return Children(left_first ? left : right, left_first ? right : left, min(t_left, t_right), max(t_left, t_right));
}

// The primitives of a leaf that are still to be tested, and the body or instance found among them.
struct Leaf {
    uint first;
    uint end;
    uint body;     // index into revolutions, or NONE
    uint instance; // index into instances, or NONE
};

// Tests the primitives of a leaf up to a body or an instance, or with any_hit up to a hit: all lanes
// then test bodies together.
void test_leaf(inout Leaf leaf, Space space, bool any_hit, inout Hit hit) {
    bool found = false;
    for (; leaf.first < leaf.end && leaf.body == NONE && leaf.instance == NONE && !(any_hit && found); leaf.first++) {
        uint primitive = primitives_at(leaf.first);
        if (is_instance(primitive >> KIND_SHIFT)) {
            leaf.instance = primitive & INDEX_MASK;
        } else if (is_body(primitive)) {
            leaf.body = primitive & INDEX_MASK;
        } else if (test_primitive(primitive, space.ray, space.shear, hit)) {
            hit.instance = space.instance;
            found = true;
        }
    }
}

// Traces a ray through the hierarchy. Returns the nearest hit with t < t_max that the ray may meet, or
// any such hit with any_hit. All lanes visit inner nodes until each has a leaf, then all test
// primitives (Aila and Laine 2009, "while-while"). The hierarchy of an instance uses the same stack,
// above an entry LEAVE that ends its traversal.
Hit traverse(Ray ray, float t_max, bool any_hit) {
    if (IS_FLAT) {
        return test_all(ray, t_max, any_hit);
    }
    Space space = enter_space(NONE, ray);
    Hit hit = Hit(t_max, NONE, vec2(0.0), NONE);
    uint stack[MAX_BVH_DEPTH];
    uint height = 0u;
    uint node = 0u;
    while (node != NONE) {
        while (node >> COUNT_SHIFT == 0u) {
            Children children = sort_children(node, space, hit.t);
            node = children.near;
            if (children.t_far < INFINITY_T) {
                stack[height++] = children.far;
            } else if (children.t_near == INFINITY_T) {
                node = height > 0u ? stack[--height] : NONE;
            }
        }
        if (node == NONE) {
            break;
        }
        bool leaves = HAS_INSTANCES && node == LEAVE;
        uint first = node & FIRST_MASK;
        Leaf leaf = Leaf(first, leaves ? first : first + (node >> COUNT_SHIFT), NONE, NONE);
        test_leaf(leaf, space, any_hit, hit);
        if (HAS_REVOLUTIONS && leaf.body != NONE) {
            if (test_body(leaf.body, space.ray, any_hit, hit)) {
                hit.instance = space.instance;
            }
        }
        if (any_hit && hit.primitive != NONE) {
            return hit;
        }
        uint rest = (leaf.end - leaf.first) << COUNT_SHIFT | leaf.first;
        if (HAS_INSTANCES && leaf.instance != NONE) {
            if (leaf.first < leaf.end) {
                stack[height++] = rest;
            }
            stack[height++] = LEAVE;
            node = instances_at(leaf.instance).root;
        } else if (HAS_REVOLUTIONS && leaf.first < leaf.end) {
            node = rest;
        } else {
            node = height > 0u ? stack[--height] : NONE;
        }
        if (HAS_INSTANCES && (leaves || leaf.instance != NONE)) {
            space = enter_space(leaf.instance, ray);
        }
    }
    return hit;
}
