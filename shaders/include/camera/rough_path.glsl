// Where eye paths meet rough surfaces. No photon is recorded there: next-event estimation and rays
// of the bsdf find the light, and share what both find by MIS.
#include "geometry/alpha.glsl"
#include "geometry/surface.glsl"
#include "geometry/surface_point.glsl"
#include "light/light.glsl"
#include "material/bsdf.glsl"
#include "material/glossy.glsl"
#include "material/microfacet.glsl"
#include "math/random.glsl"
#include "scene/constants.glsl"
#include "scene/features.glsl"
#include "scene/lights.glsl"
#include "scene/materials.glsl"

// The surface that a path has met last, if that was rough.
struct Last {
    vec3 position;
    float pdf; // of the direction that the path took there; 0 if it was not rough
};

Last not_rough() {
    return Last(vec3(0.0), 0.0);
}

// Radiance towards wo that a rough surface has straight from a light.
vec3 light_on_rough(Surface surface, Material material, vec3 wo, Random random, uint pair) {
    if (HAS_ROUGH) {
        if (HAS_LOCATABLE_LIGHTS) {
            LightSample direct = sample_direct(surface.position, random_pair(random, pair).x,
                                               random_pair(random, pair + 1u));
            Response response = respond(material, wo, direct.wi, surface.shading_normal, surface.tangent, RADIANCE);
            float weight = direct.hittable ? mis_weight(direct.pdf, response.pdf) : 1.0;
            bool blocked = occluded(shadow_ray(surface, direct.wi, direct.target, false));
            bool lit = is_rough(material) && direct.pdf > 0.0 && response.pdf > 0.0 && !blocked;
            return lit ? direct.radiance * response.value * (weight / direct.pdf) : vec3(0.0);
        }
    }
    return vec3(0.0);
}

// What a path remembers that goes on along wi.
Last after(Surface surface, Material material, vec3 wo, vec3 wi) {
    if (HAS_ROUGH) {
        float pdf = respond(material, wo, wi, surface.shading_normal, surface.tangent, RADIANCE).pdf;
        return Last(surface.position, is_rough(material) ? pdf : 0.0);
    }
    return not_rough();
}

// Weight of what an area light sends along a ray: all of it, unless next-event estimation has
// looked for it, too.
float weight_after(Last last, Light light, Surface surface, vec3 wi) {
    if (HAS_ROUGH) {
        return last.pdf > 0.0 ? mis_weight(last.pdf, direct_pdf(light, last.position, surface, wi)) : 1.0;
    }
    return 1.0;
}

// The pdf of a ray that leaves the scene; INFINITY_T where nothing else looks for the same light.
float pdf_after(Last last) {
    if (HAS_ROUGH) {
        return last.pdf > 0.0 ? last.pdf : INFINITY_T;
    }
    return INFINITY_T;
}
