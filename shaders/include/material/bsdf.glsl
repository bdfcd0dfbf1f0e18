// Samples BSDFs. Directions wo and wi point away from the surface.
#include "material/fresnel.glsl"
#include "material/layers.glsl"
#include "material/measured.glsl"
#include "material/microfacet.glsl"
#include "math/sampling.glsl"
#include "scene/features.glsl"
#include "scene/materials.glsl"

// Modes of transport: eye paths carry radiance, photons carry flux. Refraction scales radiance by the
// squared ratio of the indices, and leaves flux as it is (Veach 1997, section 5.2).
const bool RADIANCE = true;
const bool FLUX = false;

struct Scatter {
    vec3 wi;
    vec3 weight;      // BSDF times |cos| over the pdf
    float eta;        // index of the medium that the path enters over the one it leaves; 1 if it stays
};

// Whether a path is in glass. `index` is the product of the ratios of indices that it has crossed, since
// the side of a surface does not tell where bodies share surfaces, such as wine in a glass. A product
// below 1 means that the path has left the dielectric in which it began.
bool is_in_glass(float index) {
    return index > 1.001;
}

// Whether a lobe is not Lambertian: smooth or rough.
bool is_specular(Material material) {
    return HAS_SPECULAR && material.kind != DIFFUSE;
}

// Whether a lobe has microfacets of different normals.
bool is_rough(Material material) {
    return HAS_ROUGH && material.alpha_u > 0.0;
}

vec2 alpha_of(Material material) {
    return vec2(material.alpha_u, material.alpha_v);
}

// Samples the normal of the microfacet that wo meets, on wo's side; the surface's normal if it is smooth.
vec3 sample_microfacet(Material material, vec3 wo, Frame frame, vec2 u) {
    if (HAS_ROUGH) {
        if (is_rough(material)) {
            return from_frame(frame, sample_visible_normal(to_frame(frame, wo), alpha_of(material), u));
        }
    }
    return frame.n;
}

// Masking-shadowing weight G2(wo, wi) / G1(wo) of a direction sampled by the visible normals; 1 on a
// smooth surface. It is 0 if wi is on the wrong side of the surface: reflected into it, or refracted out.
float masking_shadowing_weight(Material material, vec3 wo, vec3 wi, Frame frame, bool same_side) {
    if (HAS_ROUGH) {
        if (is_rough(material)) {
            vec3 local = to_frame(frame, wi);
            return local.z > 0.0 == same_side ? smith_g2_over_g1(to_frame(frame, wo), local, alpha_of(material)) : 0.0;
        }
    }
    return 1.0;
}

// Index of refraction of a dielectric's far side over that of its near side.
float relative_eta(Material material, bool outside) {
    return outside ? material.eta.x : 1.0 / material.eta.x;
}

// In all scatter_* functions frame.n is on wo's side. eta: index of the far side over the near side;
// `transport` is RADIANCE or FLUX.
Scatter scatter_dielectric(Material material, vec3 wo, Frame frame, float eta, float u, vec2 u_facet, bool transport) {
    vec3 m = sample_microfacet(material, wo, frame, u_facet);
    float cos_o = dot(wo, m);
    float cos_t;
    float reflectance = fresnel_dielectric(cos_o, eta, cos_t);
    if (u < reflectance) {
        vec3 wi = 2.0 * cos_o * m - wo;
        return Scatter(wi, vec3(masking_shadowing_weight(material, wo, wi, frame, true)), 1.0);
    }
    vec3 wi = normalize((cos_o * m - wo) / eta - cos_t * m);
    float compression = transport == RADIANCE ? 1.0 / (eta * eta) : 1.0;
    return Scatter(wi, material.color * (compression * masking_shadowing_weight(material, wo, wi, frame, false)), eta);
}

Scatter scatter_conductor(Material material, vec3 wo, Frame frame, vec2 u_facet) {
    vec3 m = sample_microfacet(material, wo, frame, u_facet);
    float cos_o = dot(wo, m);
    vec3 wi = 2.0 * cos_o * m - wo;
    vec3 reflectance = fresnel_conductor(cos_o, material.eta, material.k);
    return Scatter(wi, reflectance * masking_shadowing_weight(material, wo, wi, frame, true), 1.0);
}

// A thin pane of glass: a series of reflections between its two sides, 2 R / (1 + R) in all.
Scatter scatter_thin(Material material, vec3 wo, Frame frame, float u) {
    float cos_o = dot(wo, frame.n);
    float cos_t;
    float once = fresnel_dielectric(min(cos_o, 1.0), material.eta.x, cos_t);
    bool reflects = u < 2.0 * once / (1.0 + once);
    return Scatter(reflects ? 2.0 * cos_o * frame.n - wo : -wo, vec3(1.0), 1.0);
}

Scatter scatter_coat(Material material, vec3 wo, Frame frame, vec2 u_facet) {
    vec3 m = sample_microfacet(material, wo, frame, u_facet);
    float cos_o = dot(wo, m);
    vec3 wi = 2.0 * cos_o * m - wo;
    float cos_t;
    float reflectance = fresnel_dielectric(cos_o, material.coat_eta, cos_t);
    return Scatter(wi, material.color * (reflectance * masking_shadowing_weight(material, wo, wi, frame, true)), 1.0);
}

// Through the coat, off the metal, and back through the coat. Reflections between the coat's underside
// and the metal form a geometric series, taken at the same angles for all of its terms.
Scatter scatter_coated_conductor(Material material, vec3 wo, Frame frame, vec2 u_facet) {
    float cos_o = dot(wo, frame.n);
    float cos_in;
    float reflectance = fresnel_dielectric(min(cos_o, 1.0), material.coat_eta, cos_in);
    vec3 inside = normalize((wo - cos_o * frame.n) / material.coat_eta + cos_in * frame.n);
    Scatter scattered = scatter_conductor(material, inside, frame, u_facet);
    float cos_up = dot(scattered.wi, frame.n);
    float cos_out;
    float back = fresnel_dielectric(clamp(cos_up, 0.0, 1.0), 1.0 / material.coat_eta, cos_out);
    float kept = (1.0 - reflectance) * (1.0 - back)
               * exp(-material.coat_thickness * (1.0 / max(cos_in, 1.0e-6) + 1.0 / max(cos_up, 1.0e-6)));
    float cos_m = sqrt(0.5 + 0.5 * clamp(dot(inside, scattered.wi), -1.0, 1.0));
    vec3 metal = fresnel_conductor(cos_m, material.eta, material.k);
    scattered.weight *= material.color * kept / (1.0 - material.coat_sent_back * metal);
    scattered.wi = normalize((scattered.wi - cos_up * frame.n) * material.coat_eta + cos_out * frame.n);
    return scattered;
}

Scatter scatter_measured(Material material, vec3 wo, Frame frame, bool outside, vec2 u) {
    vec3 weight;
    vec3 signs = signs_of_side(outside);
    vec3 wi = sample_measured(material.first, signs * to_frame(frame, wo), u, weight);
    return Scatter(from_frame(frame, signs * wi), weight, 1.0);
}

// Samples a lobe that is not Lambertian. u chooses between reflection and transmission, u_facet the
// microfacet.
Scatter scatter_specular(Material material, vec3 wo, vec3 n, vec3 tangent, float u, vec2 u_facet, bool transport) {
    Scatter scattered = Scatter(wo, vec3(0.0), 1.0);
    bool outside = dot(wo, n) > 0.0;
    Frame frame;
    frame.n = outside ? n : -n;
    if (HAS_ROUGH) {
        frame = frame_about(frame.n, tangent);
    }
    if (HAS_DIELECTRICS && material.kind == DIELECTRIC) {
        float eta = relative_eta(material, outside);
        scattered = scatter_dielectric(material, wo, frame, eta, u, u_facet, transport);
    }
    if (HAS_CONDUCTORS && material.kind == CONDUCTOR) {
        scattered = scatter_conductor(material, wo, frame, u_facet);
    }
    if (HAS_THIN && material.kind == THIN_DIELECTRIC) {
        scattered = scatter_thin(material, wo, frame, u);
    }
    if (HAS_COATS && material.kind == COAT) {
        scattered = scatter_coat(material, wo, frame, u_facet);
    }
    if (HAS_COATS && material.kind == COATED_CONDUCTOR) {
        scattered = scatter_coated_conductor(material, wo, frame, u_facet);
    }
    if (HAS_MEASURED && material.kind == MEASURED) {
        scattered = scatter_measured(material, wo, frame, outside, u_facet);
    }
    return scattered;
}

// Samples a lobe of a surface. u_lobe chooses between reflection and transmission, u the direction.
Scatter scatter(Material material, vec3 wo, vec3 n, vec3 tangent, float u_lobe, vec2 u, bool transport) {
    if (is_specular(material)) {
        return scatter_specular(material, wo, n, tangent, u_lobe, u, transport);
    }
    vec3 facing = dot(wo, n) < 0.0 ? -n : n;
    if (HAS_DIFFUSE_TRANSMISSION) {
        facing = (material.flags & BEHIND) != 0u ? -facing : facing;
    }
    vec3 wi = sample_cosine(u, facing);
    float cos_i = dot(wi, facing);
    return Scatter(wi, scattering_factor(material, cos_i, material.color * transmittance_to_base(material, cos_i)), 1.0);
}
