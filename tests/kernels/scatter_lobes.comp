// scatter_lobes: samples a material, and evaluates its BSDF for a direction.
#version 460
#include "kernel/invocation.glsl"
#include "material/bsdf.glsl"
#include "material/glossy.glsl"
#include "material/layers.glsl"
#include "material/microfacet.glsl"
#include "scene/materials.glsl"

struct Meeting {
    vec3 wo;
    uint material;
    vec3 wi;     // direction to evaluate, or zero to evaluate the sampled direction
    float u_lobe;
    vec3 normal;
    uint whole;  // 1 to choose a lobe of the material; 0 if the material is a lobe
    vec3 tangent;
    uint carries_radiance;
    vec2 u;
    vec2 pad0;
};

struct Scattered {
    vec3 wi;
    uint lobe;   // its kind
    vec3 weight;
    float pdf;   // of wi
    vec3 value;  // BSDF times |cos| of wi
    float pad0;
};

BUFFER(Meeting, meetings)
BUFFER(Material, lobes)
UPDATED_BUFFER(Scattered, outcomes)

void main() {
    uint i = invocation_index();
    if (i >= meetings.data.length()) {
        return;
    }
    Meeting meeting = meetings.data[i];
    Material material = lobes.data[meeting.material];
    bool transport = meeting.carries_radiance != 0u ? RADIANCE : FLUX;
    float u = meeting.u_lobe;
    if (meeting.whole != 0u) {
        material = choose_lobe(material, abs(dot(meeting.wo, meeting.normal)), u);
    }
    Scatter scattered = scatter(material, meeting.wo, meeting.normal, meeting.tangent, u, meeting.u, transport);
    vec3 wi = meeting.wi == vec3(0.0) ? scattered.wi : meeting.wi;
    BsdfValue bsdf = evaluate_bsdf(material, meeting.wo, wi, meeting.normal, meeting.tangent, transport);
    outcomes.data[i] = Scattered(wi, material.kind, scattered.weight, bsdf.pdf, bsdf.value, 0.0);
}
