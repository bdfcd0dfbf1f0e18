// From points on the image to rays in camera space.
//
// The image lies on the plane z = 1 for a perspective camera, on the plane z = 0 for an orthographic
// camera, and on the unit square, which stands for all directions, for a spherical camera.
#include "camera/camera.glsl"
#include "geometry/contact.glsl"
#include "math/circle.glsl"
#include "math/equal_area.glsl"
#include "math/sampling.glsl"
#include "scene/features.glsl"

// Direction of a point of the unit square: x is the azimuth, y the polar angle from the top.
vec3 equirectangular_direction(vec2 point) {
    vec2 polar = circle_point(PI * point.y);
    vec2 around = polar.y * circle_point(2.0 * PI * point.x);
    return vec3(around.x, polar.x, around.y);
}

// The ray through a point of the image; `lens` is a point of the unit disk.
Ray project(Camera view, vec2 point, vec2 lens) {
    vec3 origin = vec3(0.0);
    vec3 direction = vec3(point, 1.0);
    if (IS_SPHERICAL) {
        if (IS_EQUAL_AREA) {
            direction = equal_area_direction(wrap_equal_area(point)).xzy;
        } else {
            direction = equirectangular_direction(point);
        }
    } else if (view.lens_radius > 0.0) {
        // As in pbrt, both kinds of camera have the same lens, each with its own points of focus.
        if (IS_ORTHOGRAPHIC) {
            direction = vec3(point, view.focal_distance);
        } else {
            direction *= view.focal_distance;
        }
        origin.xy = view.lens_radius * lens;
        direction -= origin;
    } else if (IS_ORTHOGRAPHIC) {
        origin.xy = point;
        direction = vec3(0.0, 0.0, 1.0);
    }
    return free_ray(origin, direction);
}
