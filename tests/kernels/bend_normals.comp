// bend_normals: intersects a ray with a primitive; stores the shading normal there, as the material's bumps bend it.
#version 460
#include "geometry/contact.glsl"
#include "geometry/hit.glsl"
#include "geometry/instance.glsl"
#include "geometry/intersect.glsl"
#include "geometry/surface.glsl"
#include "geometry/surface_point.glsl"
#include "kernel/invocation.glsl"
#include "material/bump.glsl"
#include "material/material.glsl"
#include "scene/constants.glsl"

struct BentRay {
    vec3 origin;
    uint primitive;
    vec3 direction;
    uint instance; // that contains the primitive, or NONE
};

struct BentPoint {
    vec3 position;
    uint found;
    vec3 normal; // geometric
    float pad0;
    vec3 shading_normal;
    float pad1;
    vec3 tangent;
    float pad2;
    vec2 uv;
    vec2 pad3;
};

BUFFER(BentRay, rays)
UPDATED_BUFFER(BentPoint, points)

void main() {
    uint i = invocation_index();
    if (i >= rays.data.length()) {
        return;
    }
    Ray ray = free_ray(rays.data[i].origin, rays.data[i].direction);
    Ray local = ray;
    if (rays.data[i].instance != NONE) {
        local = ray_into_instance(rays.data[i].instance, ray);
    }
    Hit hit = Hit(INFINITY_T, NONE, vec2(0.0), NONE);
    bool found = intersect_primitive(rays.data[i].primitive, local, shear_of(local.direction), hit);
    hit.primitive = rays.data[i].primitive;
    hit.instance = rays.data[i].instance;
    Surface surface = surface_at(ray, hit);
    apply_bumps(surface, material_at(surface));
    points.data[i] = BentPoint(surface.position, found ? 1u : 0u, surface.normal, 0.0, surface.shading_normal, 0.0,
                               surface.tangent, 0.0, surface.uv, vec2(0.0));
}
