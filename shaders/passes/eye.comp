// eye: traces camera paths through each pixel to the first diffuse surface.
//
// Invocations: one per pixel, in tiles of 8 x 8. Each traces `paths` paths.
// Reads: the scene (set 0), camera, filter_table; places where it resumes.
// Writes: visible_points, visible_throughputs (where the last path ended), visible_radiances (mean of
//   all paths' emission and direct light, which are noisier than the photons' light and cheaper to
//   sample; until all have ended, the sum), rough_points where HAS_ROUGH_GATHER, counters (atomic), places where
//   IS_RESUMABLE.
// Units: lengths in render units, radiance in W/(m^2 sr); throughputs are the path's throughput times
//   the BSDF, 1/sr.
// Source: Hachisuka and Jensen, "Stochastic Progressive Photon Mapping", 2009, section 3.
#version 460
#include "camera/eye_state.glsl"
#include "camera/kept.glsl"
#include "camera/rough_gather.glsl"
#include "camera/rough_path.glsl"
#include "camera/sample.glsl"
#include "camera/visible_end.glsl"
#include "geometry/contact.glsl"
#include "geometry/hit.glsl"
#include "geometry/normal.glsl"
#include "geometry/query.glsl"
#include "geometry/quadric.glsl"
#include "geometry/surface.glsl"
#include "geometry/surface_point.glsl"
#include "kernel/counters.glsl"
#include "kernel/interruption.glsl"
#include "kernel/invocation.glsl"
#include "kernel/tile.glsl"
#include "light/light.glsl"
#include "lookup/records.glsl"
#include "material/bsdf.glsl"
#include "material/bump.glsl"
#include "material/dispersion.glsl"
#include "material/layers.glsl"
#include "material/material.glsl"
#include "math/random.glsl"
#include "math/sampling.glsl"
#include "medium/medium.glsl"
#include "scene/constants.glsl"
#include "scene/features.glsl"
#include "scene/lights.glsl"
#include "scene/materials.glsl"
#include "scene/scene.glsl"
#include "spectrum/spread.glsl"
#include "spectrum/wavelength.glsl"

UPDATED_BUFFER(EyePlace, places) // of invocations that go on

layout(push_constant) uniform Push {
    uint turn;           // number of the round among those of its half
    uint half_of_rounds; // 0 or 1
    uint paths;          // paths per pixel
    uint offset;         // first invocation of this dispatch
    uint resumed;        // 1 to go on from `places`; see interruption.glsl
    uint spread;         // one of `spread` invocations works; see interruption.glsl
    float color_radius;  // HAS_DISPERSION: within which colors are averaged, render units; of a parallel projection
    float color_radius_per_length; // that radius over the length of the path, of other projections
};

// Pairs of random numbers of an eye path. The camera takes the first two. Scattering takes one pair per
// bounce from PAIR_LOBE on. Where surfaces may be rough, it takes three more: one for the microfacet and
// two for a light.
const uint PAIR_LIGHT = 2u; // and the next one
const uint PAIR_BSDF = 4u;
const uint PAIR_LOBE = 5u;

uint pair_of_bounce(uint depth) {
    if (HAS_ROUGH) {
        return PAIR_LOBE + 4u * depth;
    }
    return PAIR_LOBE + depth;
}

bool is_finite(vec3 v) {
    return all(lessThan(abs(v), vec3(INFINITY_T)));
}

// What an invocation waits to know.
const uint BEGINS = 0u;      // nothing: the next path is to begin
const uint RESUMES = 1u;     // nothing: the path goes on from a place
const uint FOLLOWS = 2u;     // the hit of the path's next segment
const uint ASKS_ROUGH = 3u;  // whether light to a rough surface is blocked
const uint ASKS_POINT = 4u;  // whether light to the visible point is blocked

// The paths of an invocation's pixel.
struct Work {
    uint pixel;
    Kept kept;
    uint done;           // number of finished paths
    float filter_weight; // of the path that it follows
    EyeState state;
    VisibleEnd end;
    uint asks;           // BEGINS, ..
    bool goes_on;        // the path has another segment
    bool is_lost;        // the path left the scene from within a dielectric
    bool is_immersed;    // it ended on a diffuse surface inside a dielectric
    vec3 rough_radiance; // from one light by way of a rough surface, unless it is blocked; W/(m^2 sr)
    Ray to_light;        // from there
    RoughPoint rough_point; // HAS_ROUGH_GATHER: at the end of the segment, if the path's point moves there
    EyeState start;      // IS_RESUMABLE: the state before the last segment
    bool advanced;       // IS_RESUMABLE: this dispatch has finished a segment
};

#include "geometry/trace.glsl"

uint seed_of(uint pixel) {
    return hash(seed_of_half(scene.seed, half_of_rounds), pixel);
}

// The random numbers of the path that an invocation follows.
Random random_of(Work work) {
    uint seed = work.kept.seed;
    if (FEW_REGISTERS) {
        seed = seed_of(work.pixel);
    }
    return Random(seed, turn * paths + work.done);
}

// Adds the radiance from infinitely far away to a path whose ray leaves the scene.
void meet_infinity(inout Work work) {
    vec3 w = work.state.ray.direction;
    bool has_point = work.end.is_reached;
    if (HAS_DISPERSION) {
        if (!has_point) {
            find_window(work.state, 2.0 * scene.radius, w, color_radius, color_radius_per_length);
        }
    }
    float pdf = has_point ? max(work.end.cosine, 0.0) / PI : escape_pdf(work.state.rough);
    work.state.radiance += work.state.throughput * radiance_from_infinity(work.state.ray.origin, w, work.state.hue, pdf);
    work.is_lost = !has_point && is_in_glass(work.state.medium_eta);
}

// Adds the emission of a surface that a path has met.
void meet_emitter(inout Work work, Surface surface) {
    vec3 w = work.state.ray.direction;
    Light light = direct_light(surface.light, work.state.hue);
    float weight = emission_mis_weight(work.state.rough, light, surface, w);
    if (work.end.is_reached) {
        weight = diffuse_mis_weight(light, work.end, surface, w);
    }
    work.state.radiance += work.state.throughput * emitted_radiance(light, surface, -w) * weight;
}

// Makes a diffuse surface the visible point of a path, and turns its normals to the side of the path.
void reach_diffuse(inout Work work, inout Surface surface, Material material) {
    vec3 wo = -work.state.ray.direction;
    work.is_immersed = is_in_glass(work.state.medium_eta);
    bool front = is_on_front(surface, material, wo);
    if (HAS_DIFFUSE_TRANSMISSION) {
        front = front != ((material.flags & BEHIND) != 0u);
    }
    surface.normal = front ? surface.normal : -surface.normal;
    if (HAS_MEDIA) {
        surface.media = front ? surface.media : surface.media.yx;
    }
    surface.shading_normal = front ? surface.shading_normal : -surface.shading_normal;
    vec3 bsdf = work.state.throughput * material.color / PI; // times the throughput, 1/sr
    if (HAS_SIGNED_FILTER) {
        bsdf *= work.filter_weight;
    }
    work.end.position = surface.position;
    work.end.is_reached = true;
    vec4 throughput = vec4(bsdf, max(work.state.travelled, SHORTEST_PATH));
    if (HAS_DISPERSION) {
        compare_transmittances(work.state.hue, material, abs(dot(wo, surface.shading_normal)));
        throughput.rgb *= color_of(scene.colors, work.state.hue);
        work.state.spread.direction = vec3(0.0);
    }
    keep_point(work.kept, work.pixel, surface.position, surface.normal, throughput);
    work.end.direct = vec3(0.0);
    if (DIRECT_NEE) {
        work.end.direct = bsdf * sample_direct_irradiance(surface, material, work.state.hue, random_of(work),
                                                          PAIR_LIGHT, work.end.to_light);
    }
}

// Samples the direction in which a path goes on from a surface that is not diffuse, and a light for it.
Scatter leave_specular(inout Work work, Surface surface, Material material, float u_lobe, uint pair) {
    vec3 wo = -work.state.ray.direction;
    vec2 u_facet = is_rough(material) ? random_pair(random_of(work), pair + 1u) : vec2(0.0);
    Scatter scattered = scatter_specular(material, wo, surface.shading_normal, surface.tangent, u_lobe, u_facet, RADIANCE);
    keep_media(scattered, surface, material, wo, RADIANCE);
    Hue hue = work.state.hue;
    if (HAS_DISPERSION) {
        compare_chances(work.state.hue, material, work.state.spread, wo, scattered, surface.shading_normal);
        bend_spread(work.state.spread, material, wo, scattered.wi, scattered.eta);
        hue = hue_beyond(work.state, scene.radius, color_radius, color_radius_per_length);
    }
    if (HAS_ROUGH) {
        vec3 reflected = direct_light_on_rough(surface, material, wo, hue, random_of(work), pair + 2u, work.to_light);
        work.rough_radiance = work.state.throughput * reflected;
        work.asks = work.rough_radiance != vec3(0.0) ? ASKS_ROUGH : FOLLOWS;
    }
    if (HAS_ROUGH_GATHER) {
        float u = random_pair(random_of(work), pair).y;
        vec3 throughput = work.state.throughput * (HAS_SIGNED_FILTER ? work.filter_weight : 1.0);
        if (HAS_DISPERSION) {
            throughput *= color_of(scene.colors, hue);
        }
        RoughPoint point = rough_point(surface, material, wo, throughput, max(work.state.travelled, SHORTEST_PATH));
        choose_rough_point(work.rough_point, work.state.rough_met, point, is_rough(material), u);
    }
    work.state.rough = rough_vertex(surface, material, wo, scattered.wi);
    return scattered;
}

// Goes on from the end of a segment. Returns whether the path has another one.
//
// A path ends on the first diffuse surface. From there one sample of the BSDF looks for lights: the better
// technique for large lights, and the only one for constant infinite lights, which a cosine lobe samples
// perfectly (Veach 1997, chapter 9).
bool follow(inout Work work, Hit hit) {
    if (hit.primitive == NONE) {
        meet_infinity(work);
        return false;
    }
    work.state.travelled += hit.t;
    Surface surface = surface_at(work.state.ray, hit);
    if (HAS_MEDIA) {
        set_media(surface, work.state.ray.medium);
    }
    Material material = material_at(surface);
    if (HAS_DISPERSION) {
        if (!work.end.is_reached) {
            find_window(work.state, hit.t, surface.normal, color_radius, color_radius_per_length);
        }
        set_index(material, work.state.hue);
    }
    apply_bumps(surface, material);
    vec3 wo = -work.state.ray.direction;
    if (HAS_AREA_LIGHTS && surface.light != NONE) {
        meet_emitter(work, surface);
    }
    if (work.end.is_reached) {
        return false;
    }
    Scatter scattered = Scatter(wo, vec3(0.0), 1.0);
    uint pair = pair_of_bounce(work.state.depth);
    float u_lobe = random_pair(random_of(work), pair).x;
    if (HAS_LAYERS) {
        material = choose_lobe(material, abs(dot(wo, surface.shading_normal)), u_lobe);
    }
    work.state.rough = no_rough_vertex();
    if (is_specular(material)) {
        if (HAS_DISPERSION) {
            work.state.throughput *= take_wavelength(material, work.state.hue, u_lobe, wo, surface.shading_normal,
                                                     random_of(work));
        }
        scattered = leave_specular(work, surface, material, u_lobe, pair);
    } else {
        reach_diffuse(work, surface, material);
        if (!samples_bsdf_for_lights(surface.position)) {
            return false;
        }
        scattered.wi = sample_cosine(random_pair(random_of(work), PAIR_BSDF), surface.shading_normal);
        work.end.cosine = dot(scattered.wi, surface.shading_normal);
        scattered.weight = material.color * transmittance_to_base(material, work.end.cosine);
        scattered.weight = scattering_factor(material, work.end.cosine, scattered.weight);
    }
    work.state.throughput *= scattered.weight;
    work.state.medium_eta *= scattered.eta;
    work.state.ray = spawn_ray(surface, scattered.wi, crosses_surface(surface, wo, scattered.wi));
    work.state.depth++;
    // A throughput of 0: the microfacet sends the path into the surface.
    bool is_dead = HAS_ROUGH && work.state.throughput == vec3(0.0);
    return !is_dead && (work.state.depth < scene.max_depth || work.end.is_reached);
}

// Counts what a path has met. A radiance that is not finite becomes 0, and is counted.
vec3 count_eye_path(Work work, vec3 radiance) {
    if (!is_finite(radiance)) {
        radiance = vec3(0.0);
        atomicAdd(counters.value.non_finite, 1u);
    }
    if (work.is_lost) {
        atomicAdd(counters.value.eye_lost_in_glass, 1u);
    }
    if (work.is_immersed) {
        atomicAdd(counters.value.immersed, 1u);
    }
    return radiance;
}

// The radiance of a path that has ended, times the filter. `is_lit`: nothing blocks the light to its point.
vec3 radiance_of(Work work, bool is_lit) {
    vec3 radiance = work.state.radiance;
    if (HAS_SIGNED_FILTER) {
        radiance *= work.filter_weight;
    }
    if (DIRECT_NEE && work.end.is_reached) {
        radiance += is_lit ? work.end.direct : vec3(0.0);
    }
    return radiance;
}

// Begins the next path of the pixel.
void begin_path(inout Work work) {
    CameraSample camera_sample = sample_camera(work.pixel, random_of(work));
    if (HAS_MEDIA) {
        camera_sample.ray.medium = scene.camera_medium;
    }
    work.filter_weight = camera_sample.weight;
    work.state = state_at_camera(camera_sample.ray);
    work.start = work.state;
    work.end.is_reached = false;
    work.asks = FOLLOWS;
    work.is_lost = false;
    work.is_immersed = false;
}

// Takes the answer that the path waits for. Returns whether the path goes on; if not, `radiance` is the path's.
bool take_answer(inout Work work, Hit hit, out vec3 radiance) {
    radiance = vec3(0.0);
    bool is_lit = hit.primitive == NONE;
    uint asked = work.asks;
    work.asks = FOLLOWS;
    if (asked == FOLLOWS) {
        work.goes_on = follow(work, hit);
    }
    if (HAS_ROUGH && asked == ASKS_ROUGH) {
        work.state.radiance += is_lit ? work.rough_radiance : vec3(0.0);
    }
    if (work.asks == ASKS_ROUGH || (work.goes_on && asked != ASKS_POINT)) {
        return true;
    }
    // The path has ended but for the light to its visible point.
    bool asks_point = asked != ASKS_POINT && work.end.is_reached && work.end.direct != vec3(0.0);
    if (DIRECT_NEE && asks_point) {
        work.asks = ASKS_POINT;
        return true;
    }
    radiance = count_eye_path(work, radiance_of(work, is_lit));
    return false;
}

// The ray of a path's next segment. Where the query has it, it is not kept twice.
Ray followed_ray(Work work, Query query) {
    if (HAS_ROUGH) {
        return work.state.ray; // the query may be about a light
    }
    if (HAS_PASSABLE) {
        return work.state.ray; // the query is about a part of the ray
    }
    if (FEW_REGISTERS) {
        return asked_ray(query);
    }
    return work.state.ray;
}

// Attenuates what waits for an answer by the media on its way, and finds the medium at the end of that.
void attenuate(inout Work work, Query query, Hit hit) {
    vec3 kept = transmittance_of(query, hit);
    if (work.asks == FOLLOWS) {
        work.state.throughput *= kept;
        work.state.ray.medium = query.ray.medium;
    } else if (work.asks == ASKS_POINT) {
        work.end.direct *= kept;
    } else if (HAS_ROUGH) {
        work.rough_radiance *= kept;
    }
}

// Takes an answer and asks the next question of the pixel's paths.
bool next_query(inout Work work, inout Query query, Hit hit) {
    Work next = work;
    next.state.ray = followed_ray(work, query);
    if (HAS_ROUGH_GATHER) {
        next.rough_point = no_rough_point();
    }
    vec3 radiance;
    bool goes_on = false;
    bool ends = false;
    if (next.asks >= FOLLOWS) {
        if (HAS_MEDIA) {
            attenuate(next, query, hit);
        }
        goes_on = take_answer(next, hit, radiance);
        ends = !goes_on;
        next.done += ends ? 1u : 0u;
        next.advanced = next.advanced || ends;
        next.start.depth = goes_on ? next.start.depth : 0u;
    }
    bool begins = !goes_on && next.done < paths;
    if (begins) {
        begin_path(next);
    }
    if (IS_RESUMABLE) {
        if (work.asks == RESUMES) {
            next.state = work.start;
            next.start = work.start;
        }
    }
    query = nearest_hit(next.state.ray);
    if (next.asks == ASKS_POINT) {
        query = blocks(next.end.to_light);
    } else if (HAS_ROUGH && next.asks == ASKS_ROUGH) {
        query = blocks(next.to_light);
    } else if (!next.end.is_reached && (goes_on || begins)) {
        next.advanced = next.advanced || next.state.depth > next.start.depth;
        next.start = next.state;
    }
    if (HAS_DISPERSION) {
        query.split = split_of(next.state, color_radius, color_radius_per_length);
    }
    if (IS_RESUMABLE) {
        if (interrupted()) {
            return true; // the driver ended this segment early: it does not count
        }
    }
    if (HAS_ROUGH_GATHER) {
        keep_rough_point(next.rough_point, work.pixel);
    }
    if (ends) {
        add_path(next.kept, work.pixel, work.done, radiance);
    }
    work = next;
    return goes_on || begins;
}

// Leaves out a path that the driver cannot follow even where the invocation is alone.
void cut_path(inout Work work) {
    add_path(work.kept, work.pixel, work.done, vec3(0.0));
    work.end.is_reached = false;
    work.state.rough_met = 0u;
    work.start.depth = 0u;
    work.done++;
    work.advanced = true;
    atomicAdd(counters.value.cut, 1u);
}

// Stores the place from which the next dispatch goes on.
void store_place(uint number, Work work) {
    EyePlace place = place_of(work.start);
    place.path = work.done;
    place.state = work.done == paths ? FINISHED : work.advanced ? UNFINISHED : STUCK;
    places.data[number] = place;
    atomicAdd(counters.value.unfinished, place.state == UNFINISHED ? 1u : 0u);
    atomicAdd(counters.value.stuck, place.state == STUCK ? 1u : 0u);
}

// Goes on from the place of an invocation. Returns false if the invocation has nothing to do in this
// dispatch.
bool resume(uint number, inout Work work) {
    EyePlace place = places.data[number];
    if (place.state != (spread > 1u ? STUCK : UNFINISHED)) {
        return false;
    }
    load_kept(work.kept, work.pixel);
    work.done = place.path;
    work.start = state_of(place);
    work.asks = place.depth > 0u ? RESUMES : BEGINS;
    return true;
}

void main() {
    uint number = invocation_index();
    // Of `spread` invocations one works, so that it has the rounds of loops to itself.
    bool works = true;
    if (IS_RESUMABLE) {
        works = number % spread == 0u;
        number /= spread;
    }
    Work work;
    work.pixel = pixel_of(offset + number, camera_at(0u).width, camera_at(0u).height);
    work.kept = begin_pixel(seed_of(work.pixel));
    work.done = 0u;
    work.advanced = false;
    works = works && work.pixel != NONE;
    work.asks = BEGINS;
    if (IS_RESUMABLE) {
        if (works && resumed != 0u) {
            works = resume(number, work);
        }
    }
    trace_queries(work, works);
    if (!works) {
        return;
    }
    if (IS_RESUMABLE) {
        if (!work.advanced && spread > 1u) {
            cut_path(work);
        }
        store_place(number, work);
        if (work.done < paths) {
            store_kept(work.kept, work.pixel);
            return;
        }
    }
    finish_pixel(work.kept, work.pixel, paths, work.end.is_reached);
    if (HAS_ROUGH_GATHER) {
        finish_rough_point(work.pixel, work.state.rough_met);
    }
    if (IS_RESUMABLE) {
        return;
    }
    if (interrupted()) {
        atomicAdd(counters.value.interrupted, 1u);
    }
}
