// From places on the image to rays in camera space.
//
// A place is a point of the plane z = 1 for a perspective camera, of the plane z = 0 for an
// orthographic one, and for a spherical one a point of the unit square of all directions.
#include "camera/camera.glsl"
#include "geometry/contact.glsl"
#include "math/equal_area.glsl"
#include "math/sampling.glsl"
#include "scene/features.glsl"

// By angles: x goes around, y from the top down.
vec3 equirectangular_direction(vec2 place) {
    float theta = PI * place.y;
    float phi = 2.0 * PI * place.x;
    return vec3(sin(theta) * cos(phi), cos(theta), sin(theta) * sin(phi));
}

// `lens` is a point of the unit disk.
Ray project(Camera view, vec2 place, vec2 lens) {
    vec3 origin = vec3(0.0);
    vec3 direction = vec3(place, 1.0);
    if (IS_SPHERICAL) {
        if (IS_EQUAL_AREA) {
            direction = equal_area_direction(wrap_equal_area(place)).xzy;
        } else {
            direction = equirectangular_direction(place);
        }
    } else if (view.lens_radius > 0.0) {
        // As in pbrt, both kinds look from the same lens to their own points of focus.
        if (IS_ORTHOGRAPHIC) {
            direction = vec3(place, view.focal_distance);
        } else {
            direction *= view.focal_distance;
        }
        origin.xy = view.lens_radius * lens;
        direction -= origin;
    } else if (IS_ORTHOGRAPHIC) {
        origin.xy = place;
        direction = vec3(0.0, 0.0, 1.0);
    }
    return free_ray(origin, direction);
}
