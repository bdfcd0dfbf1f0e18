// The size and shape of a dispatch. The build script compiles each kernel for several
// workgroup sizes.
#extension GL_EXT_control_flow_attributes : require
layout(local_size_x = WORKGROUP_SIZE) in;

// A dispatch is a rectangle of workgroups, since one axis holds at most 65535.
uint invocation_index() {
    return gl_GlobalInvocationID.y * gl_NumWorkGroups.x * gl_WorkGroupSize.x + gl_GlobalInvocationID.x;
}
