// Samples rays of the camera.
#include "camera/camera.glsl"
#include "camera/projection.glsl"
#include "geometry/contact.glsl"
#include "geometry/quadric.glsl"
#include "math/random.glsl"
#include "math/sampling.glsl"
#include "scene/constants.glsl"
#include "scene/features.glsl"

TEXELS(Camera, camera)
TEXELS(float, filter_table)

// Pairs of random numbers of an eye path.
const uint PAIR_FILTER = 0u;
const uint PAIR_LENS = 1u;

// Offset of a camera sample from the pixel's centre, in pixels, for axis 0 (x) or 1 (y). Inverts the
// distribution of the pixel filter's magnitude: filter_table holds the edges of its cells per axis.
float filter_offset(uint axis, float u) {
    float scaled = u * float(FILTER_CELLS);
    uint i = min(uint(scaled), FILTER_CELLS - 1u);
    uint entry = (FILTER_CELLS + 1u) * axis + i;
    return mix(filter_table_at(entry), filter_table_at(entry + 1u), scaled - float(i));
}

// Weight of a camera sample, with a mean of 1 over all samples; negative where the filter is. The
// weights' tables follow the tables of offsets.
float filter_weight(uint axis, float u) {
    uint i = min(uint(u * float(FILTER_CELLS)), FILTER_CELLS - 1u);
    return filter_table_at((FILTER_CELLS + 1u) * (axis + 2u) + i);
}

struct CameraSample {
    Ray ray;
    float weight; // of the pixel filter
};

// The camera sample of a path, moved by a number of pixels on the image.
CameraSample sample_camera_beside(uint pixel, Random random, vec2 shift) {
    Camera view = camera_at(0u);
    vec2 u = random_pair(random, PAIR_FILTER);
    vec2 offset = vec2(filter_offset(0u, u.x), filter_offset(1u, u.y));
    vec2 at = vec2(pixel % view.width, pixel / view.width) + 0.5 + offset + shift;
    vec2 image = at / vec2(view.width, view.height);
    vec2 lens = vec2(0.0);
    if (view.lens_radius > 0.0) {
        lens = sample_disk(random_pair(random, PAIR_LENS));
    }
    Ray ray = project(view, view.image_lower + image * view.image_extent, lens);
    ray = free_ray(transform_point(view.render_from_camera, ray.origin),
                   normalize(transform_vector(view.render_from_camera, ray.direction)));
    float weight = 1.0;
    if (HAS_SIGNED_FILTER) {
        weight = filter_weight(0u, u.x) * filter_weight(1u, u.y);
    }
    return CameraSample(ray, weight);
}

CameraSample sample_camera(uint pixel, Random random) {
    return sample_camera_beside(pixel, random, vec2(0.0));
}
