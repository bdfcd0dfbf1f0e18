// Rays against the scene: one hierarchy over every kind of primitive.
#include "quadric.glsl"

const float INFINITY_T = 3.0e38;
// Half a unit in the last place of 1: the largest relative rounding error.
const float ROUNDING = 5.9604644775390625e-8; // 2^-24

struct Ray {
    vec3 origin;
    vec3 direction;
};

struct Hit {
    float t;          // in lengths of the ray's direction
    uint primitive;   // reference, or NONE
    vec2 barycentric; // weights of p1 and p2 of a triangle
};

// Pluecker test: the edge functions of neighbours are exact negatives of each other,
// also where a device contracts multiply-adds, so no ray slips between two triangles.
// Davidovic and others, "3D Rasterization: A Bridge between Rasterization and Ray
// Casting", 2012.
bool intersect_triangle(Triangle triangle, Ray ray, inout Hit hit) {
    vec3 v0 = triangle.p0 - ray.origin;
    vec3 v1 = triangle.p1 - ray.origin;
    vec3 v2 = triangle.p2 - ray.origin;
    vec3 e0 = v2 - v0;
    vec3 e1 = v0 - v1;
    vec3 e2 = v1 - v2;
    float u = dot(cross(e0, v2 + v0), ray.direction);
    float v = dot(cross(e1, v0 + v1), ray.direction);
    float w = dot(cross(e2, v1 + v2), ray.direction);
    if (min(min(u, v), w) < 0.0 && max(max(u, v), w) > 0.0) {
        return false;
    }
    vec3 normal = cross(e0, e1);
    float t = dot(v0, normal) / dot(normal, ray.direction);
    if (!(t > 0.0 && t < hit.t)) {
        return false;
    }
    hit.t = t;
    // u belongs to the edge p2 p0, opposite to p1; v to p0 p1, opposite to p2.
    hit.barycentric = vec2(u, v) / (u + v + w);
    return true;
}

bool intersect_primitive(uint primitive, Ray ray, inout Hit hit) {
    uint kind = primitive >> KIND_SHIFT;
    uint index = primitive & INDEX_MASK;
    bool found = false;
    if (is_triangle(kind)) {
        found = intersect_triangle(triangles.data[index], ray, hit);
    } else if (HAS_QUADRICS) {
        Quadric quadric = quadrics.data[index];
        vec3 o = transform_point(quadric.object_from_render, ray.origin);
        vec3 d = transform_vector(quadric.object_from_render, ray.direction);
        if (is_sphere(kind)) {
            found = intersect_sphere(quadric, o, d, hit.t);
        } else {
            found = intersect_disk(quadric, o, d, hit.t);
        }
    }
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
    vec3 far = max(a, b) * (1.0 + 8.0 * ROUNDING);
    float t_near = max(max(near.x, near.y), max(near.z, 0.0));
    float t_far = min(min(far.x, far.y), min(far.z, t_max));
    return t_near <= t_far ? t_near : INFINITY_T;
}

// The nearest hit with 0 < t < t_max; with any_hit, some hit. All lanes walk inner nodes
// until each has a leaf, then all test primitives (Aila and Laine 2009, "while-while").
Hit traverse(Ray ray, float t_max, bool any_hit) {
    Hit hit = Hit(t_max, NONE, vec2(0.0));
    // No component is zero, so that no slab computes zero times infinity.
    vec3 direction = mix(ray.direction, vec3(1.0e-20), equal(ray.direction, vec3(0.0)));
    vec3 inverse = 1.0 / direction;
    uint stack[MAX_BVH_DEPTH];
    uint height = 0u;
    uint node = 0u;
    while (node != NONE) {
        while (node >> COUNT_SHIFT == 0u) {
            BvhPair pair = bvh_pairs.data[node];
            float t_left = enter_box(pair.left_lower.xyz, pair.left_upper.xyz, ray, inverse, hit.t);
            float t_right = enter_box(pair.right_lower.xyz, pair.right_upper.xyz, ray, inverse, hit.t);
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
        uint first = node & FIRST_MASK;
        uint end = first + (node >> COUNT_SHIFT);
        for (uint i = first; i < end; i++) {
            if (intersect_primitive(primitives.data[i], ray, hit) && any_hit) {
                return hit;
            }
        }
        node = height > 0u ? stack[--height] : NONE;
    }
    return hit;
}

Hit intersect(Ray ray) {
    return traverse(ray, INFINITY_T, false);
}

// Whether anything stands between a point and another; both already offset.
bool occluded(vec3 from, vec3 to) {
    return traverse(Ray(from, to - from), 1.0, true).primitive != NONE;
}
