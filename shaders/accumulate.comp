// accumulate: add each photon's weight to the visible points whose disc it is inside.
// Each invocation takes every stride-th recorded photon. Reads photon_*, cells, grid_*.
// Updates flux_low, flux_high (atomic, fixed point, w of flux_low counts photons).
// Hachisuka and Jensen 2009, eq. 5; the disc keeps light from leaking through thin walls
// and around corners.
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

layout(push_constant) uniform Push {
    uint recorded;
    uint stride;
    uint cell_mask;
    uint two; // 2, see interruption.glsl
};

// A photon belongs to the visible point's own surface when their normals agree to within
// 60 degrees and it is this near the tangent plane, in radii.
const float MIN_COSINE = 0.5;
const float MAX_HEIGHT = 0.25;

void add_channel(uint index, uvec2 fixed_point) {
    uint low = atomicAdd(flux_low.data[index], fixed_point.x);
    uint high = fixed_point.y + (low + fixed_point.x < low ? 1u : 0u);
    if (high > 0u) {
        uint before = atomicAdd(flux_high.data[index], high);
        if (before + high < before) {
            atomicAdd(counters.value.saturated, 1u);
        }
    }
}

void main() {
    uint invocation = invocation_index();
    if (invocation >= stride) {
        return; // its photons are another invocation's
    }
    float inverse_size = 1.0 / cell_size(grid_info.value.max_radius2);
    for (uint photon = invocation; photon < recorded; photon += stride) {
        vec4 record = photon_positions.data[photon];
        vec3 photon_normal = unpack_normal(floatBitsToUint(record.w));
        vec3 weight = photon_weights.data[photon].xyz;
        uvec2 red = to_fixed(weight.x);
        uvec2 green = to_fixed(weight.y);
        uvec2 blue = to_fixed(weight.z);
        ivec3 corner = ivec3(floor(record.xyz * inverse_size - 0.5));
        uint neighbour = 0u;
        uint entry = 0u;
        uint last = 0u;
        ivec3 cell = corner;
        // Eight cells, one after the other. Lanes run ahead to their next point in reach before
        // any adds to it, so that few of them are idle while one adds.
        while (true) {
            vec4 point;
            vec3 d;
            while (entry < last) {
                point = grid_positions.data[entry];
                d = record.xyz - point.xyz;
                if (dot(d, d) < point.w) {
                    break;
                }
                entry++;
            }
            if (entry < last) {
                uvec2 owner = grid_owners.data[entry];
                vec3 n = unpack_normal(owner.x);
                float height = dot(d, n);
                // Cells that share a hash share entries: take those of this cell only.
                if (dot(n, photon_normal) > MIN_COSINE && height * height < MAX_HEIGHT * MAX_HEIGHT * point.w
                    && cell_of(point.xyz, inverse_size) == cell) {
                    add_channel(4u * owner.y, red);
                    add_channel(4u * owner.y + 1u, green);
                    add_channel(4u * owner.y + 2u, blue);
                    atomicAdd(flux_low.data[4u * owner.y + 3u], 1u);
                }
                entry++;
            } else if (neighbour < 8u) {
                cell = corner + ivec3(neighbour & 1u, (neighbour >> 1u) & 1u, neighbour >> 2u);
                neighbour++;
                Cell range = cells.data[cell_hash(cell, cell_mask)];
                entry = range.first;
                last = range.first + range.count;
            } else {
                break;
            }
        }
    }
    if (interrupted(two)) {
        atomicAdd(counters.value.interrupted, 1u);
    }
}
