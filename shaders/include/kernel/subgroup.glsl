// How many invocations of a kernel run together.
#extension GL_KHR_shader_subgroup_basic : require
#include "kernel/invocation.glsl"
#include "scene/features.glsl"

// Number of lanes of each subgroup. Workgroups consist of whole subgroups, or of a part of one.
//
// gl_SubgroupSize does not tell: a driver reports one number for all kernels, and may run this one with fewer
// lanes.
uint subgroup_lanes() {
    if (KNOWS_LANES) {
        return LANES;
    }
    return gl_WorkGroupSize.x / gl_NumSubgroups;
}
