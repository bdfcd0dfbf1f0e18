// gather_tree: adds each photon's weight to the visible points on whose disc it is, found by the
// kd-tree.
//
// Invocations: `stride`; each takes every stride-th recorded photon. One that has visited many nodes
//   stores its position in `places` and counts as unfinished; another dispatch goes on from there, so
//   that no dispatch is long.
// Reads: photons, tree_points, max_radius2; places where it resumes.
// Writes: flux_red, flux_green, flux_blue, flux_counts (atomic), places, counters (atomic).
// Units: lengths in render units; flux over the mean flux of a photon, in fixed point (flux.glsl).
// Source: Hachisuka and Jensen 2009, equation 5; the walk: tree.glsl.
#version 460
#include "geometry/normal.glsl"
#include "kernel/counters.glsl"
#include "kernel/interruption.glsl"
#include "kernel/invocation.glsl"
#include "lookup/caustic.glsl"
#include "lookup/deposit.glsl"
#include "lookup/disc.glsl"
#include "lookup/flux.glsl"
#include "lookup/records.glsl"
#include "lookup/tree.glsl"
#include "scene/constants.glsl"

TEXELS(PhotonRecord, photons)
VALUE(uint, max_radius2)
TEXELS(TreePoint, tree_points)
UPDATED_BUFFER(TreePlace, places) // of invocations that go on

layout(push_constant) uniform Push {
    uint recorded; // number of photons
    uint stride;   // number of invocations
    uint node_count; // number of nodes of the tree
    uint resumed;  // 1 to go on from `places`
    uint offset;   // first invocation of this dispatch
};

// Nodes that a lane visits, at most, to find its next point in reach before all lanes add to theirs.
const uint MAX_STEPS = 16u;
// Rounds of one dispatch: each has up to MAX_STEPS rounds of its own, and all are fewer than the
// 65,535 that llvmpipe allows an invocation.
const uint MAX_ROUNDS = 3500u;

struct Photon {
    vec3 position;
    vec3 normal;
    uvec2 red;
    uvec2 green;
    uvec2 blue;
    bool is_gathered;
};

Photon load_photon(uint index) {
    PhotonRecord record = photons_at(index);
    return Photon(record.position, unpack_normal(record.normal), to_words(record.weight.x),
        to_words(record.weight.y), to_words(record.weight.z), is_gathered(record));
}

void main() {
    uint invocation = offset + invocation_index();
    if (invocation >= min(stride, recorded) || node_count == 0u) {
        return; // other invocations take all photons
    }
    TreePlace place = TreePlace(invocation, 1u, 0u);
    if (resumed != 0u) {
        place = places.data[invocation];
    }
    if (place.photon >= recorded) {
        return;
    }
    Photon photon = load_photon(place.photon);
    // Widened, so that rounding leaves no node out.
    float radius = 1.000001 * sqrt(uintBitsToFloat(max_radius2.value));
    for (uint round = 0u; round < MAX_ROUNDS && place.photon < recorded; round++) {
        // All lanes look for their next point in reach before any lane adds to its point, so that few
        // lanes are idle while others add.
        bool found = false;
        TreePoint point;
        vec3 d;
        for (uint i = 0u; i < MAX_STEPS && place.node != 0u && !found; i++) {
            point = tree_points_at(place.node - 1u);
            d = photon.position - point.position;
            found = dot(d, d) < point.radius2;
            next_node(place, d, point.owner >> AXIS_SHIFT, radius, node_count);
        }
        if (found && photon.is_gathered && is_on_disc(d, photon.normal, unpack_normal(point.normal), point.radius2)) {
            bool inner = is_inner(d, point.radius2);
            deposit(point.owner & PIXEL_MASK, photon.red, photon.green, photon.blue, inner);
        }
        if (place.node == 0u) {
            place = TreePlace(place.photon + stride, 1u, 0u);
            if (place.photon < recorded) {
                photon = load_photon(place.photon);
            }
        }
    }
    places.data[invocation] = place;
    if (place.photon < recorded) {
        atomicAdd(counters.value.unfinished, 1u);
    }
    if (interrupted()) {
        atomicAdd(counters.value.interrupted, 1u);
    }
}
