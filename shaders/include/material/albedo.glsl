// The albedo of a surface: the part of the light from any direction that it sends on, seen along wo.
//
// In closed form where the surface is smooth. A rough metal or coat has the Fresnel reflectance of a smooth one, and
// light under a coat leaves as if the coat absorbed nothing.
#include "material/bsdf.glsl"
#include "material/fresnel.glsl"
#include "material/layers.glsl"
#include "scene/features.glsl"
#include "scene/materials.glsl"

// Of a coat at the reflectance of its boundary, over a base of which it sends `base` on where nothing is above it.
vec3 coated_albedo(Material material, float cos_o, vec3 base) {
    float cos_t;
    float reflectance = fresnel_dielectric(cos_o, material.coat_eta, cos_t);
    vec3 leaving = base * (1.0 - material.coat_sent_back) / (1.0 - material.coat_sent_back * base);
    return reflectance + coat_transmittance(material, cos_o) * leaving;
}

// Of a coat that scatters light inside: the integral over wi of A(wo) A(wi) cos / pi, by Gauss's rule over the square
// of the cosine.
vec3 scattering_albedo(Material material, float cos_o) {
    float cos_t;
    float reflectance = fresnel_dielectric(cos_o, material.coat_eta, cos_t);
    vec3 mean = 5.0 / 18.0 * (scattering_coat(material, 0.3357106) + scattering_coat(material, 0.9419650))
              + 8.0 / 18.0 * scattering_coat(material, 0.7071068);
    return reflectance + scattering_coat(material, cos_o) * mean;
}

// The albedo of a material; cos_o is the cosine of wo and the shading normal, of any sign. Glass sends all on, less
// what its colour takes.
vec3 albedo_of(Material material, float cos_o) {
    cos_o = min(abs(cos_o), 1.0);
    float cos_t;
    if (HAS_CONDUCTORS && material.kind == CONDUCTOR) {
        return fresnel_conductor(cos_o, material.eta, material.k);
    }
    if (HAS_DIELECTRICS && material.kind == DIELECTRIC) {
        float reflectance = fresnel_dielectric(cos_o, material.eta.x, cos_t);
        return reflectance + (1.0 - reflectance) * material.color;
    }
    if (HAS_THIN && material.kind == THIN_DIELECTRIC) {
        return vec3(1.0);
    }
    if (HAS_SCATTERING_COATS) {
        if ((material.flags & SCATTERING_COAT) != 0u) {
            return scattering_albedo(material, cos_o);
        }
    }
    if (HAS_COATS && material.kind == COATED_DIFFUSE) {
        return coated_albedo(material, cos_o, material.color);
    }
    if (HAS_COATS && material.kind == COATED_CONDUCTOR) {
        fresnel_dielectric(cos_o, material.coat_eta, cos_t); // for the angle under the coat
        return coated_albedo(material, cos_o, fresnel_conductor(cos_t, material.eta, material.k));
    }
    if (HAS_DIFFUSE_TRANSMISSION && material.kind == DIFFUSE_TRANSMISSION) {
        return material.color + material.second;
    }
    return material.color;
}
