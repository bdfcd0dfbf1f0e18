// hit_triangles: intersects one ray with one triangle per invocation.
#version 460
#include "geometry/contact.glsl"
#include "geometry/hit.glsl"
#include "geometry/intersect.glsl"
#include "kernel/invocation.glsl"
#include "scene/constants.glsl"
#include "scene/scene.glsl"

struct TriangleRay {
    vec3 origin;
    uint triangle;
    vec3 direction;
    float t_max;
};

struct TriangleHit {
    vec2 barycentric;
    float t;
    uint found;
};

BUFFER(TriangleRay, rays)
UPDATED_BUFFER(TriangleHit, hits)

void main() {
    uint i = invocation_index();
    if (i >= rays.data.length()) {
        return;
    }
    TriangleRay input_ray = rays.data[i];
    Hit hit = Hit(input_ray.t_max, NONE, vec2(0.0), NONE);
    bool found = intersect_triangle(triangles_at(input_ray.triangle), free_ray(input_ray.origin, input_ray.direction),
                                    shear_of(input_ray.direction),
                                    TRIANGLE << KIND_SHIFT | input_ray.triangle, NONE, hit);
    hits.data[i] = TriangleHit(hit.barycentric, hit.t, found ? 1u : 0u);
}
