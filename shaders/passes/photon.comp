// photon: emits photons, traces them, and records them where they meet diffuse surfaces.
//
// Invocations: `stride`; each traces every stride-th photon of the batch and begins the next one where
//   a path ends, so that lanes stay busy (path regeneration).
// Reads: the scene (set 0); places where it resumes.
// Writes: photons, rough_photons where HAS_ROUGH_GATHER, counters (atomic), places where IS_RESUMABLE; in a pilot,
//   pilot_numbers.
// Units: lengths in render units; weights are flux over the mean flux of a photon, per channel.
// Source: Jensen, "Global Illumination using Photon Maps", 1996.
#version 460
#include "geometry/contact.glsl"
#include "geometry/hit.glsl"
#include "geometry/normal.glsl"
#include "geometry/query.glsl"
#include "geometry/surface.glsl"
#include "geometry/surface_point.glsl"
#include "kernel/counters.glsl"
#include "kernel/interruption.glsl"
#include "kernel/invocation.glsl"
#include "light/emission.glsl"
#include "light/guide.glsl"
#include "light/photon_path.glsl"
#include "light/pilot.glsl"
#include "lookup/caustic.glsl"
#include "lookup/records.glsl"
#include "lookup/rough.glsl"
#include "material/bsdf.glsl"
#include "material/bump.glsl"
#include "material/dispersion.glsl"
#include "material/layers.glsl"
#include "material/material.glsl"
#include "math/random.glsl"
#include "medium/medium.glsl"
#include "scene/constants.glsl"
#include "scene/features.glsl"
#include "scene/materials.glsl"
#include "scene/scene.glsl"
#include "spectrum/spread.glsl"
#include "spectrum/wavelength.glsl"

STORED_TEXELS(PhotonRecord, photons)
STORED_TEXELS(PhotonRecord, rough_photons) // on rough surfaces: rough.glsl
UPDATED_BUFFER(PhotonPlace, places) // of invocations that go on
STORED_TEXELS(EmissionNumbers, pilot_numbers) // of the photons of a pilot

layout(push_constant) uniform Push {
    uint before_low;     // photons of the stream before this iteration: low word
    uint before_high;    // high word of that number
    uint half_of_rounds; // 0 or 1
    uint stream;         // number of the stream; photons of different streams are independent
    uint first;          // first photon of the batch
    uint end;            // photon after the last of the batch
    uint stride;         // number of invocations
    uint capacity;       // of photons, in records
    uint offset;         // first invocation of this dispatch
    uint resumed;        // 1 to go on from `places`; see interruption.glsl
    uint spread;         // one of `spread` invocations works; see interruption.glsl
    uint is_pilot;       // 1 in a pilot, whose photons are recorded with their numbers, direct ones too
    float color_radius;  // HAS_DISPERSION: within which colors are averaged, render units
};

// Pairs of random numbers of a photon path. Emission takes the first three. Each bounce then takes a
// pair for the direction and a pair for the lobe and Russian roulette.
const uint PAIR_BOUNCE = 3u;

// Random numbers of a photon. The photons of all iterations of a stream are one sequence, whose strata
// get finer as the render goes on.
Random random_of(uint photon) {
    uint index = before_low + photon;
    uint high = before_high + (index < photon ? 1u : 0u);
    // Eye paths hash the seed, photons its complement: their numbers are independent.
    uint seed = hash(~seed_of_half(scene.seed, half_of_rounds), high);
    return Random(stream == 0u ? seed : hash(seed, stream), index);
}

Path start_path(uint photon) {
    Random random = random_of(photon);
    EmissionNumbers numbers = emission_numbers(random);
    if (HAS_GUIDE) {
        if (is_pilot != 0u) {
            store_pilot_numbers(photon, numbers);
        }
    }
    Emission emission = emit(numbers);
    return Path(emission.ray, emission.weight, 0u, 1.0, random, false, false, no_hue(), no_spread());
}

// Stores a photon. `recorded` also counts photons past the end of the array, which tells the host that
// the array is too small.
void store_record(PhotonRecord photon) {
    uint slot = atomicAdd(counters.value.recorded, 1u);
    if (slot < capacity) {
        store_photons(slot, photon);
    }
}

// The same for photons on rough surfaces.
void store_rough_record(PhotonRecord photon) {
    uint slot = atomicAdd(counters.value.recorded_rough, 1u);
    if (slot < capacity) {
        store_rough_photons(slot, photon);
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

// The result of one segment of a path.
struct Segment {
    uint state;       // ALIVE, or how the path ends
    bool is_immersed; // it met a diffuse surface inside a dielectric
    bool has_record;  // IS_RESUMABLE: it recorded a photon, stored once it is known to be complete
    PhotonRecord photon;
    bool has_rough;   // the same for rough surfaces
    PhotonRecord rough;
};

// Records a photon at a diffuse surface. `mark` is that of caustic.glsl or of pilot.glsl.
void record_photon(inout Segment segment, Surface surface, Material material, vec3 wo, vec3 weight, uint mark) {
    vec3 facing = is_on_front(surface, material, wo) ? surface.normal : -surface.normal;
    PhotonRecord photon = PhotonRecord(surface.position, pack_normal(facing), weight, mark);
    if (IS_RESUMABLE) {
        segment.photon = photon;
        segment.has_record = true;
    } else {
        store_record(photon);
    }
}

// Records a photon at a rough surface.
void record_rough(inout Segment segment, PhotonRecord photon) {
    if (IS_RESUMABLE) {
        segment.rough = photon;
        segment.has_rough = true;
    } else {
        store_rough_record(photon);
    }
}

// Largest factor by which a shading normal far from the geometric normal raises a photon's weight.
const float MAX_COSINE_RATIO = 50.0;

// |cos| of w at one normal over |cos| at the other, bounded.
float cosine_ratio(vec3 w, vec3 over, vec3 under) {
    return min(abs(dot(w, over)) / max(abs(dot(w, under)), 1.0e-20), MAX_COSINE_RATIO);
}

// Factor of a photon's weight where it is recorded: photons arrive by the geometric normal, eye paths
// weight light by the shading normal (Veach 1997, section 5.3). It is 0 if the shading normal faces
// away, unless that normal decides the side.
float shading_factor_of_record(Surface surface, Material material, vec3 wo) {
    bool same_side = dot(wo, surface.shading_normal) * dot(wo, surface.normal) > 0.0;
    return same_side || is_bent(material) ? cosine_ratio(wo, surface.shading_normal, surface.normal) : 0.0;
}

// Factor of the adjoint BSDF, by which a photon scatters (Veach 1997, equation 5.19). It is 0 on a
// diffuse surface if the shading normal and the geometric normal disagree about the side, unless the shading
// normal decides it. There, cosines at that normal may be as small as those at the geometric normal: those of a
// reflection cancel, so that the whole factor is bounded.
float shading_factor_of_bounce(Surface surface, Material material, vec3 wo, vec3 wi) {
    if (is_bent(material)) {
        float under = abs(dot(wo, surface.normal) * dot(wi, surface.shading_normal));
        return min(abs(dot(wo, surface.shading_normal) * dot(wi, surface.normal)) / max(under, 1.0e-20), MAX_COSINE_RATIO);
    }
    float factor = cosine_ratio(wo, surface.shading_normal, surface.normal)
                 * cosine_ratio(wi, surface.normal, surface.shading_normal);
    bool agree_o = dot(wo, surface.shading_normal) * dot(wo, surface.normal) > 0.0;
    bool agree_i = dot(wi, surface.shading_normal) * dot(wi, surface.normal) > 0.0;
    return is_specular(material) || (agree_o && agree_i) ? factor : 0.0;
}

// The size of a weight. The color of a wavelength has negative channels.
float largest_channel(vec3 weight) {
    if (HAS_DISPERSION) {
        weight = abs(weight);
    }
    return max(weight.x, max(weight.y, weight.z));
}

// Scatters a photon at a surface. Returns false if Russian roulette ends the path.
bool bounce(inout Path path, Surface surface, Material material) {
    vec3 wo = -path.ray.direction;
    uint pair = PAIR_BOUNCE + 2u * (path.depth - 1u);
    vec2 u = random_pair(path.random, pair + 1u);
    if (HAS_LAYERS) {
        material = choose_lobe(material, abs(dot(wo, surface.shading_normal)), u.x);
    }
    bool specular = is_specular(material);
    if (HAS_CAUSTIC_LAYER) {
        path.met_diffuse = path.met_diffuse || !specular;
    }
    if (HAS_ROUGH_GATHER) {
        path.met_rough = path.met_rough || !specular || is_rough(material);
    }
    vec2 u_direction = specular && !is_rough(material) ? vec2(0.0) : random_pair(path.random, pair);
    vec3 color = vec3(1.0);
    if (HAS_DISPERSION) {
        color = take_wavelength(material, path.hue, u.x, wo, surface.shading_normal, path.random);
    }
    Scatter scattered = scatter(material, wo, surface.shading_normal, surface.tangent, u.x, u_direction, FLUX);
    if (HAS_DISPERSION) {
        if (specular) {
            compare_chances(path.hue, material, path.spread, wo, scattered, surface.shading_normal);
            bend_spread(path.spread, material, wo, scattered.wi, scattered.eta);
        } else {
            color = path.hue.window >= 1.0 ? color_of_photon(path.random, path.hue) : color;
            diffuse_hue(path);
        }
    }
    keep_media(scattered, surface, material, wo, FLUX);
    vec3 weight = path.weight * scattered.weight;
    if (HAS_DISPERSION) {
        weight *= color;
    }
    if (HAS_SHADING_NORMALS) {
        weight *= shading_factor_of_bounce(surface, material, wo, scattered.wi);
    }
    // Russian roulette keeps the largest channel of the weight as it was.
    float before = largest_channel(path.weight);
    float after = largest_channel(weight);
    if (u.y * before >= after) {
        return false;
    }
    path.weight = after < before ? weight * (before / after) : weight;
    path.medium_eta *= scattered.eta;
    path.ray = spawn_ray(surface, scattered.wi, crosses_surface(surface, wo, scattered.wi));
    return true;
}

// Goes on from the end of a segment, and returns ALIVE or how the path ends. The first surface records no
// photon, since the eye pass samples direct light; it does if photons are to carry all light.
uint advance(inout Path path, Hit hit, inout Segment segment) {
    if (hit.primitive == NONE) {
        return is_in_glass(path.medium_eta) ? LOST_IN_GLASS : ESCAPED;
    }
    if (HAS_PORTALS) {
        if (path.depth == 0u && ends_before_portal(path.random, path.ray, hit.t)) {
            return ABSORBED;
        }
    }
    Surface surface = surface_at(path.ray, hit);
    if (HAS_DISPERSION) {
        move_spread(path.spread, path.ray.direction, hit.t, surface.normal);
        path.hue.window = window_of(path.spread, color_radius);
    }
    if (HAS_MEDIA) {
        if (!(largest_channel(path.weight) > 0.0)) {
            return ABSORBED; // by a medium
        }
        set_media(surface, path.ray.medium);
    }
    Material material = material_at(surface);
    if (HAS_DISPERSION) {
        set_index(material, path.hue);
    }
    apply_bumps(surface, material);
    vec3 wo = -path.ray.direction;
    bool receives = receives_photons(material);
    if (receives && is_in_glass(path.medium_eta)) {
        // A diffuse surface in a pool or in glass; else the path has missed its way out of a dielectric.
        segment.is_immersed = true;
        path.medium_eta = 1.0;
    }
    bool is_wanted = DIRECT_NEE ? path.depth > 0u : true;
    if (HAS_GUIDE) {
        is_wanted = is_wanted || is_pilot != 0u;
    }
    float shading = 1.0;
    if (HAS_SHADING_NORMALS) {
        shading = shading_factor_of_record(surface, material, wo);
        is_wanted = is_wanted && shading > 0.0;
    }
    if (receives && is_wanted) {
        float cos_i = abs(dot(wo, surface.shading_normal));
        Material base = receiving_material_at(material, surface);
        vec3 kept = path.weight * (transmittance_to_base(base, cos_i) * shading);
        if (HAS_DISPERSION) {
            Hue hue = path.hue;
            compare_transmittances(hue, base, cos_i);
            kept *= color_of_photon(path.random, hue);
        }
        uint mark = caustic_mark(path.depth > 0u && !path.met_diffuse);
        if (HAS_GUIDE) {
            mark = is_pilot != 0u ? pilot_mark(path.random.index, path.depth) : mark;
        }
        record_photon(segment, surface, material, wo, scattering_factor(base, cos_i, kept), mark);
    }
    if (HAS_ROUGH_GATHER) {
        if (path.depth > 0u && !path.met_rough && gathers_on_facets(material) && is_from_unmet_light(path.random)) {
            float ratio = HAS_SHADING_NORMALS ? cosine_ratio(wo, surface.shading_normal, surface.normal) : 1.0;
            vec3 weight = path.weight * ratio;
            if (HAS_DISPERSION) {
                weight *= color_of_photon(path.random, path.hue);
            }
            record_rough(segment, rough_record(surface, wo, weight));
        }
    }
    path.depth++;
    if (path.depth >= scene.max_depth) {
        return TRUNCATED;
    }
    return bounce(path, surface, material) ? ALIVE : receives ? DEPOSITED : ABSORBED;
}

bool is_finite(Path path) {
    vec3 size = abs(path.ray.origin) + abs(path.ray.direction) + abs(path.weight);
    return all(lessThan(size, vec3(INFINITY_T)));
}

// How a path ends before its next segment, or ALIVE. A path of weight 0, from where an image on a lamp is
// black, is absorbed.
uint fate(Path path) {
    return !is_finite(path) ? NOT_FINITE : largest_channel(path.weight) > 0.0 ? ALIVE : ABSORBED;
}

// How many paths have ended in which way.
struct Ends {
    uint deposited;
    uint absorbed;
    uint escaped;
    uint truncated;
    uint lost_in_glass;
    uint non_finite;
};

void count_end(inout Ends ends, uint state) {
    ends.deposited += state == DEPOSITED ? 1u : 0u;
    ends.absorbed += state == ABSORBED ? 1u : 0u;
    ends.escaped += state == ESCAPED ? 1u : 0u;
    ends.truncated += state == TRUNCATED ? 1u : 0u;
    ends.lost_in_glass += state == LOST_IN_GLASS ? 1u : 0u;
    ends.non_finite += state == NOT_FINITE ? 1u : 0u;
}

// The photons of an invocation.
struct Work {
    Path path;       // that it follows
    bool alive;      // there is such a path
    bool waits;      // for the hit of its next segment
    uint photon;     // the next one to begin
    Ends ends;       // of paths that have ended
    uint emitted;    // number of paths begun
    uint immersed;   // number of paths that met a diffuse surface inside a dielectric
    bool advanced;   // IS_RESUMABLE: this dispatch has finished a segment
};

#include "geometry/trace.glsl"

// Finishes the segment whose hit is known, if there is one, and asks for that of the next segment: of the
// same path or, where that has ended, of the next photon's.
bool next_query(inout Work work, inout Query query, Hit hit) {
    Work next = work;
    PhotonRecord none = PhotonRecord(vec3(0.0), 0u, vec3(0.0), 0u);
    Segment segment = Segment(ALIVE, false, false, none, false, none);
    if (next.waits) {
        if (HAS_MEDIA) {
            next.path.weight *= transmittance_of(query, hit);
            next.path.ray.medium = query.ray.medium;
        }
        segment.state = advance(next.path, hit, segment);
        segment.state = segment.state == ALIVE ? fate(next.path) : segment.state;
        next.alive = segment.state == ALIVE;
        next.immersed += segment.is_immersed ? 1u : 0u;
        count_end(next.ends, segment.state);
        next.advanced = true;
    }
    if (!next.alive && next.photon < end) {
        next.path = start_path(next.photon);
        next.photon += stride;
        next.emitted++;
        uint state = fate(next.path);
        next.alive = state == ALIVE;
        count_end(next.ends, state);
    }
    if (IS_RESUMABLE) {
        if (interrupted()) {
            return true; // the driver ended this segment early: it does not count
        }
        if (segment.has_record) {
            store_record(segment.photon);
        }
        if (segment.has_rough) {
            store_rough_record(segment.rough);
        }
    }
    next.waits = next.alive;
    work = next;
    query = no_query();
    if (work.alive) {
        query = nearest_hit(work.path.ray);
        if (HAS_DISPERSION) {
            query.split = Split(work.path.hue, work.path.spread, color_radius);
        }
    }
    return work.alive || work.photon < end;
}

// Goes on from the place of an invocation. Returns false if the invocation has nothing to do in this
// dispatch.
bool resume(uint number, inout Work work) {
    PhotonPlace place = places.data[number];
    work.photon = place.photon;
    work.alive = (place.alive & 1u) != 0u;
    work.path = path_of(place, random_of(place.photon - stride));
    return place.state == (spread > 1u ? STUCK : UNFINISHED);
}

// Cuts a path that the driver cannot follow even where the invocation is alone.
void cut_path(inout Work work) {
    work.photon += work.alive ? 0u : stride;
    work.emitted += work.alive ? 0u : 1u;
    work.alive = false;
    work.advanced = true;
    count_end(work.ends, TRUNCATED);
    atomicAdd(counters.value.cut, 1u);
}

// Stores the place from which the next dispatch goes on.
void store_place(uint number, Work work) {
    uint state = work.alive || work.photon < end ? (work.advanced ? UNFINISHED : STUCK) : FINISHED;
    places.data[number] = place_of(work.path, work.alive, work.photon, state);
    atomicAdd(counters.value.unfinished, state == UNFINISHED ? 1u : 0u);
    atomicAdd(counters.value.stuck, state == STUCK ? 1u : 0u);
}

void add_counts(Work work) {
    atomicAdd(counters.value.deposited, work.ends.deposited);
    atomicAdd(counters.value.absorbed, work.ends.absorbed);
    atomicAdd(counters.value.escaped, work.ends.escaped);
    atomicAdd(counters.value.truncated, work.ends.truncated);
    atomicAdd(counters.value.lost_in_glass, work.ends.lost_in_glass);
    atomicAdd(counters.value.non_finite, work.ends.non_finite);
    atomicAdd(counters.value.immersed, work.immersed);
    atomicAdd(counters.value.emitted, work.emitted);
}

void main() {
    uint number = invocation_index();
    // Of `spread` invocations one works, so that it has the rounds of loops to itself.
    bool works = true;
    if (IS_RESUMABLE) {
        works = number % spread == 0u;
        number /= spread;
    }
    works = works && offset + number < stride; // other invocations take all photons
    Path none = Path(free_ray(vec3(0.0), vec3(0.0)), vec3(0.0), 0u, 1.0, Random(0u, 0u), false, false, no_hue(), no_spread());
    Work work = Work(none, false, false, first + offset + number, Ends(0u, 0u, 0u, 0u, 0u, 0u), 0u, 0u, false);
    if (IS_RESUMABLE) {
        if (works && resumed != 0u) {
            works = resume(number, work);
        }
    }
    trace_queries(work, works && (work.alive || work.photon < end));
    if (!works) {
        return;
    }
    if (IS_RESUMABLE) {
        if (!work.advanced && spread > 1u) {
            cut_path(work);
        }
        store_place(number, work);
    }
    add_counts(work);
    if (IS_RESUMABLE) {
        return;
    }
    if (interrupted()) {
        atomicAdd(counters.value.interrupted, 1u);
    }
}
