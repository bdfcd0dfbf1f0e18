// sample_revolutions: samples points on lights that are bodies of revolution, and hits each by a ray.
#version 460
#include "geometry/contact.glsl"
#include "geometry/hit.glsl"
#include "geometry/intersect.glsl"
#include "geometry/surface.glsl"
#include "geometry/surface_point.glsl"
#include "kernel/invocation.glsl"
#include "light/light.glsl"
#include "scene/constants.glsl"
#include "scene/lights.glsl"
#include "scene/scene.glsl"

struct LightPoint {
    vec2 u;
    uint light;
    float pad0;
};

struct Sampled {
    vec3 position;
    float area_pdf;
    vec3 normal;
    float pdf_of_hit; // 0 if the ray misses
};

BUFFER(LightPoint, points)
UPDATED_BUFFER(Sampled, sampled)

const float AWAY = 1.0e-3;

void main() {
    uint i = invocation_index();
    if (i >= points.data.length()) {
        return;
    }
    Light light = lights_at(points.data[i].light);
    Surface surface = sample_revolution_light(light, points.data[i].u);
    Ray ray = free_ray(surface.position + AWAY * surface.normal, -surface.normal);
    Hit hit = Hit(2.0 * AWAY, NONE, vec2(0.0), NONE);
    float pdf_of_hit = 0.0;
    if (intersect_primitive(light.primitive, ray, shear_of(ray.direction), hit)) {
        pdf_of_hit = surface_at(ray, hit).area_pdf;
    }
    sampled.data[i] = Sampled(surface.position, surface.area_pdf, surface.normal, pdf_of_hit);
}
