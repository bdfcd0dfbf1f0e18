// Rays against the scene: one hierarchy over every kind of primitive.
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

// A ray as triangles see it: where it is the z axis, in a shear along the longest axis of its
// direction.
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

// Cyclic, so that z is along the ray.
vec3 turn_axes(Shear shear, vec3 v) {
    return shear.along_z ? v : shear.along_y ? v.zxy : v.yzx;
}

// A corner goes to the same point in all of its triangles, and the sign of an edge function is
// right or 0, since rounding keeps the order of the two products: no ray slips through an edge
// or a corner of a closed mesh. Contracted multiply-adds would break both, hence `precise`.
// Woop and others, "Watertight Ray/Triangle Intersection", JCGT 2013.
bool intersect_triangle(Triangle triangle, Ray ray, Shear shear, inout Hit hit) {
    vec3 v0 = turn_axes(shear, triangle.p0 - ray.origin);
    vec3 v1 = turn_axes(shear, triangle.p1 - ray.origin);
    vec3 v2 = turn_axes(shear, triangle.p2 - ray.origin);
    precise vec2 a = v0.xy - shear.shear * v0.z;
    precise vec2 b = v1.xy - shear.shear * v1.z;
    precise vec2 c = v2.xy - shear.shear * v2.z;
    precise float u = c.x * a.y - c.y * a.x;
    precise float v = a.x * b.y - a.y * b.x;
    precise float w = b.x * c.y - b.y * c.x;
    bool inside = !(min(min(u, v), w) < 0.0 && max(max(u, v), w) > 0.0);
    // Where that is, the two shorter edges say, between which p0 is (src/gpu_scene/pack.rs): in needles,
    // edge functions are differences of products so large that the point would be anywhere
    // along the needle, and a ray would meet the needle that it leaves. Kept in the triangle,
    // slivers give no nonsense; those seen from the edge have no area and are not met.
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

// Whether a primitive reference in the hierarchy is a body of revolution.
bool is_body(uint primitive) {
    uint kind = primitive >> KIND_SHIFT;
    if (REVOLUTION_NEWTON || is_triangle(kind)) {
        return false;
    }
    return is_revolution(kind);
}

// Tests any other primitive; for the classical solver, a segment of a profile too.
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

// Tests what a reference in Hit names.
bool intersect_primitive(uint primitive, Ray ray, Shear shear, inout Hit hit) {
    uint index = primitive & INDEX_MASK;
    if (!is_body(primitive)) {
        return test_primitive(primitive, ray, shear, hit);
    }
    RevolutionRay turned = revolution_ray(revolution_pieces_at(index).body, ray);
    bool found = intersect_revolution(index, turned, begin_of(ray), hit.t, hit.barycentric.x);
    if (found) {
        hit.primitive = primitive;
    }
    return found;
}

// Entry of a ray into a box, or INFINITY_T. The far side is widened by the rounding
// error of three operations (Ize, "Robust BVH Ray Traversal", 2013).
float enter_box(vec3 lower, vec3 upper, Ray ray, vec3 inverse, float t_max) {
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

// Tests a body of revolution; NONE is none.
bool test_body(uint body, Ray ray, bool any_hit, inout Hit hit) {
    RevolutionRay turned = revolution_ray(body, ray);
    uint first = revolutions_at(body).first_piece;
    Pieces candidates = pieces_met(turned, first, revolutions_at(body).piece_count, begin_of(ray), hit.t);
    uint piece;
    bool found = intersect_pieces(candidates, turned, begin_of(ray), any_hit, hit.t, hit.barycentric.x, piece);
    if (found) {
        hit.primitive = REVOLUTION << KIND_SHIFT | piece;
    }
    return found;
}

// No component is zero, so that no slab computes zero times infinity.
vec3 inverse_direction(Ray ray) {
    return 1.0 / mix(ray.direction, vec3(1.0e-20), equal(ray.direction, vec3(0.0)));
}

// All bodies. Each lane goes on to the next one whose box it enters, none waits for another's.
void test_revolutions(Ray ray, bool any_hit, inout Hit hit) {
    vec3 inverse = inverse_direction(ray);
    uint bodies = 0u;
    for (uint i = 0u; i < FLAT_REVOLUTIONS; i++) {
        if (enter_box(revolutions_at(i).lower, revolutions_at(i).upper, ray, inverse, hit.t) < INFINITY_T) {
            bodies |= 1u << i;
        }
    }
    while (bodies != 0u && !(any_hit && hit.primitive != NONE)) {
        uint body = findLSB(bodies);
        bodies &= bodies - 1u;
        test_body(body, ray, any_hit, hit);
    }
}

// The same without a hierarchy, for scenes of a few primitives: every lane tests all of them,
// and none waits for another's path through a tree.
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
        test_revolutions(ray, any_hit, hit);
    }
    return hit;
}

// The nearest hit that the ray may meet with t < t_max; with any_hit, some hit. All lanes walk inner nodes
// until each has a leaf, then all test primitives (Aila and Laine 2009, "while-while"). An
// instance's hierarchy is walked on the same stack, above a mark that leads out of it.
Hit traverse(Ray ray, float t_max, bool any_hit) {
    if (IS_FLAT) {
        return test_all(ray, t_max, any_hit);
    }
    Ray local = ray; // in the space of the hierarchy
    Shear shear = shear_of(ray.direction);
    Hit hit = Hit(t_max, NONE, vec2(0.0), NONE);
    vec3 inverse = inverse_direction(ray);
    uint instance = NONE;
    uint stack[MAX_BVH_DEPTH];
    uint height = 0u;
    uint node = 0u;
    while (node != NONE) {
        while (node >> COUNT_SHIFT == 0u) {
            BvhPair pair = bvh_pairs_at(node);
            float t_left = enter_box(pair.left_lower.xyz, pair.left_upper.xyz, local, inverse, hit.t);
            float t_right = enter_box(pair.right_lower.xyz, pair.right_upper.xyz, local, inverse, hit.t);
            uint left = floatBitsToUint(pair.left_lower.w);
            uint right = floatBitsToUint(pair.right_lower.w);
            bool left_first = t_left <= t_right;
            node = left_first ? left : right;
            if (max(t_left, t_right) < INFINITY_T) {
                stack[height++] = left_first ? right : left;
            } else if (min(t_left, t_right) == INFINITY_T) {
                node = height > 0u ? stack[--height] : NONE;
            }
        }
        if (node == NONE) {
            break;
        }
        bool leaves = HAS_INSTANCES && node == LEAVE;
        uint first = node & FIRST_MASK;
        uint end = leaves ? first : first + (node >> COUNT_SHIFT);
        uint body = NONE;
        uint entered = NONE;
        for (; first < end && body == NONE && entered == NONE; first++) {
            uint primitive = primitives_at(first);
            if (is_instance(primitive >> KIND_SHIFT)) {
                entered = primitive & INDEX_MASK;
            } else if (is_body(primitive)) {
                body = primitive & INDEX_MASK;
            } else if (test_primitive(primitive, local, shear, hit)) {
                hit.instance = instance;
                if (any_hit) {
                    return hit;
                }
            }
        }
        if (HAS_REVOLUTIONS && body != NONE) {
            if (test_body(body, local, any_hit, hit)) {
                hit.instance = instance;
            }
            if (any_hit && hit.primitive != NONE) {
                return hit;
            }
        }
        uint rest = (end - first) << COUNT_SHIFT | first;
        if (HAS_INSTANCES && entered != NONE) {
            if (first < end) {
                stack[height++] = rest;
            }
            stack[height++] = LEAVE;
            node = instances_at(entered).root;
        } else if (HAS_REVOLUTIONS && first < end) {
            node = rest;
        } else {
            node = height > 0u ? stack[--height] : NONE;
        }
        if (HAS_INSTANCES && (leaves || entered != NONE)) {
            instance = entered;
            local = ray;
            if (entered != NONE) {
                local = enter_instance(entered, ray);
            }
            shear = shear_of(local.direction);
            inverse = inverse_direction(local);
        }
    }
    return hit;
}
