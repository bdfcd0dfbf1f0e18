// What an invocation of the eye pass keeps of its pixel while it follows paths. Lanes of a GPU have few registers, which
// the search for hits needs: there it is in memory as soon as it is known (FEW_REGISTERS). A CPU's driver runs what is
// in a loop in every round, for lanes that need it and for others: there it is stored once, at the end.
#include "geometry/normal.glsl"
#include "lookup/records.glsl"
#include "math/random.glsl"
#include "scene/features.glsl"
#include "scene/scene.glsl"

STORED_TEXELS(VisiblePoint, visible_points)
STORED_TEXELS(vec4, visible_throughputs) // BSDF times throughput; w: length of the path, 0 if there is no point
UPDATED_TEXELS(vec4, visible_radiances) // W/(m^2 sr)

// What is not in memory; unused with FEW_REGISTERS.
struct Kept {
    uint seed;       // of the pixel's random numbers
    vec3 sum;        // radiance of the finished paths
    vec3 position;   // where the path has met a diffuse surface, render units
    vec3 normal;     // of that surface
    vec4 throughput; // as visible_throughputs has it
};

Kept begin_pixel(uint seed) {
    return Kept(seed, vec3(0.0), vec3(0.0), vec3(0.0), vec4(0.0));
}

// Keeps where a path has met a diffuse surface. A path of the pixel that ends later meets another one, or none.
void keep_point(inout Kept kept, uint pixel, vec3 position, vec3 normal, vec4 throughput) {
    if (FEW_REGISTERS) {
        store_visible_points(pixel, VisiblePoint(position, pack_normal(normal)));
        store_visible_throughputs(pixel, throughput);
        return;
    }
    kept.position = position;
    kept.normal = normal;
    kept.throughput = throughput;
}

// Adds the radiance of a path that has ended to the sum of the pixel's `done` finished paths.
void add_path(inout Kept kept, uint pixel, uint done, vec3 radiance) {
    if (FEW_REGISTERS) {
        vec3 sum = done > 0u ? visible_radiances_at(pixel).rgb : vec3(0.0);
        store_visible_radiances(pixel, vec4(sum + radiance, 0.0));
        return;
    }
    kept.sum += radiance;
}

// Stores what another dispatch goes on with, and takes it up there.
void store_kept(Kept kept, uint pixel) {
    if (FEW_REGISTERS) {
        return; // it is in memory
    }
    store_visible_radiances(pixel, vec4(kept.sum, 0.0));
}

void load_kept(inout Kept kept, uint pixel) {
    if (FEW_REGISTERS) {
        return;
    }
    kept.sum = visible_radiances_at(pixel).rgb;
}

// Stores the mean of the pixel's paths, and its visible point if the last path has one.
void finish_pixel(Kept kept, uint pixel, uint paths, bool has_point) {
    if (FEW_REGISTERS) {
        store_visible_radiances(pixel, vec4(visible_radiances_at(pixel).rgb / float(paths), 0.0));
        if (!has_point) {
            store_visible_throughputs(pixel, vec4(0.0));
        }
        return;
    }
    store_visible_radiances(pixel, vec4(kept.sum / float(paths), 0.0));
    store_visible_throughputs(pixel, has_point ? kept.throughput : vec4(0.0));
    if (has_point) {
        store_visible_points(pixel, VisiblePoint(kept.position, pack_normal(kept.normal)));
    }
}
