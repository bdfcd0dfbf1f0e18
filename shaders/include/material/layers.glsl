// Materials of several lobes: at each point of a path one of them is taken by chance.
//
// A coat is a dielectric boundary over a base. Light that enters towards a Lambertian base at
// wi and leaves at wo keeps what both crossings let through and what the coat does not absorb;
// what its underside sends back meets the base again, and again. With e the share that one
// way through the coat keeps,
//   bsdf = e(wo) e(wi) albedo / (pi eta^2 (1 - albedo * sent_back)),
// exact where the boundary is smooth. A photon that is recorded there has e(wi) already.
#include "material/fresnel.glsl"
#include "scene/features.glsl"
#include "scene/materials.glsl"

// What light keeps on its way through a coat from a direction; cosines are outside.
float through_coat(Material material, float cos_o) {
    float cos_t;
    float reflectance = fresnel_dielectric(cos_o, material.coat_eta, cos_t);
    return (1.0 - reflectance) * exp(-material.coat_thickness / max(cos_t, 1.0e-6));
}

// Share of arriving light that gets to where a visible point is.
float entering(Material material, float cos_i) {
    if (HAS_COATS) {
        return material.coat_eta > 0.0 ? through_coat(material, min(cos_i, 1.0)) : 1.0;
    }
    return 1.0;
}

// Splits chance from the rest of a random number.
bool takes(float chance, inout float u) {
    bool first = u < chance;
    u = clamp(first ? u / chance : (u - chance) / (1.0 - chance), 0.0, 0.99999994);
    return first;
}

// The least chance of a coat's lobe: highlights of rough ones come from few paths otherwise.
const float LEAST_CHANCE = 0.1;

Material choose_side_of_coat(Material material, float cos_o, inout float u) {
    float cos_t;
    float reflectance = fresnel_dielectric(cos_o, material.coat_eta, cos_t);
    float chance = clamp(reflectance, LEAST_CHANCE, 1.0 - LEAST_CHANCE);
    if (takes(chance, u)) {
        material.color = vec3(1.0 / chance);
        material.alpha_u = material.coat_alpha_u;
        material.alpha_v = material.coat_alpha_v;
        material.kind = COAT;
    } else if (material.kind == COATED_DIFFUSE) {
        vec3 sent_back = material.coat_sent_back * material.color;
        float leaving = through_coat(material, cos_o) / (material.coat_eta * material.coat_eta);
        material.color *= leaving / ((1.0 - chance) * (1.0 - sent_back));
        material.kind = DIFFUSE;
    } else {
        material.color = vec3(1.0 / (1.0 - chance));
    }
    return material;
}

// A material of one lobe, with its color divided by the chance of it; u is used up in part.
Material choose_lobe(Material material, float cos_o, inout float u) {
    if (HAS_COATS && (material.kind == COATED_DIFFUSE || material.kind == COATED_CONDUCTOR)) {
        return choose_side_of_coat(material, min(cos_o, 1.0), u);
    }
    if (HAS_DIFFUSE_TRANSMISSION && material.kind == DIFFUSE_TRANSMISSION) {
        float reflected = max(material.color.x, max(material.color.y, material.color.z));
        float transmitted = max(material.second.x, max(material.second.y, material.second.z));
        float chance = clamp(reflected / max(reflected + transmitted, 1.0e-20), 0.0, 1.0);
        material.kind = DIFFUSE;
        if (takes(chance, u)) {
            material.color /= max(chance, 1.0e-20);
        } else {
            material.color = material.second / (1.0 - chance);
            material.flags |= BEHIND;
        }
    }
    return material;
}
