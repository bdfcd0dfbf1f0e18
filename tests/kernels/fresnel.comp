// fresnel: computes Fresnel reflectances of dielectrics and metals.
#version 460
#include "kernel/invocation.glsl"
#include "material/fresnel.glsl"

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

BUFFER(Boundary, boundaries)
UPDATED_BUFFER(Reflectance, reflectances)

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
