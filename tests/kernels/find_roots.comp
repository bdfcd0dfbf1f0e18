// find_roots: finds every root of rays with a body, t_min < t < t_max. One invocation per ray and piece.
#version 460
#include "geometry/contact.glsl"
#include "kernel/invocation.glsl"
#include "revolution/ray.glsl"
#include "revolution/revolution.glsl"
#include "scene/constants.glsl"

struct BodyRay {
    vec3 origin;
    float t_min;
    vec3 direction;
    float t_max;
};

struct FoundRoot {
    float t;
    float x;
    uint piece;
};

const uint MOST_ROOTS = 32u;   // stored for a ray
const uint MOST_ON_PIECE = 8u; // found on a piece

BUFFER(BodyRay, rays)
UPDATED_BUFFER(FoundRoot, roots) // MOST_ROOTS for each ray
UPDATED_BUFFER(uint, root_counts) // of all roots found, stored or not

VALUE(uint, piece_count)

void main() {
    uint pieces = piece_count.value;
    uint i = invocation_index() / pieces;
    uint piece = invocation_index() % pieces;
    if (i >= rays.data.length()) {
        return;
    }
    RevolutionRay ray = revolution_ray(0u, free_ray(rays.data[i].origin, rays.data[i].direction));
    float t_min = rays.data[i].t_min;
    for (uint n = 0u; n < MOST_ON_PIECE; n++) {
        float t = rays.data[i].t_max;
        float x = 0.0;
        if (!intersect_revolution(piece, ray, t_min, t, x)) {
            break;
        }
        uint slot = atomicAdd(root_counts.data[i], 1u);
        if (slot < MOST_ROOTS) {
            roots.data[MOST_ROOTS * i + slot] = FoundRoot(t, x, piece);
        }
        // Goes on behind the root, by more than the difference of the two equations that may find it.
        t_min = t + 1.0e-6 / ray.size + 4.0 * ROUNDING * abs(t);
    }
}
