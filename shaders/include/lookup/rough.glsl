// What rough surfaces gather. No ray from a rough surface meets a point light, nor a lamp that only photons can reach
// by way of smooth glass or mirrors: so photons bring that light, with their directions, and it is estimated with the
// BSDF at the point as a glossy part of a photon map (Jensen 1996, section 3.2). All other light of a rough surface is
// found by rays. So a photon is recorded here if its light is one that no ray meets, if it has been scattered, and if
// all lobes that have scattered it were smooth.
#include "geometry/normal.glsl"
#include "geometry/surface_point.glsl"
#include "lookup/records.glsl"
#include "material/bump.glsl"
#include "material/microfacet.glsl"
#include "scene/features.glsl"
#include "scene/materials.glsl"

// Where a pixel's eye path met a rough surface, with the lobe that it chose there.
struct RoughPoint {
    vec3 position;     // render units
    float path_length; // of the eye path up to there, render units; 0 if there is no point
    vec3 wo;           // towards the eye
    uint normal;       // geometric normal of the surface's front, packed
    vec3 throughput;   // of the eye path up to there, times the number of rough vertices of the path
    uint shading_normal; // packed
    vec3 color;        // as Material has it
    uint tangent;      // packed
    vec3 eta;          // as Material has it
    float alpha_u;     // as Material has it
    vec3 k;            // as Material has it
    float alpha_v;     // as Material has it
    float coat_eta;    // as Material has it
    float coat_thickness; // as Material has it
    float coat_sent_back; // as Material has it
    uint kind;         // in the low bits; IS_BENT; and Material.first from FIRST_SHIFT on
};

const uint KIND_MASK = 15u;
const uint IS_BENT = 16u; // a texture bends the shading normal
const uint FIRST_SHIFT = 5u;

RoughPoint no_rough_point() {
    return RoughPoint(vec3(0.0), 0.0, vec3(0.0), 0u, vec3(0.0), 0u, vec3(0.0), 0u, vec3(0.0), 0.0, vec3(0.0), 0.0, 0.0, 0.0,
                      0.0, 0u);
}

// The point of a path that has met a surface, on a lobe of the surface.
RoughPoint rough_point(Surface surface, Material material, vec3 wo, vec3 throughput, float path_length) {
    uint kind = material.kind | (is_bent(material) ? IS_BENT : 0u) | material.first << FIRST_SHIFT;
    vec3 tangent = surface.shading_normal;
    if (HAS_ANISOTROPIC) {
        tangent = frame_about(surface.shading_normal, surface.tangent).s;
    }
    return RoughPoint(surface.position, path_length, wo, pack_normal(surface.normal), throughput,
                      pack_normal(surface.shading_normal), material.color, pack_normal(tangent), material.eta,
                      material.alpha_u, material.k, material.alpha_v, material.coat_eta, material.coat_thickness,
                      material.coat_sent_back, kind);
}

// What is known of the lobe of a point.
Material material_of(RoughPoint point) {
    Material material;
    material.color = point.color;
    material.kind = point.kind & KIND_MASK;
    material.eta = point.eta;
    material.alpha_u = point.alpha_u;
    material.k = point.k;
    material.alpha_v = point.alpha_v;
    material.coat_eta = point.coat_eta;
    material.coat_thickness = point.coat_thickness;
    material.coat_sent_back = point.coat_sent_back;
    material.first = point.kind >> FIRST_SHIFT;
    material.flags = (point.kind & IS_BENT) != 0u ? DISPLACED : 0u;
    return material;
}

// What is known of the surface of a point.
Surface surface_of(RoughPoint point) {
    Surface surface;
    surface.position = point.position;
    surface.normal = unpack_normal(point.normal);
    surface.shading_normal = unpack_normal(point.shading_normal);
    surface.tangent = unpack_normal(point.tangent);
    return surface;
}

// Whether photons are recorded for the rough lobes of a surface.
bool gathers_on_facets(Material material) {
    return (material.flags & HAS_FACETS) != 0u;
}

// A photon on a rough surface. PhotonRecord.cell is the direction that it came from, packed; the normal is on the
// surface's front.
PhotonRecord rough_record(Surface surface, vec3 wo, vec3 weight) {
    return PhotonRecord(surface.position, pack_normal(surface.normal), weight, pack_normal(wo));
}
