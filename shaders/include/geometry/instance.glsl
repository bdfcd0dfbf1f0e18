// Into instances and out of them.
#include "geometry/contact.glsl"
#include "geometry/quadric.glsl"
#include "scene/scene.glsl"

// A ray in the space of an instance's object. Its direction keeps its length there, so that t
// is the same on both sides.
Ray enter_instance(uint index, Ray ray) {
    return ray_in(instances_at(index).object_from_render, ray);
}
