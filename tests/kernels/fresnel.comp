// fresnel: computes Fresnel reflectances of dielectrics and metals.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "kernel/invocation.glsl"
#include "scene/types.glsl"
#include "scene/specialization.glsl"
#include "math/sampling.glsl"
#include "material/bsdf.glsl"

struct Boundary {
    float cos_i;
    float eta;
    float k;
    float pad0;
};

struct Reflectance {
    float dielectric;
    float cos_t;
    float conductor;
    float pad0;
};

layout(std430, set = 1, binding = 0) readonly buffer BoundaryBlock { Boundary data[]; } boundaries;
layout(std430, set = 1, binding = 1) buffer ReflectanceBlock { Reflectance data[]; } reflectances;

void main() {
    uint i = invocation_index();
    if (i >= boundaries.data.length()) {
        return;
    }
    Boundary boundary = boundaries.data[i];
    float cos_t;
    float dielectric = fresnel_dielectric(boundary.cos_i, boundary.eta, cos_t);
    // The boundary is in a different channel from invocation to invocation: channels must not mix.
    vec3 eta = vec3(1.5);
    vec3 k = vec3(2.5);
    eta[i % 3u] = boundary.eta;
    k[i % 3u] = boundary.k;
    float conductor = fresnel_conductor(boundary.cos_i, eta, k)[i % 3u];
    reflectances.data[i] = Reflectance(dielectric, cos_t, conductor, 0.0);
}
