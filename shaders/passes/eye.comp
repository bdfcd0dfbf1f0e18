// eye: traces camera paths through each pixel to the first diffuse surface.
//
// Invocations: one per pixel, in tiles of 8 x 8. Each traces `paths` paths.
// Reads: the scene (set 0), camera, filter_table; places and visible_radiances where it resumes.
// Writes: visible_points, visible_throughputs (where the last path ended), visible_radiances (mean of
//   all paths' emission and direct light, which are noisier than the photons' light and cheaper to
//   sample), counters (atomic), places where IS_RESUMABLE.
// Units: lengths in render units, radiance in W/(m^2 sr); throughputs are the path's throughput times
//   the BSDF, 1/sr.
// Source: Hachisuka and Jensen, "Stochastic Progressive Photon Mapping", 2009, section 3.
#version 460
#include "camera/camera.glsl"
#include "camera/projection.glsl"
#include "camera/rough_path.glsl"
#include "geometry/alpha.glsl"
#include "geometry/contact.glsl"
#include "geometry/hit.glsl"
#include "geometry/normal.glsl"
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
#include "material/layers.glsl"
#include "material/material.glsl"
#include "math/random.glsl"
#include "math/sampling.glsl"
#include "scene/constants.glsl"
#include "scene/features.glsl"
#include "scene/lights.glsl"
#include "scene/materials.glsl"
#include "scene/scene.glsl"

// The path of an invocation that another dispatch goes on with: it has met no diffuse surface yet.
struct EyePlace {
    vec3 origin;        // of the path's next ray, render units
    float medium_eta;   // refractive index of the medium that the path is in, over the camera's
    vec3 direction;     // of that ray
    float travelled;    // length of the path so far, render units
    vec3 throughput;    // of the path so far
    uint depth;         // segments of the path so far
    vec3 radiance;      // emission met so far, W/(m^2 sr)
    uint path;          // number of the path among those of its pixel
    vec3 last_position; // of the RoughVertex
    float last_pdf;     // of the RoughVertex
    uint state;         // FINISHED, UNFINISHED or STUCK
    float begin;        // of the ray: contact.glsl
    uint contacts;      // of the ray: contact.glsl
    uint pad0;
};

TEXELS(Camera, camera)
TEXELS(float, filter_table)
STORED_TEXELS(VisiblePoint, visible_points)
STORED_TEXELS(vec4, visible_throughputs) // BSDF times throughput; w: length of the path, 0 if there is no point
UPDATED_TEXELS(vec4, visible_radiances) // W/(m^2 sr)
UPDATED_BUFFER(EyePlace, places) // of invocations that go on

layout(push_constant) uniform Push {
    uint turn;           // number of the round among those of its half
    uint half_of_rounds; // 0 or 1
    uint paths;          // paths per pixel
    uint offset;         // first invocation of this dispatch
    uint resumed;        // 1 to go on from `places`; see interruption.glsl
    uint spread;         // one of `spread` invocations works; see interruption.glsl
};

// Pairs of random numbers of an eye path. Scattering takes one pair per bounce from PAIR_LOBE on.
// Where surfaces may be rough, it takes three more: one for the microfacet and two for a light.
const uint PAIR_FILTER = 0u;
const uint PAIR_LENS = 1u;
const uint PAIR_LIGHT = 2u;
const uint PAIR_LIGHT_POINT = 3u;
const uint PAIR_BSDF = 4u;
const uint PAIR_LOBE = 5u;

uint pair_of_bounce(uint depth) {
    if (HAS_ROUGH) {
        return PAIR_LOBE + 4u * depth;
    }
    return PAIR_LOBE + depth;
}

// Least length of a path, in render units: a length of 0 stands for "no visible point".
const float SHORTEST_PATH = 1.0e-12;

// Offset of a camera sample from the pixel's centre, in pixels, for axis 0 (x) or 1 (y). Inverts the
// distribution of the pixel filter's magnitude: filter_table holds the edges of its cells per axis.
float filter_offset(uint axis, float u) {
    float scaled = u * float(FILTER_CELLS);
    uint i = min(uint(scaled), FILTER_CELLS - 1u);
    uint entry = (FILTER_CELLS + 1u) * axis + i;
    return mix(filter_table_at(entry), filter_table_at(entry + 1u), scaled - float(i));
}

// Weight of a camera sample, with a mean of 1 over all samples; negative where the filter is. The
// weights' tables follow the tables of offsets.
float filter_weight(uint axis, float u) {
    uint i = min(uint(u * float(FILTER_CELLS)), FILTER_CELLS - 1u);
    return filter_table_at((FILTER_CELLS + 1u) * (axis + 2u) + i);
}

struct CameraSample {
    Ray ray;
    float weight; // of the pixel filter
};

CameraSample sample_camera(uint pixel, Random random) {
    Camera view = camera_at(0u);
    vec2 u = random_pair(random, PAIR_FILTER);
    vec2 offset = vec2(filter_offset(0u, u.x), filter_offset(1u, u.y));
    vec2 at = vec2(pixel % view.width, pixel / view.width) + 0.5 + offset;
    vec2 image = at / vec2(view.width, view.height);
    vec2 lens = vec2(0.0);
    if (view.lens_radius > 0.0) {
        lens = sample_disk(random_pair(random, PAIR_LENS));
    }
    Ray ray = project(view, view.image_lower + image * view.image_extent, lens);
    ray = free_ray(transform_point(view.render_from_camera, ray.origin),
                   normalize(transform_vector(view.render_from_camera, ray.direction)));
    float weight = 1.0;
    if (HAS_SIGNED_FILTER) {
        weight = filter_weight(0u, u.x) * filter_weight(1u, u.y);
    }
    return CameraSample(ray, weight);
}

// An eye path that has met no diffuse surface yet: the state from which it is continued.
struct EyeState {
    Ray ray;           // its next segment
    vec3 throughput;
    float medium_eta;  // refractive index of the medium that the path is in, over the camera's
    float travelled;   // length of the path so far, render units
    RoughVertex rough; // the vertex that the ray leaves, if that was rough
    uint depth;        // segments so far
    vec3 radiance;     // emission met so far, W/(m^2 sr)
};

// The result of an eye path. Members about its end are undefined where `reached` is 0.
struct EyePath {
    vec3 radiance;     // emission that it has met, W/(m^2 sr)
    Surface visible;   // diffuse surface at its end; the normal is on the side of the path
    vec3 facing;       // shading normal there, on the side of the path
    vec3 bsdf;         // throughput times the diffuse BSDF there, 1/sr
    Material material; // of that surface
    float reached;     // length of the path to there, render units; 0 if it met no diffuse surface
    bool is_lost;      // left the scene from within a dielectric
    bool is_immersed;  // ended on a diffuse surface inside a dielectric
};

EyeState begin_eye_path(Ray ray) {
    return EyeState(ray, vec3(1.0), 1.0, 0.0, no_rough_vertex(), 0u, vec3(0.0));
}

// Irradiance at a visible point from one light, chosen by power, over the pdf of that choice; W/m^2.
vec3 sample_direct_irradiance(Surface surface, Material material, vec3 n, Random random) {
    if (HAS_LOCATABLE_LIGHTS) {
        LightSample direct = sample_direct(surface.position, random_pair(random, PAIR_LIGHT).x,
                                           random_pair(random, PAIR_LIGHT_POINT));
        float cos_surface = max(dot(direct.wi, n), 0.0);
        float weight = direct.uses_mis ? mis_weight(direct.pdf, cos_surface / PI) : 1.0;
        bool passes = HAS_DIFFUSE_TRANSMISSION && (material.flags & BEHIND) != 0u;
        bool blocked = occluded(shadow_ray(surface, direct.wi, direct.target, passes));
        weight *= transmittance_to_base(material, cos_surface);
        return direct.pdf > 0.0 && !blocked ? direct.radiance * (cos_surface * weight / direct.pdf) : vec3(0.0);
    }
    return vec3(0.0);
}

// MIS weight of an area light that a BSDF sample of a diffuse surface has met. It is 0 for lights that
// next-event estimation alone samples.
float diffuse_mis_weight(Light light, vec3 from, vec3 n, Surface surface, vec3 wi) {
    float pdf = direct_pdf(light, from, surface, wi);
    return uses_mis(light, from) ? mis_weight(dot(wi, n) / PI, pdf) : 0.0;
}

bool is_finite(vec3 v) {
    return all(lessThan(abs(v), vec3(INFINITY_T)));
}

// Whether a diffuse surface samples its BSDF for lights, besides next-event estimation.
bool samples_bsdf_for_lights(vec3 from) {
    if (DIRECT_NEE) {
        return HAS_INFINITE_LIGHTS || may_use_mis(from);
    }
    return false;
}

// Adds the radiance from infinitely far away to a path whose ray leaves the scene.
void meet_infinity(inout EyePath path, inout EyeState state) {
    vec3 w = state.ray.direction;
    float pdf = path.reached > 0.0 ? max(dot(w, path.facing), 0.0) / PI : escape_pdf(state.rough);
    state.radiance += state.throughput * radiance_from_infinity(w, pdf);
    path.is_lost = path.reached == 0.0 && is_in_glass(state.medium_eta);
}

// Adds the emission of a surface that a path has met.
void meet_emitter(EyePath path, inout EyeState state, Surface surface) {
    vec3 w = state.ray.direction;
    Light light = lights_at(surface.light);
    float weight = emission_mis_weight(state.rough, light, surface, w);
    if (path.reached > 0.0) {
        weight = diffuse_mis_weight(light, path.visible.position, path.facing, surface, w);
    }
    state.radiance += state.throughput * emitted_radiance(light, surface, -w) * weight;
}

// Ends a path on a diffuse surface, its visible point.
void reach_diffuse(inout EyePath path, EyeState state, Surface surface, Material material) {
    vec3 wo = -state.ray.direction;
    path.is_immersed = is_in_glass(state.medium_eta);
    // The geometric normal decides the side: by the shading normal, the eye could see through.
    bool front = dot(wo, surface.normal) >= 0.0;
    if (HAS_DIFFUSE_TRANSMISSION) {
        front = front != ((material.flags & BEHIND) != 0u);
    }
    path.facing = front ? surface.shading_normal : -surface.shading_normal;
    surface.normal = front ? surface.normal : -surface.normal;
    path.bsdf = state.throughput * material.color / PI;
    path.visible = surface;
    path.material = material;
    path.reached = max(state.travelled, SHORTEST_PATH);
}

// Follows a path to the first diffuse surface. From there one sample of the BSDF looks for lights:
// the better technique for large lights, and the only one for constant infinite lights, which a
// cosine lobe samples perfectly (Veach 1997, chapter 9).
//
// Where the kernel is resumable, `start` becomes the state before the last segment that the driver
// did not end early.
EyePath trace_eye_path(inout EyeState start, Random random) {
    EyePath path;
    path.reached = 0.0;
    path.is_lost = false;
    path.is_immersed = false;
    EyeState state = start;
    for (; state.depth < scene.max_depth || path.reached > 0.0; state.depth++) {
        if (IS_RESUMABLE) {
            if (interrupted()) {
                break;
            }
            if (path.reached == 0.0) {
                start = state;
            }
        }
        Hit hit = intersect(state.ray);
        if (hit.primitive == NONE) {
            meet_infinity(path, state);
            break;
        }
        state.travelled += hit.t;
        Surface surface = surface_at(state.ray, hit);
        Material material = material_at(surface);
        vec3 wo = -state.ray.direction;
        if (HAS_AREA_LIGHTS && surface.light != NONE) {
            meet_emitter(path, state, surface);
        }
        if (path.reached > 0.0) {
            break;
        }
        Scatter scattered = Scatter(wo, vec3(0.0), 1.0);
        uint pair = pair_of_bounce(state.depth);
        float u_lobe = random_pair(random, pair).x;
        if (HAS_LAYERS) {
            material = choose_lobe(material, abs(dot(wo, surface.shading_normal)), u_lobe);
        }
        state.rough = no_rough_vertex();
        if (is_specular(material)) {
            vec2 u_facet = is_rough(material) ? random_pair(random, pair + 1u) : vec2(0.0);
            scattered = scatter_specular(material, wo, surface.shading_normal, surface.tangent, u_lobe, u_facet, RADIANCE);
            state.radiance += state.throughput * direct_light_on_rough(surface, material, wo, random, pair + 2u);
            state.rough = rough_vertex(surface, material, wo, scattered.wi);
        } else {
            reach_diffuse(path, state, surface, material);
            surface = path.visible;
            if (!samples_bsdf_for_lights(surface.position)) {
                break;
            }
            scattered.wi = sample_cosine(random_pair(random, PAIR_BSDF), path.facing);
            scattered.weight = material.color * transmittance_to_base(material, dot(scattered.wi, path.facing));
        }
        state.throughput *= scattered.weight;
        if (HAS_ROUGH) {
            if (state.throughput == vec3(0.0)) {
                break; // the microfacet sends the path into the surface
            }
        }
        state.medium_eta *= scattered.eta;
        state.ray = spawn_ray(surface, scattered.wi, crosses_surface(surface, wo, scattered.wi));
    }
    path.radiance = state.radiance;
    return path;
}

// Traces one path of a pixel, with the pixel filter's weight and next-event estimation at its end.
EyePath sample_eye_path(inout EyeState start, float filter_weight, Random random) {
    EyePath path = trace_eye_path(start, random);
    if (HAS_SIGNED_FILTER) {
        path.radiance *= filter_weight;
        path.bsdf *= filter_weight;
    }
    if (DIRECT_NEE && path.reached > 0.0) {
        path.radiance += path.bsdf * sample_direct_irradiance(path.visible, path.material, path.facing, random);
    }
    return path;
}

// Counts what a path has met. A radiance that is not finite becomes 0, and is counted.
void count_eye_path(inout EyePath path) {
    if (!is_finite(path.radiance)) {
        path.radiance = vec3(0.0);
        atomicAdd(counters.value.non_finite, 1u);
    }
    if (path.is_lost) {
        atomicAdd(counters.value.eye_lost_in_glass, 1u);
    }
    if (path.is_immersed) {
        atomicAdd(counters.value.immersed, 1u);
    }
}

// Stores the pixel's mean radiance, and where its last path ended.
void store_pixel(uint pixel, vec3 sum, EyePath last) {
    store_visible_radiances(pixel, vec4(sum / float(paths), 0.0));
    store_visible_throughputs(pixel, last.reached > 0.0 ? vec4(last.bsdf, last.reached) : vec4(0.0));
    if (last.reached > 0.0) {
        store_visible_points(pixel, VisiblePoint(last.visible.position, pack_normal(last.visible.normal)));
    }
}

// How far an invocation has come with its pixel's paths.
struct Progress {
    vec3 sum;     // radiance of the finished paths
    uint done;    // number of finished paths
    EyePath last; // the last path traced
    EyePlace place; // state of the path to be continued; depth 0 if the next path is to begin
    bool advanced;  // this dispatch has finished a segment
};

EyeState state_of(EyePlace place) {
    Ray ray = saved_ray(place.origin, place.direction, place.begin, place.contacts);
    RoughVertex rough = RoughVertex(place.last_position, place.last_pdf);
    return EyeState(ray, place.throughput, place.medium_eta, place.travelled, rough, place.depth, place.radiance);
}

EyePlace place_of(EyeState state) {
    return EyePlace(state.ray.origin, state.medium_eta, state.ray.direction, state.travelled, state.throughput, state.depth,
                    state.radiance, 0u, state.rough.position, state.rough.pdf, FINISHED, begin_of(state.ray), contacts_of(state.ray), 0u);
}

// Leaves out a path that the driver cannot follow even where the invocation is alone.
void cut_path(inout Progress progress) {
    progress.last.reached = 0.0;
    progress.place.depth = 0u;
    progress.done++;
    progress.advanced = true;
    atomicAdd(counters.value.cut, 1u);
}

// Stores the place from which the next dispatch goes on.
void store_place(uint number, Progress progress) {
    EyePlace place = progress.place;
    place.path = progress.done;
    place.state = progress.done == paths ? FINISHED : progress.advanced ? UNFINISHED : STUCK;
    places.data[number] = place;
    atomicAdd(counters.value.unfinished, place.state == UNFINISHED ? 1u : 0u);
    atomicAdd(counters.value.stuck, place.state == STUCK ? 1u : 0u);
}

// Traces the paths of a pixel that are not done yet.
void trace_paths(uint pixel, inout Progress progress) {
    uint seed = hash(seed_of_half(scene.seed, half_of_rounds), pixel);
    uint first_depth = progress.place.depth;
    [[dont_unroll]] for (uint i = progress.done; i < paths; i++) {
        Random random = Random(seed, turn * paths + i);
        CameraSample camera_sample = sample_camera(pixel, random);
        EyeState start = begin_eye_path(camera_sample.ray);
        if (IS_RESUMABLE && progress.place.depth > 0u) {
            start = state_of(progress.place);
        }
        progress.last = sample_eye_path(start, camera_sample.weight, random);
        if (IS_RESUMABLE) {
            progress.place = place_of(start);
            if (interrupted()) {
                break; // the driver ended the last segment early: it does not count
            }
            progress.advanced = true;
            progress.place.depth = 0u;
        }
        count_eye_path(progress.last);
        progress.sum += progress.last.radiance;
        progress.done = i + 1u;
    }
    if (IS_RESUMABLE) {
        progress.advanced = progress.advanced || progress.place.depth != first_depth;
    }
}

void main() {
    uint number = invocation_index();
    if (IS_RESUMABLE) {
        if (number % spread != 0u) {
            return; // so that another invocation has the rounds of loops to itself
        }
        number /= spread;
    }
    uint pixel = pixel_of(offset + number, camera_at(0u).width, camera_at(0u).height);
    if (pixel == NONE) {
        return;
    }
    Progress progress;
    progress.sum = vec3(0.0);
    progress.done = 0u;
    progress.last.reached = 0.0;
    if (IS_RESUMABLE) {
        progress.place = place_of(begin_eye_path(free_ray(vec3(0.0), vec3(0.0))));
        progress.advanced = false;
    }
    if (IS_RESUMABLE && resumed != 0u) {
        progress.place = places.data[number];
        if (progress.place.state != (spread > 1u ? STUCK : UNFINISHED)) {
            return;
        }
        progress.sum = visible_radiances_at(pixel).rgb;
        progress.done = progress.place.path;
    }
    trace_paths(pixel, progress);
    if (IS_RESUMABLE) {
        if (!progress.advanced && spread > 1u) {
            cut_path(progress);
        }
        store_place(number, progress);
        if (progress.done < paths) {
            store_visible_radiances(pixel, vec4(progress.sum, 0.0));
            return;
        }
    }
    store_pixel(pixel, progress.sum, progress.last);
    if (IS_RESUMABLE) {
        return;
    }
    if (interrupted()) {
        atomicAdd(counters.value.interrupted, 1u);
    }
}
