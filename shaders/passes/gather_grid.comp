// gather_grid: each visible point gathers the photons on its disc, from the hash grid.
//
// Invocations: one per POINTS pixels. Those of a subgroup have a compact block of the image and test
//   the same photons together: each lane loads one photon, and all lanes test it. A subgroup that has
//   tested many photons stores its position in `places` and counts as unfinished; another dispatch
//   goes on from there, so that no dispatch is long.
// Reads: visible_points, visible_radii2, max_radius2, grid_extent, cells, grid_photons; places where it resumes.
// Writes: flux_red, flux_green, flux_blue, flux_counts (sums, each by its pixel's invocation alone),
//   places, counters (atomic).
// Units: lengths in render units; flux over the mean flux of a photon, in fixed point (flux.glsl).
// Source: Hachisuka and Jensen 2009, equation 5; the grid: Teschner and others 2003.
#version 460
#include "geometry/normal.glsl"
#include "kernel/counters.glsl"
#include "kernel/interruption.glsl"
#include "kernel/invocation.glsl"
#include "kernel/subgroup.glsl"
#include "kernel/tile.glsl"
#include "lookup/caustic.glsl"
#include "lookup/disc.glsl"
#include "lookup/flux.glsl"
#include "lookup/gather.glsl"
#include "lookup/grid.glsl"
#include "lookup/records.glsl"
#include "scene/constants.glsl"
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
VALUE(GridExtent, grid_extent)
BUFFER(Cell, cells)
TEXELS(PhotonRecord, grid_photons)
UPDATED_BUFFER(GridPlace, places) // of invocations that go on

layout(push_constant) uniform Push {
    uint width;   // of the image, pixels
    uint height;  // of the image, pixels
    uint resumed; // 1 to go on from `places`
    uint offset;  // first invocation of this dispatch
};

// Rounds of loops in one dispatch: fewer than the 65,535 that llvmpipe allows an invocation.
const uint MAX_ROUNDS = 60000u;

uint cell_mask; // of grid_extent, loaded once

// Number of lanes that work together: a power of two, and at most the number of bits in a word.
uint lanes() {
    return min(subgroup_lanes(), 32u);
}

// One bit for each lane that works together.
uint ballot(bool value) {
    uint shift = gl_SubgroupInvocationID & ~31u;
    return subgroupBallot(value)[shift >> 5u];
}

// Number in the subgroup of a lane that is numbered among those that work together.
uint peer(uint lane) {
    return (gl_SubgroupInvocationID & ~31u) + lane;
}

// As invocation_index, but the lanes of a subgroup have consecutive numbers, in whatever order the
// device puts invocations into subgroups: a later dispatch goes on with the same peers.
uint invocation_index_by_subgroup() {
    uint workgroup = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    return workgroup * gl_WorkGroupSize.x + gl_SubgroupID * subgroup_lanes() + gl_SubgroupInvocationID;
}

vec3 min_over_lanes(vec3 v) {
    for (uint step = 1u; step < lanes(); step *= 2u) {
        v = min(v, subgroupShuffle(v, gl_SubgroupInvocationID ^ step));
    }
    return v;
}

// Pixels per invocation: each photon that a lane loads is tested against all of them.
export const uint POINTS = 2u;
const uint ALL_SERVED = (1u << POINTS) - 1u;

// The visible point of one of the invocation's pixels.
struct GatherPoint {
    vec3 position;
    float radius2; // 0 if the pixel has no visible point
    vec3 normal;
    bool is_active; // gathers from the cells that are looked up now
};

GatherPoint gather_point(uint pixel) {
    if (pixel == NONE) {
        return GatherPoint(vec3(0.0), 0.0, vec3(0.0), false);
    }
    VisiblePoint point = visible_points_at(pixel);
    return GatherPoint(point.position, visible_radii2_at(pixel), unpack_normal(point.normal), false);
}

// An axis-aligned box.
struct Box {
    vec3 lower;
    vec3 upper;
};

bool contains(Box box, vec3 position) {
    return all(greaterThanEqual(position, box.lower)) && all(lessThanEqual(position, box.upper));
}

// The cell of the first point that is not served yet; `waiting` has a bit for each lane with one.
ivec3 first_waiting_cell(uint waiting, uint served, GatherPoint points[POINTS], float inverse_size) {
    vec3 position = points[POINTS - 1u].position;
    [[unroll]] for (uint i = POINTS - 1u; i > 0u; i--) {
        position = (served >> (i - 1u) & 1u) == 0u ? points[i - 1u].position : position;
    }
    return subgroupShuffle(cell_of(position, inverse_size), peer(findLSB(waiting)));
}

// Activates the points not served yet in a cell or its neighbours. Returns the box around the discs of
// all lanes' active points.
Box activate_near(ivec3 home, uint served, float inverse_size, inout GatherPoint points[POINTS]) {
    Box box = Box(vec3(INFINITY_T), vec3(-INFINITY_T));
    [[unroll]] for (uint i = 0u; i < POINTS; i++) {
        vec3 position = points[i].position;
        points[i].is_active = (served >> i & 1u) == 0u
                           && all(lessThanEqual(abs(cell_of(position, inverse_size) - home), ivec3(1)));
        // Widened, so that rounding leaves no photon out.
        float radius = 1.000001 * sqrt(points[i].radius2);
        box.lower = points[i].is_active ? min(box.lower, position - radius) : box.lower;
        box.upper = points[i].is_active ? max(box.upper, position + radius) : box.upper;
    }
    return Box(min_over_lanes(box.lower), -min_over_lanes(-box.upper));
}

// Each lane has a photon, or none if it is not a `candidate`; each active point adds those on its disc.
void gather_from_lanes(PhotonRecord photon, bool candidate, GatherPoint points[POINTS], inout Gathered sums[POINTS]) {
    vec3 normal = unpack_normal(photon.normal);
    uvec2 red = to_words(photon.weight.x);
    uvec2 green = to_words(photon.weight.y);
    uvec2 blue = to_words(photon.weight.z);
    for (uint left = ballot(candidate); left != 0u; left &= left - 1u) {
        uint lane = peer(findLSB(left));
        vec3 position = subgroupShuffle(photon.position, lane);
        vec3 photon_normal = subgroupShuffle(normal, lane);
        uvec3 low = uvec3(subgroupShuffle(red.x, lane), subgroupShuffle(green.x, lane), subgroupShuffle(blue.x, lane));
        uvec3 high = uvec3(subgroupShuffle(red.y, lane), subgroupShuffle(green.y, lane), subgroupShuffle(blue.y, lane));
        [[unroll]] for (uint i = 0u; i < POINTS; i++) {
            vec3 d = position - points[i].position;
            bool hit = points[i].is_active && dot(d, d) < points[i].radius2
                    && is_on_disc(d, photon_normal, points[i].normal, points[i].radius2);
            gather_photon(sums[i], low, high, hit);
            if (HAS_DATA_RADII) {
                sums[i].inner += hit && is_inner(d, points[i].radius2) ? 1u : 0u;
            }
        }
    }
}

// Gathers from the cells that the lanes have looked up, one per lane. `left` counts down the rounds of
// this dispatch; where it gets to 0, `place` has the lane and entry to go on with.
void gather_from_cells(ivec3 cell, Cell range, Box box, GatherPoint points[POINTS], inout GridPlace place,
                       inout uint left, inout Gathered sums[POINTS]) {
    uint lane = gl_SubgroupInvocationID & 31u;
    for (uint occupied = ballot(range.count > 0u && lane >= place.lane); occupied != 0u && left > 0u;) {
        uint k = findLSB(occupied);
        uint mark = subgroupShuffle(cell_mark(cell), peer(k));
        uint first = subgroupShuffle(range.first, peer(k));
        uint count = subgroupShuffle(range.count, peer(k));
        place.lane = k;
        for (; place.entry < count && left > 0u; place.entry += lanes()) {
            left--;
            PhotonRecord photon = grid_photons_at(first + min(place.entry + lane, count - 1u));
            // Cells with the same hash share a range of entries: take the photons of this cell only. A
            // distant cell may have the same mark, but its photons are outside the box.
            bool candidate = place.entry + lane < count && cell_of_record(photon) == mark && contains(box, photon.position);
            candidate = candidate && is_gathered(photon);
            gather_from_lanes(photon, candidate, points, sums);
        }
        if (place.entry >= count) {
            place.entry = 0u;
            place.lane = k + 1u;
            occupied &= occupied - 1u;
        }
    }
    place.lane = left > 0u ? 0u : place.lane;
}

// Gathers from all cells that a box overlaps, as many cells at once as there are lanes.
void gather_from_box(Box box, float inverse_size, GatherPoint points[POINTS], inout GridPlace place,
                     inout uint left, inout Gathered sums[POINTS]) {
    ivec3 corner = cell_of(box.lower, inverse_size);
    uvec3 size = uvec3(cell_of(box.upper, inverse_size) - corner + 1);
    uint total = size.x * size.y * size.z;
    for (; place.cell < total && left > 0u; place.cell += left > 0u ? lanes() : 0u) {
        uint i = place.cell + (gl_SubgroupInvocationID & 31u);
        ivec3 cell = corner + ivec3(i % size.x, (i / size.x) % size.y, i / (size.x * size.y));
        Cell range = Cell(0u, 0u);
        if (i < total) {
            range = cells.data[cell_hash(cell, cell_mask)];
        }
        left--;
        gather_from_cells(cell, range, box, points, place, left, sums);
    }
}

void main() {
    uint invocation = offset + invocation_index_by_subgroup();
    float inverse_size = 1.0 / cell_size(max_radius2.value);
    cell_mask = grid_extent.value.cell_mask;
    // Invocations that only fill up the last workgroup have no place and no pixels.
    bool has_place = POINTS * invocation < invocations_by_tile(width, height);
    GridPlace place = GridPlace(0u, 0u, 0u, 0u);
    if (resumed != 0u && has_place) {
        place = places.data[invocation];
    }
    GatherPoint points[POINTS];
    Gathered sums[POINTS];
    [[unroll]] for (uint i = 0u; i < POINTS; i++) {
        points[i] = gather_point(pixel_of(POINTS * invocation + i, width, height));
        sums[i] = nothing_gathered();
        place.served |= points[i].radius2 > 0.0 ? 0u : 1u << i;
    }
    // Looking up cells, or loading photons, is one step: a round of a loop for each lane, and four more.
    uint left = MAX_ROUNDS / (lanes() + 4u);
    // Points near the first one that waits are served together.
    for (uint waiting = ballot(place.served != ALL_SERVED); waiting != 0u && left > 0u;
         waiting = ballot(place.served != ALL_SERVED)) {
        ivec3 home = first_waiting_cell(waiting, place.served, points, inverse_size);
        Box box = activate_near(home, place.served, inverse_size, points);
        gather_from_box(box, inverse_size, points, place, left, sums);
        if (left > 0u) {
            [[unroll]] for (uint i = 0u; i < POINTS; i++) {
                place.served |= points[i].is_active ? 1u << i : 0u;
            }
            place.cell = 0u;
        }
    }
    [[unroll]] for (uint i = 0u; i < POINTS; i++) {
        if (sums[i].count > 0u) {
            add_to_pixel(sums[i], pixel_of(POINTS * invocation + i, width, height));
        }
    }
    if (has_place) {
        places.data[invocation] = place;
    }
    if (place.served != ALL_SERVED) {
        atomicAdd(counters.value.unfinished, 1u);
    }
    if (interrupted()) {
        atomicAdd(counters.value.interrupted, 1u);
    }
}
