// Materials of several lobes. At each vertex of a path, one lobe is chosen at random.
//
// A coat is a dielectric boundary over a base. Light loses energy at each crossing of the boundary, and
// to absorption in the coat. The underside of the boundary reflects a part of the light back to the
// base, again and again: a geometric series. With T(w) the transmittance of the coat along w and
// sent_back the part that the underside reflects, the BSDF over a Lambertian base is
//   T(wo) T(wi) albedo / (pi eta^2 (1 - albedo * sent_back)),
// exact where the boundary is smooth. The weight of a recorded photon already contains T(wi).
#include "material/fresnel.glsl"
#include "scene/features.glsl"
#include "scene/materials.glsl"

// Transmittance of a coat: of its boundary and of one way through it. cos_o is outside the coat.
float coat_transmittance(Material material, float cos_o) {
    float cos_t;
    float reflectance = fresnel_dielectric(cos_o, material.coat_eta, cos_t);
    return (1.0 - reflectance) * exp(-material.coat_thickness / max(cos_t, 1.0e-6));
}

// Half the distance of the outer ones of three nodes in [0, 1], those of Chebyshev's polynomial.
const float NODE_DISTANCE = 0.4330127;

// The directional factor A of a scattering coat, whose BSDF is A(wo) A(wi) / pi: its diffuse albedo by the angle,
// over the root of the albedo's mean. So the albedo is right for each angle, and only the share of light from
// one angle to another is that of a surface without a memory of angles. The material has three values of
// it between the least cosine that leaves the coat and 1, without the transmittance of the boundary.
vec3 scattering_coat(Material material, float cos_o) {
    float eta2 = material.coat_eta * material.coat_eta;
    float cos_in;
    float reflectance = fresnel_dielectric(cos_o, material.coat_eta, cos_in);
    float least = sqrt(max(1.0 - 1.0 / eta2, 0.0));
    float x = ((cos_in - least) / (1.0 - least) - 0.5) / NODE_DISTANCE;
    vec3 value = 0.5 * x * ((x - 1.0) * material.eta + (x + 1.0) * material.second) + (1.0 - x * x) * material.k;
    return (1.0 - reflectance) * max(value, 0.0);
}

// Share of the light that arrives at a visible point: the transmittance of its coat, or 1. Light that meets a
// scattering coat takes scattering_factor besides.
float transmittance_to_base(Material material, float cos_i) {
    if (HAS_SCATTERING_COATS) {
        if ((material.flags & SCATTERING_COAT) != 0u) {
            return 1.0;
        }
    }
    if (HAS_COATS) {
        return material.coat_eta > 0.0 ? coat_transmittance(material, min(cos_i, 1.0)) : 1.0;
    }
    return 1.0;
}

// Light from a direction, times the factor of a scattering coat for it.
vec3 scattering_factor(Material material, float cos_i, vec3 light) {
    if (HAS_SCATTERING_COATS) {
        if ((material.flags & SCATTERING_COAT) != 0u) {
            return light * scattering_coat(material, min(cos_i, 1.0));
        }
    }
    return light;
}

// Draws true with a probability. u, uniform in [0, 1), is uniform again afterwards.
bool draw_bernoulli(float probability, inout float u) {
    bool first = u < probability;
    u = clamp(first ? u / probability : (u - probability) / (1.0 - probability), 0.0, 0.99999994);
    return first;
}

// Least probability of the coat's lobe, and of the base: with less, few paths would find the highlights
// of a rough coat.
const float MIN_COAT_PROBABILITY = 0.1;

Material choose_coat_or_base(Material material, float cos_o, inout float u) {
    float cos_t;
    float reflectance = fresnel_dielectric(cos_o, material.coat_eta, cos_t);
    float probability = clamp(reflectance, MIN_COAT_PROBABILITY, 1.0 - MIN_COAT_PROBABILITY);
    if (draw_bernoulli(probability, u)) {
        material.color = vec3(1.0 / probability);
        material.alpha_u = material.coat_alpha_u;
        material.alpha_v = material.coat_alpha_v;
        material.kind = COAT;
    } else if (material.kind == COATED_DIFFUSE) {
        if (HAS_SCATTERING_COATS) {
            if ((material.flags & SCATTERING_COAT) != 0u) {
                material.color = scattering_coat(material, cos_o) / (1.0 - probability);
                material.kind = DIFFUSE;
                return material;
            }
        }
        vec3 sent_back = material.coat_sent_back * material.color;
        float leaving = coat_transmittance(material, cos_o) / (material.coat_eta * material.coat_eta);
        material.color *= leaving / ((1.0 - probability) * (1.0 - sent_back));
        material.kind = DIFFUSE;
    } else {
        material.color = vec3(1.0 / (1.0 - probability));
    }
    return material;
}

// Chooses a lobe of a material. Returns a material of that lobe alone, with its color divided by the
// probability of the choice. u is uniform again afterwards.
Material choose_lobe(Material material, float cos_o, inout float u) {
    if (HAS_COATS && (material.kind == COATED_DIFFUSE || material.kind == COATED_CONDUCTOR)) {
        return choose_coat_or_base(material, min(cos_o, 1.0), u);
    }
    if (HAS_DIFFUSE_TRANSMISSION && material.kind == DIFFUSE_TRANSMISSION) {
        float reflected = max(material.color.x, max(material.color.y, material.color.z));
        float transmitted = max(material.second.x, max(material.second.y, material.second.z));
        float probability = clamp(reflected / max(reflected + transmitted, 1.0e-20), 0.0, 1.0);
        material.kind = DIFFUSE;
        if (draw_bernoulli(probability, u)) {
            material.color /= max(probability, 1.0e-20);
        } else {
            material.color = material.second / (1.0 - probability);
            material.flags |= BEHIND;
        }
    }
    return material;
}
