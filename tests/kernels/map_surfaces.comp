// map_surfaces: intersects a ray with a primitive; stores the texture coordinates and the tangent there.
#version 460
#include "geometry/contact.glsl"
#include "geometry/hit.glsl"
#include "geometry/intersect.glsl"
#include "geometry/surface.glsl"
#include "geometry/surface_point.glsl"
#include "kernel/invocation.glsl"
#include "scene/constants.glsl"

struct MappedRay {
    vec3 origin;
    uint primitive;
    vec3 direction;
    float pad0;
};

struct MappedPoint {
    vec3 position;
    uint found;
    vec3 tangent;
    float pad0;
    vec3 normal;
    float pad1;
    vec2 uv;
    vec2 pad2;
};

BUFFER(MappedRay, rays)
UPDATED_BUFFER(MappedPoint, points)

void main() {
    uint i = invocation_index();
    if (i >= rays.data.length()) {
        return;
    }
    Ray ray = free_ray(rays.data[i].origin, rays.data[i].direction);
    Hit hit = Hit(INFINITY_T, NONE, vec2(0.0), NONE);
    bool found = intersect_primitive(rays.data[i].primitive, ray, shear_of(ray.direction), hit);
    hit.primitive = rays.data[i].primitive;
    Surface surface = surface_at(ray, hit);
    points.data[i] = MappedPoint(surface.position, found ? 1u : 0u, surface.tangent, 0.0, surface.normal, 0.0,
                                 surface.uv, vec2(0.0));
}
