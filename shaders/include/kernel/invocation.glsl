// The workgroup size, which the build script sets, and the number of an invocation.
#extension GL_EXT_control_flow_attributes : require
layout(local_size_x = WORKGROUP_SIZE) in;

// Number of the invocation. A dispatch is a rectangle of workgroups, since devices may allow no more than
// 65,535 along an axis.
uint invocation_index() {
    return gl_GlobalInvocationID.y * gl_NumWorkGroups.x * gl_WorkGroupSize.x + gl_GlobalInvocationID.x;
}
