// Eye paths on rough surfaces, which record no photons: next-event estimation and BSDF sampling find
// direct light there, combined by MIS.
#include "geometry/contact.glsl"
#include "geometry/surface.glsl"
#include "geometry/surface_point.glsl"
#include "light/light.glsl"
#include "material/bsdf.glsl"
#include "material/bump.glsl"
#include "material/glossy.glsl"
#include "material/microfacet.glsl"
#include "math/random.glsl"
#include "scene/constants.glsl"
#include "scene/features.glsl"
#include "scene/lights.glsl"
#include "scene/materials.glsl"

// The previous vertex of an eye path, if its surface was rough.
struct RoughVertex {
    vec3 position;
    float pdf; // of the direction in which the path went on, by solid angle; 0 if it was not rough
};

RoughVertex no_rough_vertex() {
    return RoughVertex(vec3(0.0), 0.0);
}

// Radiance that a rough surface reflects or transmits towards wo from one light, over the pdf of
// choosing that light, unless something blocks `to_light`; W/(m^2 sr).
vec3 direct_light_on_rough(Surface surface, Material material, vec3 wo, Hue hue, Random random, uint pair,
                           out Ray to_light) {
    to_light = free_ray(vec3(0.0), vec3(0.0));
    if (HAS_ROUGH) {
        if (HAS_LOCATABLE_LIGHTS) {
            LightSample direct = sample_direct(surface.position, hue, random_pair(random, pair).x,
                                               random_pair(random, pair + 1u));
            BsdfValue bsdf = evaluate_bsdf(material, wo, direct.wi, surface.shading_normal, surface.tangent, RADIANCE);
            float weight = direct.hittable ? mis_weight(direct.pdf, bsdf.pdf) : 1.0;
            to_light = shadow_ray(surface, direct.wi, direct.target, false);
            to_light.is_endless = direct.is_far;
            bsdf.value *= media_factor(surface, material, wo, direct.wi);
            bool lit = is_rough(material) && direct.pdf > 0.0 && bsdf.pdf > 0.0;
            return lit ? direct.radiance * bsdf.value * (weight / direct.pdf) : vec3(0.0);
        }
    }
    return vec3(0.0);
}

// The vertex of a path that goes on along wi.
RoughVertex rough_vertex(Surface surface, Material material, vec3 wo, vec3 wi) {
    if (HAS_ROUGH) {
        float pdf = evaluate_bsdf(material, wo, wi, surface.shading_normal, surface.tangent, RADIANCE).pdf;
        return RoughVertex(surface.position, is_rough(material) ? pdf : 0.0);
    }
    return no_rough_vertex();
}

// MIS weight of the emission of an area light that an eye path has met: 1 unless the previous vertex was
// rough, where next-event estimation samples the light as well.
float emission_mis_weight(RoughVertex previous, Light light, Surface surface, vec3 wi) {
    if (HAS_ROUGH) {
        return previous.pdf > 0.0 ? mis_weight(previous.pdf, direct_pdf(light, previous.position, surface, wi)) : 1.0;
    }
    return 1.0;
}

// The pdf of the direction of a ray that leaves the scene; INFINITY_T where next-event estimation does
// not sample the same light.
float escape_pdf(RoughVertex previous) {
    if (HAS_ROUGH) {
        return previous.pdf > 0.0 ? previous.pdf : INFINITY_T;
    }
    return INFINITY_T;
}
