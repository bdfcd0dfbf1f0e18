// accumulate_grid: add each photon's weight to the visible points whose disc it is inside,
// found by the hash grid.
// Each invocation takes every stride-th recorded photon; one that has met many points
// leaves its place in `places` and counts as unfinished, so that no dispatch is long. Reads
// photon_*, cells, grid_*. Updates flux_low, flux_high (atomic, fixed point, w of flux_low
// counts photons), places.
// Hachisuka and Jensen 2009, eq. 5.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "invocation.glsl"
#include "types.glsl"
#include "grid.glsl"
#include "flux.glsl"
#include "normal.glsl"
#include "interruption.glsl"

layout(std430, set = 1, binding = 0) readonly buffer PhotonPositionBlock { vec4 data[]; } photon_positions;
layout(std430, set = 1, binding = 1) readonly buffer PhotonWeightBlock { vec4 data[]; } photon_weights;
layout(std430, set = 1, binding = 2) readonly buffer GridInfoBlock { GridInfo value; } grid_info;
layout(std430, set = 1, binding = 3) readonly buffer CellBlock { Cell data[]; } cells;
layout(std430, set = 1, binding = 4) readonly buffer GridPositionBlock { vec4 data[]; } grid_positions;
layout(std430, set = 1, binding = 5) readonly buffer GridOwnerBlock { uvec2 data[]; } grid_owners;
layout(std430, set = 1, binding = 6) buffer FluxLowBlock { uint data[]; } flux_low; // r, g, b, count of each pixel
layout(std430, set = 1, binding = 7) buffer FluxHighBlock { uint data[]; } flux_high; // r, g, b, unused
layout(std430, set = 1, binding = 8) buffer CounterBlock { Counters value; } counters;

#include "deposit.glsl"

layout(std430, set = 1, binding = 9) buffer PlaceBlock { GridPlace data[]; } places; // of invocations that go on

layout(push_constant) uniform Push {
    uint recorded;
    uint stride;
    uint cell_mask;
    uint resumed; // 1 to go on from `places`
    uint two;     // 2, see interruption.glsl
};

// Rounds of an invocation in one dispatch. llvmpipe counts those of eight lanes together,
// which may all be busy in turn, and a round of the inner loop more for each of the outer
// one: 2 * 8 * 4000 stay below what it allows.
const uint MAX_ROUNDS = 4000u;

// The cells that may hold a point which reaches a photon: a box of them, one after the other.
struct Walk {
    ivec3 lower;
    ivec3 upper;
    ivec3 cell; // the last one taken
};

Walk walk_around(vec3 position, float radius, float inverse_size) {
    ivec3 lower = cell_of(position - radius, inverse_size);
    ivec3 upper = cell_of(position + radius, inverse_size);
    return Walk(lower, upper, ivec3(lower.x - 1, lower.yz));
}

// Goes on to the next cell; false if there is none.
bool next_cell(inout Walk walk) {
    walk.cell.x++;
    if (walk.cell.x > walk.upper.x) {
        walk.cell.x = walk.lower.x;
        walk.cell.y++;
    }
    if (walk.cell.y > walk.upper.y) {
        walk.cell.y = walk.lower.y;
        walk.cell.z++;
    }
    return walk.cell.z <= walk.upper.z;
}

void main() {
    uint invocation = invocation_index();
    if (invocation >= stride) {
        return; // its photons are another invocation's
    }
    // Wide enough that rounding leaves no cell out.
    float radius = 1.000001 * sqrt(uintBitsToFloat(grid_info.value.max_radius2));
    float inverse_size = 1.0 / cell_size(grid_info.value.max_radius2);
    GridPlace place = GridPlace(ivec3(0), invocation, 0u, 0u, 0u, 0u);
    bool resumes = resumed != 0u;
    if (resumes) {
        place = places.data[invocation];
    }
    uint left = MAX_ROUNDS;
    for (; place.photon < recorded && left > 0u; place.photon += left > 0u ? stride : 0u) {
        vec4 record = photon_positions.data[place.photon];
        vec3 photon_normal = unpack_normal(floatBitsToUint(record.w));
        vec3 weight = photon_weights.data[place.photon].xyz;
        uvec2 red = to_fixed(weight.x);
        uvec2 green = to_fixed(weight.y);
        uvec2 blue = to_fixed(weight.z);
        Walk walk = walk_around(record.xyz, radius, inverse_size);
        uint entry = 0u;
        uint last = 0u;
        if (resumes) {
            walk.cell = place.cell;
            entry = place.entry;
            last = place.last;
            resumes = false;
        }
        // Lanes run ahead to their next point in reach before any adds to it, so that few of
        // them are idle while one adds.
        while (left > 0u) {
            vec4 point;
            vec3 d;
            uint begin = entry;
            uint stop = min(last, entry + left);
            while (entry < stop) {
                point = grid_positions.data[entry];
                d = record.xyz - point.xyz;
                if (dot(d, d) < point.w) {
                    break;
                }
                entry++;
            }
            left -= entry - begin;
            if (left == 0u) {
                break;
            }
            left--;
            if (entry < last) {
                uvec2 owner = grid_owners.data[entry];
                // Cells that share a hash share entries: take those of this cell only.
                if (is_on_disc(d, photon_normal, unpack_normal(owner.x), point.w)
                    && cell_of(point.xyz, inverse_size) == walk.cell) {
                    deposit(owner.y, red, green, blue);
                }
                entry++;
            } else if (next_cell(walk)) {
                Cell range = cells.data[cell_hash(walk.cell, cell_mask)];
                entry = range.first;
                last = range.first + range.count;
            } else {
                break;
            }
        }
        place = GridPlace(walk.cell, place.photon, entry, last, 0u, 0u);
    }
    places.data[invocation] = place;
    if (place.photon < recorded) {
        atomicAdd(counters.value.unfinished, 1u);
    }
    if (interrupted(two)) {
        atomicAdd(counters.value.interrupted, 1u);
    }
}
