// eye: follow camera paths of each pixel to the first diffuse surface, the last one's visible
// point.
// One invocation per pixel. Writes visible_*; visible_radiances holds the mean of all paths'
// emission and direct light, which are noisier than what photons bring, and cheaper.
// Hachisuka and Jensen 2009, section 3.
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

// Where an invocation of the eye pass has got to: a path that has met no diffuse surface yet.
struct EyePlace {
    vec3 origin; // of the path's next ray, render units
    float index; // of the medium, over the camera's
    vec3 direction;  // of that ray
    float travelled; // length so far
    vec3 throughput; // of the path so far
    uint depth;      // segments of the path so far
    vec3 radiance; // emission met so far, W/(m^2 sr)
    uint path;       // of the pixel: its number
    vec3 last_position; // rough_path.glsl
    float last_pdf;  // rough_path.glsl
    uint state;    // FINISHED, UNFINISHED or STUCK
    float begin;     // of the ray: contact.glsl
    uint contacts;   // of the ray: contact.glsl
    uint pad0;
};

TEXELS(Camera, camera)
TEXELS(float, filter_table)
STORED_TEXELS(VisiblePoint, visible_points)
STORED_TEXELS(vec4, visible_throughputs) // bsdf times throughput; w: length of the path, 0 if there is no point
UPDATED_TEXELS(vec4, visible_radiances) // W/(m^2 sr)
UPDATED_BUFFER(EyePlace, places) // of invocations that go on

layout(push_constant) uniform Push {
    uint turn;           // of the rounds of its half
    uint half_of_rounds; // 0 or 1
    uint paths;          // of a pixel
    uint offset;  // of this dispatch's invocations
    uint resumed; // 1 to go on from places: interruption.glsl
    uint spread; // of this number of invocations one works: interruption.glsl
    uint two; // 2: interruption.glsl
};

// Pairs of random numbers of an eye path. Scattering takes one per bounce from PAIR_LOBE; where
// surfaces may be rough, one more for the facet and two for a light.
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

// A length that is not 0, however near the camera a surface is.
const float SHORTEST_PATH = 1.0e-12;

// Offset from the pixel's centre in pixels, for axis 0 (x) or 1 (y): the inverse distribution
// of the pixel filter's magnitude, a table of the cells' edges for each.
float filter_offset(uint axis, float u) {
    float scaled = u * float(FILTER_CELLS);
    uint i = min(uint(scaled), FILTER_CELLS - 1u);
    uint entry = (FILTER_CELLS + 1u) * axis + i;
    return mix(filter_table_at(entry), filter_table_at(entry + 1u), scaled - float(i));
}

// What a sample there counts; the mean over all is 1. The tables follow those of offsets.
float filter_weight(uint axis, float u) {
    uint i = min(uint(u * float(FILTER_CELLS)), FILTER_CELLS - 1u);
    return filter_table_at((FILTER_CELLS + 1u) * (axis + 2u) + i);
}

struct CameraSample {
    Ray ray;
    float weight;
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

// Irradiance at a diffuse point that comes straight from a light chosen by power, W/m^2.
vec3 irradiance_of_light(Surface surface, Material material, vec3 n, Random random) {
    if (HAS_LOCATABLE_LIGHTS) {
        LightSample direct = sample_direct(surface.position, random_pair(random, PAIR_LIGHT).x,
                                           random_pair(random, PAIR_LIGHT_POINT));
        float cos_surface = max(dot(direct.wi, n), 0.0);
        float weight = direct.competes ? mis_weight(direct.pdf, cos_surface / PI) : 1.0;
        bool passes = HAS_DIFFUSE_TRANSMISSION && (material.flags & BEHIND) != 0u;
        bool blocked = occluded(shadow_ray(surface, direct.wi, direct.target, passes));
        weight *= entering(material, cos_surface);
        return direct.pdf > 0.0 && !blocked ? direct.radiance * (cos_surface * weight / direct.pdf) : vec3(0.0);
    }
    return vec3(0.0);
}

// What of a light's radiance is found by a direction of the bsdf at a diffuse point: all of
// it that next-event estimation leaves.
float bsdf_weight(Light light, vec3 from, vec3 n, Surface surface, vec3 wi) {
    float pdf = direct_pdf(light, from, surface, wi);
    return competes(light, from) ? mis_weight(dot(wi, n) / PI, pdf) : 0.0;
}

bool is_finite(vec3 v) {
    return all(lessThan(abs(v), vec3(INFINITY_T)));
}

// Whether a direction of the bsdf may find a light that next-event estimation leaves to it.
bool looks_for_lights(vec3 from) {
    if (DIRECT_NEE) {
        return HAS_INFINITE_LIGHTS || is_near_lights(from);
    }
    return false;
}

// What an eye path has come to.
struct EyePath {
    vec3 radiance;   // emission that it has met, W/(m^2 sr)
    Surface visible; // its end, if it is diffuse; the normal is on the eye's side
    vec3 facing;     // its shading normal, on the eye's side
    vec3 bsdf;       // its bsdf times the throughput
    Material material; // of that end
    float reached;   // length to that end; 0 if there is none
    bool is_lost;     // it found no way out of a dielectric
    bool is_immersed; // its end is in a dielectric
};

// Where a path goes on that has met no diffuse surface yet.
struct EyeStart {
    Ray ray;
    vec3 throughput;
    float index;     // of the medium the path is in, over the camera's
    float travelled; // length so far
    Last last;
    uint depth;
    vec3 radiance;   // emission that it has met so far
};

// Follows a path to the first diffuse surface, and from there one direction of the bsdf to
// where it may meet a light: the better way to large lights, and the only one to infinite
// ones, which a cosine lobe samples perfectly (Veach 1997, chapter 9).
//
// Where it is resumable, `start` is left at the last segment that was not ended early.
EyePath follow(inout EyeStart start, Random random) {
    EyePath path;
    path.radiance = start.radiance;
    path.reached = 0.0;
    path.is_lost = false;
    path.is_immersed = false;
    Ray ray = start.ray;
    vec3 throughput = start.throughput;
    float index = start.index;
    float travelled = start.travelled;
    Last last = start.last;
    for (uint depth = start.depth; depth < scene.max_depth || path.reached > 0.0; depth++) {
        if (IS_RESUMABLE) {
            if (interrupted(two)) {
                break;
            }
            if (path.reached == 0.0) {
                start = EyeStart(ray, throughput, index, travelled, last, depth, path.radiance);
            }
        }
        Hit hit = intersect(ray);
        if (hit.primitive == NONE) {
            float pdf = path.reached > 0.0 ? max(dot(ray.direction, path.facing), 0.0) / PI : pdf_after(last);
            path.radiance += throughput * radiance_from_infinity(ray.direction, pdf);
            path.is_lost = path.reached == 0.0 && is_in_glass(index);
            break;
        }
        travelled += hit.t;
        Surface surface = surface_at(ray, hit);
        Material material = material_at(surface);
        vec3 wo = -ray.direction;
        if (HAS_AREA_LIGHTS && surface.light != NONE) {
            Light light = lights_at(surface.light);
            float weight = weight_after(last, light, surface, ray.direction);
            if (path.reached > 0.0) {
                weight = bsdf_weight(light, path.visible.position, path.facing, surface, ray.direction);
            }
            path.radiance += throughput * emitted_radiance(light, surface, wo) * weight;
        }
        if (path.reached > 0.0) {
            break;
        }
        Scatter scattered = Scatter(wo, vec3(0.0), 1.0);
        uint pair = pair_of_bounce(depth);
        float u_lobe = random_pair(random, pair).x;
        if (HAS_LAYERS) {
            material = choose_lobe(material, abs(dot(wo, surface.shading_normal)), u_lobe);
        }
        last = not_rough();
        if (is_specular(material)) {
            vec2 u_facet = is_rough(material) ? random_pair(random, pair + 1u) : vec2(0.0);
            scattered = scatter_specular(material, wo, surface.shading_normal, surface.tangent, u_lobe, u_facet, RADIANCE);
            path.radiance += throughput * light_on_rough(surface, material, wo, random, pair + 2u);
            last = after(surface, material, wo, scattered.wi);
        } else {
            path.is_immersed = is_in_glass(index);
            // The side of the geometric normal: shading normals must not see through.
            bool front = dot(wo, surface.normal) >= 0.0;
            if (HAS_DIFFUSE_TRANSMISSION) {
                front = front != ((material.flags & BEHIND) != 0u);
            }
            path.facing = front ? surface.shading_normal : -surface.shading_normal;
            surface.normal = front ? surface.normal : -surface.normal;
            path.bsdf = throughput * material.color / PI;
            path.visible = surface;
            path.material = material;
            path.reached = max(travelled, SHORTEST_PATH);
            if (!looks_for_lights(surface.position)) {
                break;
            }
            scattered.wi = sample_cosine(random_pair(random, PAIR_BSDF), path.facing);
            scattered.weight = material.color * entering(material, dot(scattered.wi, path.facing));
        }
        throughput *= scattered.weight;
        if (HAS_ROUGH) {
            if (throughput == vec3(0.0)) {
                break; // a facet would send it into the surface
            }
        }
        index *= scattered.eta;
        ray = leave(surface, scattered.wi, goes_through(surface, wo, scattered.wi));
    }
    return path;
}

EyeStart start_of(EyePlace place) {
    Ray ray = saved_ray(place.origin, place.direction, place.begin, place.contacts);
    return EyeStart(ray, place.throughput, place.index, place.travelled, Last(place.last_position, place.last_pdf), place.depth, place.radiance);
}

EyePlace place_of(EyeStart start) {
    return EyePlace(start.ray.origin, start.index, start.ray.direction, start.travelled, start.throughput, start.depth,
                    start.radiance, 0u, start.last.position, start.last.pdf, FINISHED, begin_of(start.ray), contacts_of(start.ray), 0u);
}

// Leaves a place to go on from, with so many paths of the pixel done.
void store_place(uint number, EyePlace place, uint done, bool advanced) {
    place.path = done;
    place.state = done == paths ? FINISHED : advanced ? UNFINISHED : STUCK;
    places.data[number] = place;
    atomicAdd(counters.value.unfinished, place.state == UNFINISHED ? 1u : 0u);
    atomicAdd(counters.value.stuck, place.state == STUCK ? 1u : 0u);
}

EyeStart begin(Ray ray) {
    return EyeStart(ray, vec3(1.0), 1.0, 0.0, not_rough(), 0u, vec3(0.0));
}

void main() {
    uint number = invocation_index();
    if (IS_RESUMABLE) {
        if (number % spread != 0u) {
            return; // another invocation of the workgroup is to be alone
        }
        number /= spread;
    }
    uint pixel = pixel_of(offset + number, camera_at(0u).width, camera_at(0u).height);
    if (pixel == NONE) {
        return;
    }
    uint seed = hash(seed_of_half(scene.seed, half_of_rounds), pixel);
    vec3 sum = vec3(0.0); // of the paths so far
    uint done = 0u;
    EyePath path;
    path.reached = 0.0;
    bool advanced = false;
    EyePlace place;
    if (IS_RESUMABLE) {
        place = place_of(begin(free_ray(vec3(0.0), vec3(0.0))));
    }
    if (IS_RESUMABLE && resumed != 0u) {
        place = places.data[number];
        if (place.state != (spread > 1u ? STUCK : UNFINISHED)) {
            return;
        }
        sum = visible_radiances_at(pixel).rgb;
        done = place.path;
    }
    uint begun = place.depth;
    [[dont_unroll]] for (uint i = done; i < paths; i++) {
        Random random = Random(seed, turn * paths + i);
        CameraSample camera_sample = sample_camera(pixel, random);
        EyeStart start = begin(camera_sample.ray);
        if (IS_RESUMABLE && place.depth > 0u) {
            start = start_of(place);
        }
        path = follow(start, random);
        if (HAS_SIGNED_FILTER) {
            path.radiance *= camera_sample.weight;
            path.bsdf *= camera_sample.weight;
        }
        if (DIRECT_NEE && path.reached > 0.0) {
            path.radiance += path.bsdf * irradiance_of_light(path.visible, path.material, path.facing, random);
        }
        if (IS_RESUMABLE) {
            place = place_of(start);
            if (interrupted(two)) {
                break; // the last segment does not count
            }
            advanced = true;
            place.depth = 0u;
        }
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
        sum += path.radiance;
        done = i + 1u;
    }
    if (IS_RESUMABLE) {
        advanced = advanced || place.depth != begun;
        if (!advanced && spread > 1u) {
            // Even alone: what the path would bring is left out.
            path.reached = 0.0;
            place.depth = 0u;
            done++;
            atomicAdd(counters.value.cut, 1u);
            advanced = true;
        }
        store_place(number, place, done, advanced);
        if (done < paths) {
            store_visible_radiances(pixel, vec4(sum, 0.0));
            return;
        }
    }
    store_visible_radiances(pixel, vec4(sum / float(paths), 0.0));
    store_visible_throughputs(pixel, path.reached > 0.0 ? vec4(path.bsdf, path.reached) : vec4(0.0));
    if (path.reached > 0.0) {
        store_visible_points(pixel, VisiblePoint(path.visible.position, pack_normal(path.visible.normal)));
    }
    if (IS_RESUMABLE) {
        return;
    }
    if (interrupted(two)) {
        atomicAdd(counters.value.interrupted, 1u);
    }
}
