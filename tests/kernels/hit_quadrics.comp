// hit_quadrics: intersects one ray in object space with one sphere or disk per invocation.
#version 460
#include "geometry/contact.glsl"
#include "geometry/quadric.glsl"
#include "kernel/invocation.glsl"
#include "scene/primitives.glsl"
#include "scene/scene.glsl"

struct ObjectRay {
    vec3 origin;
    uint quadric; // a primitive reference
    vec3 direction;
    float t_max;
};

struct ObjectHit {
    float t;
    uint found;
};

BUFFER(ObjectRay, rays)
UPDATED_BUFFER(ObjectHit, hits)

void main() {
    uint i = invocation_index();
    if (i >= rays.data.length()) {
        return;
    }
    ObjectRay object_ray = rays.data[i];
    Quadric quadric = quadrics_at(object_ray.quadric & INDEX_MASK);
    Ray ray = free_ray(object_ray.origin, object_ray.direction);
    float t = object_ray.t_max;
    bool found = false;
    if (object_ray.quadric >> KIND_SHIFT == SPHERE) {
        found = intersect_sphere(quadric, ray, t);
    } else {
        found = intersect_disk(quadric, ray, t);
    }
    hits.data[i] = ObjectHit(t, found ? 1u : 0u);
}
