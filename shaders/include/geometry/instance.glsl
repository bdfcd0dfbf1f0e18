// Rays in instances.
#include "geometry/contact.glsl"
#include "geometry/quadric.glsl"
#include "scene/scene.glsl"

// Transforms a ray to the space of an instance's object. The direction is not normalised, so that t is the
// same in both spaces.
Ray ray_into_instance(uint index, Ray ray) {
    return ray_in(instances_at(index).object_from_render, ray);
}
