// photon: emit photons, trace them, and record them where they meet diffuse surfaces.
// Each invocation traces every stride-th photon of the batch, starting the next where a
// path ends, so that lanes stay busy (path regeneration). Writes photons, counters
// (atomic). Weights are in units of the mean flux of a photon. Jensen 1996.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "invocation.glsl"
#include "scene.glsl"
#include "random.glsl"
#include "sampling.glsl"
#include "intersect.glsl"
#include "surface.glsl"
#include "texture.glsl"
#include "alpha.glsl"
#include "bsdf.glsl"
#include "material.glsl"
#include "light.glsl"
#include "emission.glsl"
#include "normal.glsl"
#include "interruption.glsl"

STORED_TEXELS(1, 0, PhotonRecord, photons)
layout(std430, set = 1, binding = 2) buffer CounterBlock { Counters value; } counters;

layout(push_constant) uniform Push {
    uint before_low;     // photons before this iteration that are of its stream, 64 bits
    uint before_high;
    uint half_of_rounds; // 0 or 1
    uint stream;         // photons of different streams are independent of each other
    uint first;       // photons first .. end of the iteration, stride apart
    uint end;
    uint stride;
    uint capacity;    // of photons
    uint offset;      // of this dispatch's invocations
    uint two;         // 2, see interruption.glsl
};

// Pairs of random numbers of a photon path: emission takes the first three, each bounce
// then a pair for the direction and one for lobe and roulette.
const uint PAIR_BOUNCE = 3u;

struct Path {
    Ray ray;
    vec3 weight;
    uint depth;
    float index; // of the medium it is in, over the one where it began
    Random random;
};

// Photons of all iterations of a stream are one sequence: its strata get finer as the render
// goes on.
Path start_path(uint photon) {
    uint index = before_low + photon;
    uint high = before_high + (index < photon ? 1u : 0u);
    // Eye paths hash the seed itself: its complement keeps the two apart.
    uint seed = hash(~seed_of_half(scene.seed, half_of_rounds), high);
    Random random = Random(stream == 0u ? seed : hash(seed, stream), index);
    Emission emission = emit(random);
    return Path(emission.ray, emission.weight, 0u, 1.0, random);
}

// Those past the end of the array count, so that the host hears of them.
void record(Surface surface, vec3 wo, vec3 weight) {
    uint slot = atomicAdd(counters.value.recorded, 1u);
    vec3 facing = dot(wo, surface.normal) < 0.0 ? -surface.normal : surface.normal;
    if (slot < capacity) {
        store_photons(slot, PhotonRecord(surface.position, pack_normal(facing), weight, 0u));
    }
}

// Ways for a path to end, in the order of the counters; ALIVE if it goes on.
const uint DEPOSITED = 0u;
const uint ABSORBED = 1u;
const uint ESCAPED = 2u;
const uint TRUNCATED = 3u;
const uint LOST_IN_GLASS = 4u;
const uint NOT_FINITE = 5u;
const uint ALIVE = 6u;

// One segment of a path. Direct light is the eye pass's affair, so the first surface
// records nothing, unless photons are to bring all light.
uint advance(inout Path path) {
    Hit hit = intersect(path.ray);
    if (hit.primitive == NONE) {
        return is_in_glass(path.index) ? LOST_IN_GLASS : ESCAPED;
    }
    Surface surface = surface_at(path.ray, hit);
    Material material = material_at(surface);
    vec3 wo = -path.ray.direction;
    float cos_o = abs(dot(wo, surface.shading_normal));
    bool receives = receives_photons(material);
    if (receives && is_in_glass(path.index)) {
        // In a pool, or lost: unless something stands in glass, none does this.
        atomicAdd(counters.value.immersed, 1u);
        path.index = 1.0;
    }
    bool is_wanted = DIRECT_NEE ? path.depth > 0u : true;
    if (receives && is_wanted) {
        record(surface, wo, path.weight * entering(material, cos_o));
    }
    path.depth++;
    if (path.depth >= scene.max_depth) {
        return TRUNCATED;
    }
    uint pair = PAIR_BOUNCE + 2u * (path.depth - 1u);
    vec2 u = random_pair(path.random, pair + 1u);
    if (HAS_LAYERS) {
        material = choose_lobe(material, cos_o, u.x);
    }
    bool specular = is_specular(material);
    // Where shading and geometric normal disagree about the photon's side, a diffuse
    // surface must not let it through.
    bool same_side = dot(wo, surface.shading_normal) * dot(wo, surface.normal) > 0.0;
    vec3 n = specular || same_side ? surface.shading_normal : surface.normal;
    vec2 u_direction = specular && !is_rough(material) ? vec2(0.0) : random_pair(path.random, pair);
    Scatter scattered = scatter(material, wo, n, surface.tangent, u.x, u_direction, FLUX);
    // Russian roulette keeps the largest channel of every photon's weight constant.
    vec3 weight = path.weight * scattered.weight;
    float before = max(path.weight.x, max(path.weight.y, path.weight.z));
    float after = max(weight.x, max(weight.y, weight.z));
    if (u.y * before >= after) {
        return receives ? DEPOSITED : ABSORBED;
    }
    path.weight = after < before ? weight * (before / after) : weight;
    path.index *= scattered.eta;
    path.ray = leave(surface, scattered.wi, goes_through(surface, wo, scattered.wi));
    return ALIVE;
}

bool is_finite(Path path) {
    vec3 size = abs(path.ray.origin) + abs(path.ray.direction) + abs(path.weight);
    return all(lessThan(size, vec3(INFINITY_T)));
}

// Whether a path carries anything: not one that begins where an image on a lamp is black.
bool is_lit(Path path) {
    return max(path.weight.x, max(path.weight.y, path.weight.z)) > 0.0;
}

// What becomes of a path: ALIVE, or how it ends.
uint follow(inout Path path) {
    if (!is_finite(path)) {
        return NOT_FINITE;
    }
    return is_lit(path) ? advance(path) : ABSORBED;
}

void main() {
    scene = scene_info_at(0u);
    uint invocation = offset + invocation_index();
    if (invocation >= stride) {
        return; // its photons are another invocation's
    }
    uint photon = first + invocation;
    uint ends[ALIVE] = uint[ALIVE](0u, 0u, 0u, 0u, 0u, 0u);
    uint emitted = 0u;
    bool alive = false;
    Path path;
    while (alive || photon < end) {
        if (!alive) {
            path = start_path(photon);
            photon += stride;
            emitted++;
        }
        uint state = follow(path);
        alive = state == ALIVE;
        if (!alive) {
            ends[state]++;
        }
    }
    atomicAdd(counters.value.deposited, ends[DEPOSITED]);
    atomicAdd(counters.value.absorbed, ends[ABSORBED]);
    atomicAdd(counters.value.escaped, ends[ESCAPED]);
    atomicAdd(counters.value.truncated, ends[TRUNCATED]);
    atomicAdd(counters.value.lost_in_glass, ends[LOST_IN_GLASS]);
    atomicAdd(counters.value.non_finite, ends[NOT_FINITE]);
    atomicAdd(counters.value.emitted, emitted);
    if (interrupted(two)) {
        atomicAdd(counters.value.interrupted, 1u);
    }
}
