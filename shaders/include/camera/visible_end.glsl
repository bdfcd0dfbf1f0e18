// The end of an eye path on a diffuse surface, and the direct light that it finds there.
#include "geometry/contact.glsl"
#include "geometry/surface.glsl"
#include "geometry/surface_point.glsl"
#include "light/light.glsl"
#include "material/layers.glsl"
#include "math/random.glsl"
#include "math/sampling.glsl"
#include "scene/features.glsl"
#include "scene/lights.glsl"
#include "scene/materials.glsl"

// Of a path that has met no diffuse surface yet, only `is_reached` is defined.
struct VisibleEnd {
    bool is_reached;
    vec3 position;     // render units
    float cosine;      // of the shading normal and the direction in which the path looks for lights
    vec3 direct;       // radiance by one light, over the pdf of choosing it, unless it is blocked; W/(m^2 sr)
    Ray to_light;      // asks whether it is
};

// Samples a light for a visible point, chosen by power: the irradiance, over the pdf of choosing it, unless
// the light is blocked; W/m^2. Takes two pairs of random numbers, from `pair` on.
vec3 sample_direct_irradiance(Surface surface, Material material, Hue hue, Random random, uint pair,
                              out Ray to_light) {
    to_light = free_ray(vec3(0.0), vec3(0.0));
    if (HAS_LOCATABLE_LIGHTS) {
        LightSample direct = sample_direct(surface.position, hue, random_pair(random, pair).x,
                                           random_pair(random, pair + 1u));
        float cos_surface = max(dot(direct.wi, surface.shading_normal), 0.0);
        float weight = direct.uses_mis ? mis_weight(direct.pdf, cos_surface / PI) : 1.0;
        bool passes = HAS_DIFFUSE_TRANSMISSION && (material.flags & BEHIND) != 0u;
        to_light = shadow_ray(surface, direct.wi, direct.target, passes);
        to_light.is_endless = direct.is_far;
        weight *= transmittance_to_base(material, cos_surface);
        vec3 irradiance = direct.pdf > 0.0 ? direct.radiance * (cos_surface * weight / direct.pdf) : vec3(0.0);
        return scattering_factor(material, cos_surface, irradiance);
    }
    return vec3(0.0);
}

// MIS weight of an area light that a BSDF sample of a diffuse surface has met. It is 0 for lights that
// next-event estimation alone samples.
float diffuse_mis_weight(Light light, VisibleEnd from, Surface surface, vec3 wi) {
    float pdf = direct_pdf(light, from.position, surface, wi);
    return uses_mis(light, from.position) ? mis_weight(from.cosine / PI, pdf) : 0.0;
}

// Whether a diffuse surface samples its BSDF for lights, besides next-event estimation.
bool samples_bsdf_for_lights(vec3 from) {
    if (DIRECT_NEE) {
        return HAS_INFINITE_LIGHTS || may_use_mis(from);
    }
    return false;
}
