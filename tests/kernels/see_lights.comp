// see_lights: samples lights for next-event estimation from given points.
#version 460
#include "geometry/contact.glsl"
#include "geometry/hit.glsl"
#include "geometry/intersect.glsl"
#include "geometry/surface.glsl"
#include "kernel/invocation.glsl"
#include "light/light.glsl"
#include "scene/constants.glsl"
#include "scene/scene.glsl"

struct Viewpoint {
    vec3 from;
    float u_light;
    vec2 u;
    uint light; // area light to sample, or NONE to choose a light by the table
    float pad0;
};

struct Seen {
    vec3 target;
    float pdf;
    vec3 wi;
    uint uses_mis;
    vec3 radiance;
    float pdf_of_hit; // direct_pdf of the first point that a ray along wi hits on the light, 0 if there is none
};

BUFFER(Viewpoint, viewpoints)
UPDATED_BUFFER(Seen, seen)

void main() {
    uint i = invocation_index();
    if (i >= viewpoints.data.length()) {
        return;
    }
    Viewpoint view = viewpoints.data[i];
    LightSample direct;
    if (view.light == NONE) {
        direct = sample_direct(view.from, no_hue(), view.u_light, view.u);
    } else {
        direct = sample_area_light(lights_at(view.light), view.from, view.u);
    }
    float pdf_of_hit = 0.0;
    if (view.light != NONE && direct.pdf > 0.0) {
        Ray ray = free_ray(view.from, direct.wi);
        Hit hit = Hit(INFINITY_T, NONE, vec2(0.0), NONE);
        if (intersect_primitive(lights_at(view.light).primitive, ray, shear_of(ray.direction), hit)) {
            pdf_of_hit = direct_pdf(lights_at(view.light), view.from, surface_at(ray, hit), direct.wi);
        }
    }
    seen.data[i] = Seen(direct.target, direct.pdf, direct.wi, direct.uses_mis ? 1u : 0u, direct.radiance, pdf_of_hit);
}
