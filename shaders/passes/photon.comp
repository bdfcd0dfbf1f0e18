// photon: emit photons, trace them, and record them where they meet diffuse surfaces.
// Each invocation traces every stride-th photon of the batch, starting the next where a
// path ends, so that lanes stay busy (path regeneration). Writes photons, counters
// (atomic), and where it is resumable, places. Weights are in units of the mean flux of a
// photon. Jensen 1996.
#version 460
#include "geometry/alpha.glsl"
#include "geometry/contact.glsl"
#include "geometry/hit.glsl"
#include "geometry/normal.glsl"
#include "geometry/surface.glsl"
#include "geometry/surface_point.glsl"
#include "kernel/counters.glsl"
#include "kernel/interruption.glsl"
#include "kernel/invocation.glsl"
#include "light/emission.glsl"
#include "lookup/records.glsl"
#include "material/bsdf.glsl"
#include "material/layers.glsl"
#include "material/material.glsl"
#include "math/random.glsl"
#include "scene/constants.glsl"
#include "scene/features.glsl"
#include "scene/materials.glsl"
#include "scene/scene.glsl"

// Where an invocation of the photon pass has got to.
struct PhotonPlace {
    vec3 origin; // of the path's next ray
    float index; // of the medium, over the one where the path began
    vec3 direction; // of that ray
    uint depth;     // segments of the path so far
    vec3 weight;    // flux over the mean flux of a photon
    uint photon; // to be started next; the path's own is the one before
    uint state;  // FINISHED, UNFINISHED or STUCK
    uint alive;  // 1 if there is a path
    float begin;    // of the ray: contact.glsl
    uint contacts;  // of the ray: contact.glsl
};

STORED_TEXELS(PhotonRecord, photons)
UPDATED_BUFFER(PhotonPlace, places) // of invocations that go on

layout(push_constant) uniform Push {
    uint before_low; // photons of its stream before this iteration: low word
    uint before_high; // high word of that number
    uint half_of_rounds; // 0 or 1
    uint stream;         // photons of different streams are independent of each other
    uint first; // first photon of the dispatch
    uint end; // end of the iteration's photons
    uint stride; // an invocation takes every stride-th photon
    uint capacity;    // of photons
    uint offset;      // of this dispatch's invocations
    uint resumed; // 1 to go on from places: interruption.glsl
    uint spread; // of this number of invocations one works: interruption.glsl
    uint two; // 2: interruption.glsl
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
Random random_of(uint photon) {
    uint index = before_low + photon;
    uint high = before_high + (index < photon ? 1u : 0u);
    // Eye paths hash the seed itself: its complement keeps the two apart.
    uint seed = hash(~seed_of_half(scene.seed, half_of_rounds), high);
    return Random(stream == 0u ? seed : hash(seed, stream), index);
}

Path start_path(uint photon) {
    Random random = random_of(photon);
    Emission emission = emit(random);
    return Path(emission.ray, emission.weight, 0u, 1.0, random);
}

// Those past the end of the array count, so that the host hears of them.
void store_record(PhotonRecord photon) {
    uint slot = atomicAdd(counters.value.recorded, 1u);
    if (slot < capacity) {
        store_photons(slot, photon);
    }
}

// What a segment has recorded: stored once it is known that the driver did not end it early.
PhotonRecord recorded;
bool has_recorded;
// Whether a segment met something opaque in a dielectric.
bool is_immersed;

void record(Surface surface, vec3 wo, vec3 weight) {
    vec3 facing = dot(wo, surface.normal) < 0.0 ? -surface.normal : surface.normal;
    PhotonRecord photon = PhotonRecord(surface.position, pack_normal(facing), weight, 0u);
    if (IS_RESUMABLE) {
        recorded = photon;
        has_recorded = true;
    } else {
        store_record(photon);
    }
}

// A photon's weight may grow by this factor where a shading normal is far from the geometric one.
const float MOST_SHADING = 50.0;

// |cos| at one normal over |cos| at the other, bounded.
float cosine_ratio(vec3 w, vec3 over, vec3 under) {
    return min(abs(dot(w, over)) / max(abs(dot(w, under)), 1.0e-20), MOST_SHADING);
}

// What a diffuse surface receives of a photon: photons arrive by the geometric normal, eye paths
// weight light by the shading normal (Veach 1997, section 5.3). Nothing where that is turned away.
float shading_of_arrival(Surface surface, vec3 wo) {
    bool same_side = dot(wo, surface.shading_normal) * dot(wo, surface.normal) > 0.0;
    return same_side ? cosine_ratio(wo, surface.shading_normal, surface.normal) : 0.0;
}

// Factor of the adjoint bsdf, which a photon scatters by (Veach 1997, equation 5.19). A diffuse
// surface sends nothing to where its shading normal and its geometric one disagree about the side.
float shading_of_scattering(Surface surface, bool specular, vec3 wo, vec3 wi) {
    float factor = cosine_ratio(wo, surface.shading_normal, surface.normal)
                 * cosine_ratio(wi, surface.normal, surface.shading_normal);
    bool agree_o = dot(wo, surface.shading_normal) * dot(wo, surface.normal) > 0.0;
    bool agree_i = dot(wi, surface.shading_normal) * dot(wi, surface.normal) > 0.0;
    return specular || (agree_o && agree_i) ? factor : 0.0;
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
        is_immersed = true;
        path.index = 1.0;
    }
    bool is_wanted = DIRECT_NEE ? path.depth > 0u : true;
    float shading = 1.0;
    if (HAS_SHADING_NORMALS) {
        shading = shading_of_arrival(surface, wo);
        is_wanted = is_wanted && shading > 0.0;
    }
    if (receives && is_wanted) {
        record(surface, wo, path.weight * (entering(material, cos_o) * shading));
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
    vec2 u_direction = specular && !is_rough(material) ? vec2(0.0) : random_pair(path.random, pair);
    Scatter scattered = scatter(material, wo, surface.shading_normal, surface.tangent, u.x, u_direction, FLUX);
    // Russian roulette keeps the largest channel of every photon's weight constant.
    vec3 weight = path.weight * scattered.weight;
    if (HAS_SHADING_NORMALS) {
        weight *= shading_of_scattering(surface, specular, wo, scattered.wi);
    }
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
    uint number = invocation_index();
    if (IS_RESUMABLE) {
        if (number % spread != 0u) {
            return; // another invocation of the workgroup is to be alone
        }
        number /= spread;
    }
    uint invocation = offset + number;
    if (invocation >= stride) {
        return; // its photons are another invocation's
    }
    uint photon = first + invocation; // the next one to start
    uint ends[ALIVE] = uint[ALIVE](0u, 0u, 0u, 0u, 0u, 0u);
    uint emitted = 0u;
    uint immersed = 0u;
    bool alive = false;
    Path path;
    bool advanced = false;
    if (IS_RESUMABLE && resumed != 0u) {
        PhotonPlace place = places.data[number];
        if (place.state != (spread > 1u ? STUCK : UNFINISHED)) {
            return;
        }
        photon = place.photon;
        alive = place.alive != 0u;
        Ray ray = saved_ray(place.origin, place.direction, place.begin, place.contacts);
        path = Path(ray, place.weight, place.depth, place.index, random_of(photon - stride));
    }
    while (alive || photon < end) {
        Path next = path;
        if (!alive) {
            next = start_path(photon);
        }
        is_immersed = false;
        has_recorded = false;
        uint state = follow(next);
        if (IS_RESUMABLE) {
            if (interrupted(two)) {
                break; // nothing of this segment counts
            }
            advanced = true;
            if (has_recorded) {
                store_record(recorded);
            }
        }
        path = next;
        photon += alive ? 0u : stride;
        emitted += alive ? 0u : 1u;
        immersed += is_immersed ? 1u : 0u;
        alive = state == ALIVE;
        if (!alive) {
            ends[state]++;
        }
    }
    if (IS_RESUMABLE) {
        if (!advanced && spread > 1u) {
            // Even alone.
            photon += alive ? 0u : stride;
            emitted += alive ? 0u : 1u;
            alive = false;
            ends[TRUNCATED]++;
            atomicAdd(counters.value.cut, 1u);
            advanced = true;
        }
        uint state = alive || photon < end ? (advanced ? UNFINISHED : STUCK) : FINISHED;
        places.data[number] = PhotonPlace(path.ray.origin, path.index, path.ray.direction, path.depth, path.weight, photon,
                                          state, alive ? 1u : 0u, begin_of(path.ray), contacts_of(path.ray));
        atomicAdd(counters.value.unfinished, state == UNFINISHED ? 1u : 0u);
        atomicAdd(counters.value.stuck, state == STUCK ? 1u : 0u);
    }
    atomicAdd(counters.value.deposited, ends[DEPOSITED]);
    atomicAdd(counters.value.absorbed, ends[ABSORBED]);
    atomicAdd(counters.value.escaped, ends[ESCAPED]);
    atomicAdd(counters.value.truncated, ends[TRUNCATED]);
    atomicAdd(counters.value.lost_in_glass, ends[LOST_IN_GLASS]);
    atomicAdd(counters.value.non_finite, ends[NOT_FINITE]);
    atomicAdd(counters.value.immersed, immersed);
    atomicAdd(counters.value.emitted, emitted);
    if (IS_RESUMABLE) {
        return;
    }
    if (interrupted(two)) {
        atomicAdd(counters.value.interrupted, 1u);
    }
}
