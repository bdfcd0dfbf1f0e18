// refract: scatters light at a surface, and scatters it back along the sampled direction.
#version 460
#include "kernel/invocation.glsl"
#include "material/bsdf.glsl"
#include "scene/materials.glsl"

struct Incidence {
    vec3 wo;
    float u;
    vec3 normal;
    uint kind;
    vec3 color;
    uint carries_radiance;
    vec3 eta;
    float pad0;
    vec3 k;
    float pad1;
    vec2 u_direction;
    vec2 pad2;
};

struct Outcome {
    vec3 wi;
    uint transmitted;
    vec3 weight;
    float pad0;
    vec3 wi_back;
    uint transmitted_back;
    vec3 weight_back;
    float pad1;
};

BUFFER(Incidence, incidences)
UPDATED_BUFFER(Outcome, outcomes)

void main() {
    uint i = invocation_index();
    if (i >= incidences.data.length()) {
        return;
    }
    Incidence incidence = incidences.data[i];
    Material material;
    material.color = incidence.color;
    material.kind = incidence.kind;
    material.eta = incidence.eta;
    material.k = incidence.k;
    material.alpha_u = 0.0;
    material.alpha_v = 0.0;
    material.coat_eta = 0.0;
    material.flags = 0u;
    bool transport = incidence.carries_radiance != 0u ? RADIANCE : FLUX;
    Scatter there = scatter(material, incidence.wo, incidence.normal, vec3(0.0), incidence.u, incidence.u_direction, transport);
    Scatter back = scatter(material, there.wi, incidence.normal, vec3(0.0), incidence.u, incidence.u_direction, transport);
    outcomes.data[i] = Outcome(there.wi, there.eta != 1.0 ? 1u : 0u, there.weight, 0.0,
                               back.wi, back.eta != 1.0 ? 1u : 0u, back.weight, 0.0);
}
