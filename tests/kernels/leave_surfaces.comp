// leave_surfaces: intersects a ray with a primitive, and a second ray that leaves from the hit with the
// same primitive.
#version 460
#include "geometry/contact.glsl"
#include "geometry/hit.glsl"
#include "geometry/intersect.glsl"
#include "geometry/surface.glsl"
#include "geometry/surface_point.glsl"
#include "kernel/invocation.glsl"
#include "scene/constants.glsl"

struct Arrival {
    vec3 origin;
    uint primitive;
    vec3 direction;
    float pad0;
    vec3 leaving; // direction of the second ray
    float pad1;
};

struct Departure {
    vec3 position;
    float error;
    vec3 normal;
    uint found;     // 1 if the first ray hit the primitive
    vec3 origin;    // of the second ray
    float t_again;  // of the second hit, negative if there is none
};

BUFFER(Arrival, arrivals)
UPDATED_BUFFER(Departure, departures)

void main() {
    uint i = invocation_index();
    if (i >= arrivals.data.length()) {
        return;
    }
    Arrival arrival = arrivals.data[i];
    Ray ray = free_ray(arrival.origin, arrival.direction);
    Hit hit = Hit(INFINITY_T, NONE, vec2(0.0), NONE);
    if (!intersect_primitive(arrival.primitive, ray, shear_of(ray.direction), hit)) {
        departures.data[i] = Departure(vec3(0.0), 0.0, vec3(0.0), 0u, vec3(0.0), -1.0);
        return;
    }
    Surface surface = surface_at(ray, hit);
    vec3 origin = offset_origin(surface, arrival.leaving);
    Hit again = Hit(INFINITY_T, NONE, vec2(0.0), NONE);
    bool met = intersect_primitive(arrival.primitive, free_ray(origin, arrival.leaving), shear_of(arrival.leaving), again);
    departures.data[i] = Departure(surface.position, surface.error, surface.normal, 1u, origin, met ? again.t : -1.0);
}
