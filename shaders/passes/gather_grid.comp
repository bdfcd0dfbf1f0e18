// gather_grid: each visible point gathers the photons inside its disc, from the hash grid.
// One invocation per POINTS pixels; those of a subgroup have a compact block of the image and
// look at the same photons together: each loads one, and all test it. A subgroup that has met many photons
// leaves its place in `places` and counts as unfinished, so that no dispatch is long. Reads
// visible_*, cells, grid_photons. Updates flux_* (fixed point), places.
// Hachisuka and Jensen 2009, eq. 5.
#version 460
#include "geometry/normal.glsl"
#include "kernel/counters.glsl"
#include "kernel/interruption.glsl"
#include "kernel/invocation.glsl"
#include "kernel/tile.glsl"
#include "lookup/disc.glsl"
#include "lookup/flux.glsl"
#include "lookup/gather.glsl"
#include "lookup/grid.glsl"
#include "lookup/records.glsl"
#include "scene/constants.glsl"
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_shuffle : require

// Where an invocation of gather_grid has got to. Those of a subgroup differ in the first
// only.
struct GridPlace {
    uint served; // 1 if its point has met all photons
    uint cell;   // of the neighbourhood: the first of those that the lanes look up together
    uint lane;   // whose cell is next
    uint entry;  // of that cell
};

TEXELS(VisiblePoint, visible_points)
TEXELS(float, visible_radii2)
VALUE(uint, max_radius2)
BUFFER(Cell, cells)
TEXELS(PhotonRecord, grid_photons)
UPDATED_BUFFER(GridPlace, places) // of invocations that go on

layout(push_constant) uniform Push {
    uint width; // pixels in a row
    uint height; // rows
    uint cell_mask; // cells of the table, less 1
    uint resumed; // 1 to go on from `places`
    uint offset;  // of this dispatch's invocations
    uint two; // 2: interruption.glsl
};

// Rounds of loops in one dispatch: below the 65,535 that llvmpipe allows an invocation.
const uint MAX_ROUNDS = 60000u;

// Lanes that work together: a power of two, and no more than a word has bits.
uint lanes() {
    return min(min(gl_SubgroupSize, gl_WorkGroupSize.x), 32u);
}

// Of all lanes that work together, one bit each.
uint ballot(bool value) {
    uint shift = gl_SubgroupInvocationID & ~31u;
    return subgroupBallot(value)[shift >> 5u];
}

// Another lane's number in the subgroup, from that among those that work together.
uint peer(uint lane) {
    return (gl_SubgroupInvocationID & ~31u) + lane;
}

// As invocation_index, but neighbours in a subgroup have neighbouring numbers whatever order the
// device puts invocations into subgroups, so that a later dispatch goes on with the same peers.
uint numbered_by_subgroup() {
    uint workgroup = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    return workgroup * gl_WorkGroupSize.x + gl_SubgroupID * gl_SubgroupSize + gl_SubgroupInvocationID;
}

vec3 least_of_lanes(vec3 v) {
    for (uint step = 1u; step < lanes(); step *= 2u) {
        v = min(v, subgroupShuffle(v, gl_SubgroupInvocationID ^ step));
    }
    return v;
}

// Pixels of an invocation: each photon that it looks at serves all of them.
export const uint POINTS = 2u;
const uint ALL_SERVED = (1u << POINTS) - 1u;

struct Point {
    vec3 position;
    float radius2; // 0 if there is none
    vec3 normal;
    bool wants;    // to gather now
};

Point point_of(uint pixel) {
    if (pixel == NONE) {
        return Point(vec3(0.0), 0.0, vec3(0.0), false);
    }
    VisiblePoint point = visible_points_at(pixel);
    return Point(point.position, visible_radii2_at(pixel), unpack_normal(point.normal), false);
}

// Each lane has a photon, some of them wanted; each point takes those on its disc.
void gather_from(PhotonRecord photon, bool wanted, Point points[POINTS], inout Gathered sums[POINTS]) {
    vec3 normal = unpack_normal(photon.normal);
    uvec2 red = to_fixed(photon.weight.x);
    uvec2 green = to_fixed(photon.weight.y);
    uvec2 blue = to_fixed(photon.weight.z);
    for (uint left = ballot(wanted); left != 0u; left &= left - 1u) {
        uint lane = peer(findLSB(left));
        vec3 position = subgroupShuffle(photon.position, lane);
        vec3 facing = subgroupShuffle(normal, lane);
        uvec3 low = uvec3(subgroupShuffle(red.x, lane), subgroupShuffle(green.x, lane), subgroupShuffle(blue.x, lane));
        uvec3 high = uvec3(subgroupShuffle(red.y, lane), subgroupShuffle(green.y, lane), subgroupShuffle(blue.y, lane));
        [[unroll]] for (uint i = 0u; i < POINTS; i++) {
            vec3 d = position - points[i].position;
            bool hit = points[i].wants && dot(d, d) < points[i].radius2
                    && is_on_disc(d, facing, points[i].normal, points[i].radius2);
            gather(sums[i], low, high, hit);
        }
    }
}

void main() {
    uint lane = gl_SubgroupInvocationID & 31u;
    uint invocation = offset + numbered_by_subgroup();
    float inverse_size = 1.0 / cell_size(max_radius2.value);
    // Those that only fill the last workgroup have no place, and none of the pixels.
    bool has_place = POINTS * invocation < invocations_by_tile(width, height);
    GridPlace place = GridPlace(0u, 0u, 0u, 0u);
    if (resumed != 0u && has_place) {
        place = places.data[invocation];
    }
    Point points[POINTS];
    Gathered sums[POINTS];
    [[unroll]] for (uint i = 0u; i < POINTS; i++) {
        points[i] = point_of(pixel_of(POINTS * invocation + i, width, height));
        sums[i] = nothing_gathered();
        place.served |= points[i].radius2 > 0.0 ? 0u : 1u << i;
    }
    // A cell and the photons that are loaded at once take a round for each photon, and four.
    uint left = MAX_ROUNDS / (lanes() + 4u);
    // Points near the first one that waits are served together.
    for (uint waiting = ballot(place.served != ALL_SERVED); waiting != 0u && left > 0u;
         waiting = ballot(place.served != ALL_SERVED)) {
        vec3 waiter = points[POINTS - 1u].position;
        [[unroll]] for (uint i = POINTS - 1u; i > 0u; i--) {
            waiter = (place.served >> (i - 1u) & 1u) == 0u ? points[i - 1u].position : waiter;
        }
        ivec3 home = subgroupShuffle(cell_of(waiter, inverse_size), peer(findLSB(waiting)));
        vec3 lower = vec3(INFINITY_T);
        vec3 upper = vec3(-INFINITY_T);
        [[unroll]] for (uint i = 0u; i < POINTS; i++) {
            vec3 position = points[i].position;
            points[i].wants = (place.served >> i & 1u) == 0u
                           && all(lessThanEqual(abs(cell_of(position, inverse_size) - home), ivec3(1)));
            // Wide enough that rounding leaves no photon out.
            float radius = 1.000001 * sqrt(points[i].radius2);
            lower = points[i].wants ? min(lower, position - radius) : lower;
            upper = points[i].wants ? max(upper, position + radius) : upper;
        }
        lower = least_of_lanes(lower);
        upper = -least_of_lanes(-upper);
        ivec3 corner = cell_of(lower, inverse_size);
        uvec3 size = uvec3(cell_of(upper, inverse_size) - corner + 1);
        uint total = size.x * size.y * size.z;
        for (; place.cell < total && left > 0u; place.cell += left > 0u ? lanes() : 0u) {
            // Each lane looks up a cell.
            uint i = place.cell + lane;
            ivec3 cell = corner + ivec3(i % size.x, (i / size.x) % size.y, i / (size.x * size.y));
            Cell range = Cell(0u, 0u);
            if (i < total) {
                range = cells.data[cell_hash(cell, cell_mask)];
            }
            left--;
            for (uint occupied = ballot(range.count > 0u && lane >= place.lane); occupied != 0u && left > 0u;) {
                uint k = findLSB(occupied);
                uint mark = subgroupShuffle(cell_mark(cell), peer(k));
                uint first = subgroupShuffle(range.first, peer(k));
                uint count = subgroupShuffle(range.count, peer(k));
                place.lane = k;
                for (; place.entry < count && left > 0u; place.entry += lanes()) {
                    left--;
                    PhotonRecord photon = grid_photons_at(first + min(place.entry + lane, count - 1u));
                    // Cells that share a hash share entries: take those of this cell only. One that has
                    // the same mark but is far away is not in the box.
                    bool wanted = place.entry + lane < count && photon.cell == mark
                               && all(greaterThanEqual(photon.position, lower)) && all(lessThanEqual(photon.position, upper));
                    gather_from(photon, wanted, points, sums);
                }
                if (place.entry >= count) {
                    place.entry = 0u;
                    place.lane = k + 1u;
                    occupied &= occupied - 1u;
                }
            }
            place.lane = left > 0u ? 0u : place.lane;
        }
        if (left > 0u) {
            [[unroll]] for (uint i = 0u; i < POINTS; i++) {
                place.served |= points[i].wants ? 1u << i : 0u;
            }
            place.cell = 0u;
        }
    }
    [[unroll]] for (uint i = 0u; i < POINTS; i++) {
        if (sums[i].count > 0u) {
            keep(sums[i], pixel_of(POINTS * invocation + i, width, height));
        }
    }
    if (has_place) {
        places.data[invocation] = place;
    }
    if (place.served != ALL_SERVED) {
        atomicAdd(counters.value.unfinished, 1u);
    }
    if (interrupted(two)) {
        atomicAdd(counters.value.interrupted, 1u);
    }
}
