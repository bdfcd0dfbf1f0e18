// surface_layers: what the eye paths of a pixel meet first, for the layers of an image.
//
// Invocations: one per pixel, in tiles of 8 x 8. Each traces the first segment of one path of the pixel, the
//   same as the eye pass; a dispatch for each path adds to the one before.
// Reads: the scene (set 0), camera, filter_table; places where it resumes.
// Writes: layer_values (mean over the paths, times the pixel filter; after the last path), counters (atomic),
//   places where IS_RESUMABLE.
// Units: lengths in render units.
#version 460
#include "camera/sample.glsl"
#include "geometry/contact.glsl"
#include "geometry/hit.glsl"
#include "geometry/query.glsl"
#include "geometry/surface.glsl"
#include "geometry/surface_point.glsl"
#include "kernel/counters.glsl"
#include "kernel/interruption.glsl"
#include "kernel/invocation.glsl"
#include "kernel/tile.glsl"
#include "material/albedo.glsl"
#include "material/bump.glsl"
#include "material/material.glsl"
#include "math/random.glsl"
#include "scene/constants.glsl"
#include "scene/features.glsl"
#include "scene/materials.glsl"
#include "scene/scene.glsl"

// What there is for each group of sums (src/image/layers.rs), one group after the other.
UPDATED_TEXELS(vec4, layer_values)
UPDATED_BUFFER(uint, places) // of invocations that go on: FINISHED, UNFINISHED or STUCK

layout(push_constant) uniform Push {
    vec3 slope_axis;     // unit vector of the coordinate whose slopes are asked for
    uint turn;           // number of the round among those of its half
    uint half_of_rounds; // 0 or 1
    uint path;           // number of the path among those of its pixel
    uint paths;          // paths per pixel
    uint pixel_count;    // number of pixels: of values of a group
    uint albedo_group;   // numbers of groups, or NONE
    uint position_group; // ..
    uint normal_group;   // ..
    uint shading_group;  // ..
    uint slope_group;    // ..
    uint offset;         // first invocation of this dispatch
    uint resumed;        // 1 to go on from `places`; see interruption.glsl
    uint spread;         // one of `spread` invocations works; see interruption.glsl
};

// The path of an invocation's pixel.
struct Work {
    uint pixel;
    CameraSample seen;
    bool waits;    // for the hit
    bool finished;
};

#include "geometry/trace.glsl"

// The random numbers of the path: those of the eye pass.
Random random_of(uint pixel) {
    return Random(hash(seed_of_half(scene.seed, half_of_rounds), pixel), turn * paths + path);
}

// Adds the path to the values of a group, and makes their mean of the sum after the last path.
void add_value(uint group, uint pixel, vec4 value) {
    if (group == NONE) {
        return;
    }
    uint at = group * pixel_count + pixel;
    vec4 sum = path > 0u ? layer_values_at(at) + value : value;
    store_layer_values(at, path + 1u == paths ? sum / float(paths) : sum);
}

// How far the point at distance t along a ray moves in its tangent plane for a sample beside it.
vec3 moved_point(Ray ray, float t, vec3 n, Ray beside) {
    vec3 apart = (beside.origin - ray.origin) + t * (beside.direction - ray.direction);
    float cosine = dot(n, beside.direction);
    return cosine != 0.0 ? apart - beside.direction * (dot(n, apart) / cosine) : vec3(0.0);
}

// The change of the point along slope_axis to the pixels to the right and below.
vec2 slopes(Work work, float t, vec3 n) {
    Random random = random_of(work.pixel);
    Ray right = sample_camera_beside(work.pixel, random, vec2(1.0, 0.0)).ray;
    Ray below = sample_camera_beside(work.pixel, random, vec2(0.0, 1.0)).ray;
    return vec2(dot(slope_axis, moved_point(work.seen.ray, t, n, right)),
                dot(slope_axis, moved_point(work.seen.ray, t, n, below)));
}

void add_surface(Work work, Hit hit) {
    Surface surface = surface_at(work.seen.ray, hit);
    Material material = material_at(surface);
    apply_bumps(surface, material);
    vec3 wo = -work.seen.ray.direction;
    float weight = work.seen.weight;
    vec3 albedo = albedo_of(material, dot(wo, surface.shading_normal));
    vec3 n = dot(wo, surface.normal) < 0.0 ? -surface.normal : surface.normal;
    vec3 ns = dot(wo, surface.shading_normal) < 0.0 ? -surface.shading_normal : surface.shading_normal;
    vec2 uv = vec2(0.0);
    if (HAS_TEXTURES) {
        uv = surface.uv;
    }
    add_value(albedo_group, work.pixel, weight * vec4(albedo, 1.0));
    add_value(position_group, work.pixel, weight * vec4(surface.position, 0.0));
    add_value(normal_group, work.pixel, weight * vec4(n, 0.0));
    add_value(shading_group, work.pixel, weight * vec4(ns, 0.0));
    if (slope_group != NONE) {
        add_value(slope_group, work.pixel, weight * vec4(slopes(work, hit.t, surface.normal), uv));
    }
}

// Adds a path that has met nothing.
void add_nothing(uint pixel) {
    add_value(albedo_group, pixel, vec4(0.0));
    add_value(position_group, pixel, vec4(0.0));
    add_value(normal_group, pixel, vec4(0.0));
    add_value(shading_group, pixel, vec4(0.0));
    add_value(slope_group, pixel, vec4(0.0));
}

bool next_query(inout Work work, inout Query query, Hit hit) {
    if (IS_RESUMABLE) {
        if (interrupted()) {
            return true; // the driver ended this segment early: it does not count
        }
    }
    if (!work.waits) {
        query = nearest_hit(work.seen.ray);
        work.waits = true;
        return true;
    }
    if (hit.primitive == NONE) {
        add_nothing(work.pixel);
    } else {
        add_surface(work, hit);
    }
    work.finished = true;
    query = no_query();
    return false;
}

// Whether an invocation has something to do in a dispatch that goes on.
bool resume(uint number) {
    return places.data[number] == (spread > 1u ? STUCK : UNFINISHED);
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
    work.waits = false;
    work.finished = false;
    bool has_pixel = works && work.pixel != NONE;
    if (IS_RESUMABLE) {
        if (has_pixel && resumed != 0u) {
            has_pixel = resume(number);
        }
    }
    if (has_pixel) {
        work.seen = sample_camera(work.pixel, random_of(work.pixel));
    }
    trace_queries(work, has_pixel);
    if (IS_RESUMABLE) {
        if (has_pixel && !work.finished && spread > 1u) {
            add_nothing(work.pixel); // a path that the driver cannot follow even where the invocation is alone
            atomicAdd(counters.value.cut, 1u);
            work.finished = true;
        }
        if (has_pixel) {
            places.data[number] = work.finished ? FINISHED : STUCK;
            atomicAdd(counters.value.stuck, work.finished ? 0u : 1u);
        } else if (works && resumed == 0u) {
            places.data[number] = FINISHED; // outside of the image
        }
        return;
    }
    if (interrupted()) {
        atomicAdd(counters.value.interrupted, 1u);
    }
}
