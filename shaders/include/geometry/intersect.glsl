// Intersects rays with primitives.
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

// A hit at t_max that nothing has yet.
Hit no_hit(float t_max) {
    return Hit(t_max, NONE, vec2(0.0), NONE);
}

// Whether a primitive that a ray meets at t becomes its hit: it is nearer than the hit so far, or as near
// and of a lower number, so that the order of tests does not matter. (NONE + 1 is 0: no primitive is as near
// as t_max.)
bool is_nearer(float t, uint primitive, uint instance, Hit hit) {
    bool is_first = primitive < hit.primitive + 1u;
    if (HAS_INSTANCES) {
        is_first = hit.primitive != NONE && (instance < hit.instance || (instance == hit.instance && is_first));
    }
    return t < hit.t || (t == hit.t && is_first);
}

// Intersects a triangle without gaps at its edges (Woop and others, "Watertight Ray/Triangle
// Intersection", JCGT 2013). A vertex is sheared to the same point in all of its triangles, and the
// sign of an edge function is right or 0, since rounding keeps the order of the two products: no ray
// slips through an edge or a vertex of a closed mesh. `precise` forbids fused multiply-adds, which
// would break both.
// `primitive` is the reference to the triangle, `instance` what contains it.
bool intersect_triangle(Triangle triangle, Ray ray, Shear shear, uint primitive, uint instance, inout Hit hit) {
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
    bool found = inside && area != 0.0 && may_meet(ray, triangle.material, leaves, t)
              && is_nearer(t, primitive, instance, hit);
    if (found) {
        hit = Hit(t, primitive, vec2(to_p1, to_p2), instance);
    }
    return found;
}

// The t below which another hit would be the hit of a ray, or as near.
float limit_of(Hit hit) {
    return hit.primitive != NONE && hit.t > 0.0 ? uintBitsToFloat(floatBitsToUint(hit.t) + 1u) : hit.t;
}

// Makes a primitive the hit of a ray, if it is nearer.
bool accept(float t, uint primitive, vec2 barycentric, uint instance, inout Hit hit) {
    bool found = is_nearer(t, primitive, instance, hit);
    if (found) {
        hit = Hit(t, primitive, barycentric, instance);
    }
    return found;
}

// Intersects a sphere or a disk.
bool intersect_quadric(uint primitive, Ray ray, uint instance, inout Hit hit) {
    Quadric quadric = quadrics_at(primitive & INDEX_MASK);
    Ray local = ray_in(quadric.object_from_render, ray);
    float t = limit_of(hit);
    bool sphere = is_sphere(primitive >> KIND_SHIFT);
    bool meets = sphere ? intersect_sphere(quadric, local, t) : intersect_disk(quadric, local, t);
    return meets && accept(t, primitive, vec2(0.0), instance, hit);
}

// Tests one primitive, named by a reference as in Hit.
bool intersect_primitive(uint primitive, Ray ray, Shear shear, inout Hit hit) {
    uint kind = primitive >> KIND_SHIFT;
    uint index = primitive & INDEX_MASK;
    if (is_triangle(kind)) {
        return intersect_triangle(triangles_at(index), ray, shear, primitive, NONE, hit);
    }
    if (!is_revolution(kind)) {
        return intersect_quadric(primitive, ray, NONE, hit);
    }
    if (REVOLUTION_NEWTON) {
        return meet_segment(index, ray, NONE, hit);
    }
    RevolutionRay body_ray = revolution_ray(revolution_pieces_at(index).body, ray);
    bool found = intersect_revolution(index, body_ray, begin_of(ray), hit.t, hit.barycentric.x);
    if (found) {
        hit.primitive = primitive;
    }
    return found;
}

// Tests all pieces of a body of revolution; for the classical solver, one segment of its profile.
bool test_body(uint body, Ray ray, bool any_hit, uint instance, inout Hit hit) {
    if (REVOLUTION_NEWTON) {
        return meet_segment(body, ray, instance, hit);
    }
    RevolutionRay body_ray = revolution_ray(body, ray);
    uint first = revolutions_at(body).first_piece;
    float t = limit_of(hit);
    Pieces candidates = pieces_met(body_ray, first, revolutions_at(body).piece_count, begin_of(ray), t);
    uint piece;
    float x;
    bool meets = intersect_pieces(candidates, body_ray, begin_of(ray), any_hit, t, x, piece);
    return meets && accept(t, REVOLUTION << KIND_SHIFT | piece, vec2(x, 0.0), instance, hit);
}

// 1 over the direction. Components of 0 become tiny, so that no slab test computes 0 times infinity.
vec3 inverse_direction(Ray ray) {
    return 1.0 / mix(ray.direction, vec3(1.0e-20), equal(ray.direction, vec3(0.0)));
}

// Widens the t at which a ray leaves a box by the rounding error of three operations (Ize, "Robust BVH Ray
// Traversal", 2013).
float widen(float t) {
    if (HAS_CONTACTS) {
        return t + abs(t) * (8.0 * ROUNDING);
    }
    return t * (1.0 + 8.0 * ROUNDING);
}

// Whether a ray enters a box before t_max.
bool enters_box(vec3 lower, vec3 upper, Ray ray, vec3 inverse, float t_max) {
    vec3 a = (lower - ray.origin) * inverse;
    vec3 b = (upper - ray.origin) * inverse;
    vec3 near = min(a, b);
    vec3 far = max(a, b);
    float t_near = max(max(near.x, near.y), max(near.z, begin_of(ray)));
    return t_near <= min(widen(min(min(far.x, far.y), far.z)), t_max);
}

// Tests all bodies. Each lane visits only those whose boxes it enters, without waiting for other lanes.
void test_all_bodies(Ray ray, bool any_hit, inout Hit hit) {
    vec3 inverse = inverse_direction(ray);
    uint bodies = 0u;
    for (uint i = 0u; i < FLAT_REVOLUTIONS; i++) {
        if (enters_box(revolutions_at(i).lower, revolutions_at(i).upper, ray, inverse, hit.t)) {
            bodies |= 1u << i;
        }
    }
    while (bodies != 0u && !(any_hit && hit.primitive != NONE)) {
        uint body = findLSB(bodies);
        bodies &= bodies - 1u;
        test_body(body, ray, any_hit, NONE, hit);
    }
}

// Intersects a ray with all primitives, in scenes of a few: every lane tests the same ones, so that lanes
// do not diverge.
Hit test_all(Ray ray, float t_max, bool any_hit) {
    Hit hit = no_hit(t_max);
    Shear shear = shear_of(ray.direction);
    for (uint i = 0u; i < FLAT_TRIANGLES; i++) {
        intersect_triangle(triangles_at(i), ray, shear, TRIANGLE << KIND_SHIFT | i, NONE, hit);
    }
    for (uint i = 0u; i < FLAT_QUADRICS; i++) {
        intersect_quadric(quadrics_at(i).kind << KIND_SHIFT | i, ray, NONE, hit);
    }
    if (HAS_REVOLUTIONS) {
        test_all_bodies(ray, any_hit, hit);
    }
    return hit;
}
