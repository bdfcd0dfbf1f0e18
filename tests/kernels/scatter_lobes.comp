// scatter_lobes: a direction from a material, and what the material says of a direction.
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
    vec3 wi;     // to be judged, or zero to judge the direction that is drawn
    float u_lobe;
    vec3 normal;
    uint whole;  // 1: a lobe is chosen first; 0: the material is one
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
    vec3 value;  // bsdf * |cos| of wi
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
    bool carries = meeting.carries_radiance != 0u ? RADIANCE : FLUX;
    float u = meeting.u_lobe;
    if (meeting.whole != 0u) {
        material = choose_lobe(material, abs(dot(meeting.wo, meeting.normal)), u);
    }
    Scatter scattered = scatter(material, meeting.wo, meeting.normal, meeting.tangent, u, meeting.u, carries);
    vec3 wi = meeting.wi == vec3(0.0) ? scattered.wi : meeting.wi;
    Response response = respond(material, meeting.wo, wi, meeting.normal, meeting.tangent, carries);
    outcomes.data[i] = Scattered(wi, material.kind, scattered.weight, response.pdf, response.value, 0.0);
}
