// resolve: the image from the running estimates.
// One invocation per pixel. Reads pixel_*. Writes image, W/(m^2 sr).
// Hachisuka and Jensen 2009, eq. 9, plus emission and direct light.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "invocation.glsl"

layout(std430, set = 1, binding = 0) readonly buffer PixelFluxBlock { vec4 data[]; } pixel_flux; // w: squared radius
layout(std430, set = 1, binding = 1) readonly buffer PixelDirectBlock { vec4 data[]; } pixel_direct;
layout(std430, set = 1, binding = 2) buffer ImageBlock { vec4 data[]; } image;

layout(push_constant) uniform Push {
    uint pixel_count;
    float direct_scale; // one over iterations
    float flux_scale;   // mean flux of a photon over pi, W
};

void main() {
    uint pixel = invocation_index();
    if (pixel >= pixel_count) {
        return;
    }
    vec4 flux = pixel_flux.data[pixel];
    vec3 indirect = flux.rgb * (flux_scale / flux.w);
    image.data[pixel] = vec4(pixel_direct.data[pixel].rgb * direct_scale + indirect, 1.0);
}
