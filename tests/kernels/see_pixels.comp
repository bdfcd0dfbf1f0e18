// see_pixels: makes the first rays of eye paths. Each invocation has a pixel, as in the eye pass, and its
// rays are `stride` apart.
#version 460
#include "camera/camera.glsl"
#include "camera/sample.glsl"
#include "geometry/contact.glsl"
#include "kernel/invocation.glsl"
#include "kernel/tile.glsl"
#include "math/random.glsl"
#include "scene/constants.glsl"
#include "scene/scene.glsl"

struct TracedRay {
    vec3 origin;
    float t_max;
    vec3 direction;
    float pad0;
};

STORED_TEXELS(TracedRay, rays)

layout(push_constant) uniform Push {
    uint count; // of rays
};

void main() {
    uint number = invocation_index();
    uint stride = gl_NumWorkGroups.x * gl_NumWorkGroups.y * gl_WorkGroupSize.x;
    uint pixel = pixel_of(number, camera_at(0u).width, camera_at(0u).height);
    if (pixel == NONE) {
        return;
    }
    uint seed = hash(scene.seed, pixel);
    for (uint path = 0u; number < count; number += stride) {
        Ray ray = sample_camera(pixel, Random(seed, path)).ray;
        store_rays(number, TracedRay(ray.origin, INFINITY_T, ray.direction, 0.0));
        path++;
    }
}
