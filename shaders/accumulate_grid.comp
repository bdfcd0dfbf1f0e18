// accumulate_grid: each visible point gathers the photons inside its disc, from the hash grid.
// One invocation per pixel; those of a subgroup see neighbouring points and look at the same
// photons together: each loads one, and all test it. A subgroup that has met many photons
// leaves its place in `places` and counts as unfinished, so that no dispatch is long. Reads
// visible_*, cells, grid_photons. Updates flux_low, flux_high (fixed point, w of flux_low
// counts photons), places.
// Hachisuka and Jensen 2009, eq. 5.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_shuffle : require
#include "invocation.glsl"
#include "types.glsl"
#include "grid.glsl"
#include "normal.glsl"
#include "tile.glsl"
#include "interruption.glsl"

layout(std430, set = 1, binding = 0) readonly buffer PositionBlock { vec4 data[]; } visible_positions; // w: squared radius
layout(std430, set = 1, binding = 1) readonly buffer VisibleNormalBlock { uint data[]; } visible_normals;
layout(std430, set = 1, binding = 2) readonly buffer MaxRadiusBlock { uint value; } max_radius2;
layout(std430, set = 1, binding = 3) readonly buffer CellBlock { Cell data[]; } cells;
TEXELS(1, 4, PhotonRecord, grid_photons)
layout(std430, set = 1, binding = 5) buffer FluxLowBlock { uint data[]; } flux_low; // r, g, b, count of each pixel
layout(std430, set = 1, binding = 6) buffer FluxHighBlock { uint data[]; } flux_high; // r, g, b, unused
layout(std430, set = 1, binding = 7) buffer CounterBlock { Counters value; } counters;
layout(std430, set = 1, binding = 8) buffer PlaceBlock { GridPlace data[]; } places; // of invocations that go on

#include "gather.glsl"

layout(push_constant) uniform Push {
    uint width;
    uint height;
    uint cell_mask;
    uint resumed; // 1 to go on from `places`
    uint two;     // 2, see interruption.glsl
};

// Photons that a subgroup loads at once, times this, are tested in one dispatch. llvmpipe
// allows an invocation 65,535 rounds in all, and each of these may cost 8 + 2.
const uint MAX_ROUNDS = 6000u;

// Lanes of a subgroup: a power of two.
uint lanes() {
    return min(gl_SubgroupSize, gl_WorkGroupSize.x);
}

vec3 least_of_lanes(vec3 v) {
    for (uint step = 1u; step < lanes(); step *= 2u) {
        v = min(v, subgroupShuffle(v, gl_SubgroupInvocationID ^ step));
    }
    return v;
}

uint first_bit(uvec4 bits) {
    return bits.x != 0u ? findLSB(bits.x) : bits.y != 0u ? 32u + findLSB(bits.y)
         : bits.z != 0u ? 64u + findLSB(bits.z) : 96u + findLSB(bits.w);
}

bool has_bits(uvec4 bits) {
    return (bits.x | bits.y | bits.z | bits.w) != 0u;
}

// Clears the lowest bit.
uvec4 without_first(uvec4 bits) {
    uvec4 rest = bits & (bits - 1u);
    return bits.x != 0u ? uvec4(rest.x, bits.yzw) : bits.y != 0u ? uvec4(0u, rest.y, bits.zw)
         : bits.z != 0u ? uvec4(0u, 0u, rest.z, bits.w) : uvec4(0u, 0u, 0u, rest.w);
}

struct Point {
    vec3 position;
    float radius2; // 0 if it gathers nothing now
    vec3 normal;
};

// Each lane has a photon, some of them wanted; each point takes those on its disc.
void gather_from(PhotonRecord photon, bool wanted, Point point, inout Gathered sum) {
    vec3 normal = unpack_normal(photon.normal);
    uvec2 red = to_fixed(photon.weight.x);
    uvec2 green = to_fixed(photon.weight.y);
    uvec2 blue = to_fixed(photon.weight.z);
    for (uvec4 left = subgroupBallot(wanted); has_bits(left); left = without_first(left)) {
        uint lane = first_bit(left);
        vec3 d = subgroupShuffle(photon.position, lane) - point.position;
        bool hit = dot(d, d) < point.radius2
                && is_on_disc(d, subgroupShuffle(normal, lane), point.normal, point.radius2);
        gather(sum, uvec3(subgroupShuffle(red.x, lane), subgroupShuffle(green.x, lane), subgroupShuffle(blue.x, lane)),
               uvec3(subgroupShuffle(red.y, lane), subgroupShuffle(green.y, lane), subgroupShuffle(blue.y, lane)), hit);
    }
}

void main() {
    uint pixel = pixel_of(invocation_index(), width, height);
    uint lane = gl_SubgroupInvocationID;
    float inverse_size = 1.0 / cell_size(max_radius2.value);
    vec4 visible = vec4(0.0);
    GridPlace place = GridPlace(0u, 0u, 0u, 0u);
    vec3 normal = vec3(0.0);
    if (pixel != NONE) {
        visible = visible_positions.data[pixel];
        normal = unpack_normal(visible_normals.data[pixel]);
    }
    if (resumed != 0u) {
        place = places.data[invocation_index()];
    }
    ivec3 home = cell_of(visible.xyz, inverse_size);
    // Wide enough that rounding leaves no photon out.
    float radius = 1.000001 * sqrt(visible.w);
    Gathered sum = nothing_gathered();
    uint left = MAX_ROUNDS;
    // Points near the first one that waits are served together.
    for (uvec4 waiting = subgroupBallot(visible.w > 0.0 && place.served == 0u); has_bits(waiting) && left > 0u;
         waiting = subgroupBallot(visible.w > 0.0 && place.served == 0u)) {
        ivec3 first_home = subgroupShuffle(home, first_bit(waiting));
        bool member = visible.w > 0.0 && place.served == 0u && all(lessThanEqual(abs(home - first_home), ivec3(1)));
        Point point = Point(visible.xyz, member ? visible.w : 0.0, normal);
        vec3 lower = least_of_lanes(member ? visible.xyz - radius : vec3(INFINITY_T));
        vec3 upper = -least_of_lanes(member ? -(visible.xyz + radius) : vec3(INFINITY_T));
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
            for (uvec4 occupied = subgroupBallot(range.count > 0u && lane >= place.lane); has_bits(occupied) && left > 0u;) {
                uint k = first_bit(occupied);
                ivec3 visited = subgroupShuffle(cell, k);
                uint first = subgroupShuffle(range.first, k);
                uint count = subgroupShuffle(range.count, k);
                place.lane = k;
                for (; place.entry < count && left > 0u; place.entry += lanes()) {
                    left--;
                    PhotonRecord photon = grid_photons_at(first + min(place.entry + lane, count - 1u));
                    // Cells that share a hash share entries: take those of this cell only.
                    bool wanted = place.entry + lane < count && cell_of(photon.position, inverse_size) == visited
                               && all(greaterThanEqual(photon.position, lower)) && all(lessThanEqual(photon.position, upper));
                    gather_from(photon, wanted, point, sum);
                }
                if (place.entry >= count) {
                    place.entry = 0u;
                    place.lane = k + 1u;
                    occupied = without_first(occupied);
                }
            }
            place.lane = left > 0u ? 0u : place.lane;
        }
        if (left > 0u) {
            place.served = member ? 1u : place.served;
            place.cell = 0u;
        }
    }
    if (sum.count > 0u) {
        keep(sum, pixel);
    }
    places.data[invocation_index()] = place;
    if (left == 0u && visible.w > 0.0 && place.served == 0u) {
        atomicAdd(counters.value.unfinished, 1u);
    }
    if (interrupted(two)) {
        atomicAdd(counters.value.interrupted, 1u);
    }
}
