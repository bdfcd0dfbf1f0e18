// grid_size: chooses the number of cells of the hash grid for the photons that a batch has recorded, and the sizes
// of the dispatches that sort them.
//
// Invocations: one.
// Reads: counters. Writes: grid_extent; max_radius2 where SORTS_ROUGH.
// Units: lengths in render units.
#version 460
#include "kernel/counters.glsl"
#include "kernel/invocation.glsl"
#include "lookup/grid.glsl"
#include "scene/features.glsl"

UPDATED_VALUE(GridExtent, grid_extent)
UPDATED_VALUE(uint, max_radius2) // bits of a float

layout(push_constant) uniform Push {
    uint capacity; // photons that there is room for
    float radius2; // squared radius of the largest disc of rough points
};

// Workgroups along an axis that every device can dispatch.
const uint MAX_GROUPS = 65535u;

// The dispatch of one invocation for each element, or none if there is no element.
uvec3 dispatch_over(uint elements) {
    uint groups = elements / WORKGROUP_SIZE + uint(elements % WORKGROUP_SIZE > 0u);
    uint rows = max(groups / MAX_GROUPS + uint(groups % MAX_GROUPS > 0u), 1u);
    return uvec3(groups / rows + uint(groups % rows > 0u), rows, 1u);
}

void main() {
    if (invocation_index() > 0u) {
        return;
    }
    // The host begins again with a smaller batch if they did not fit.
    uint recorded = counters.value.recorded;
    if (SORTS_ROUGH) {
        recorded = counters.value.recorded_rough;
        max_radius2.value = floatBitsToUint(radius2);
    }
    recorded = recorded <= capacity ? recorded : 0u;
    // As many cells as photons, since more would be empty; a power of two.
    uint cells = recorded > 1u ? 2u << findMSB(recorded - 1u) : 1u;
    grid_extent.value = GridExtent(dispatch_over(recorded), recorded, dispatch_over(cells), cells - 1u);
}
