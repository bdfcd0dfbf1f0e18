// Evaluates the BSDFs of rough surfaces, for directions in a frame with z along the normal on the side
// of wo. bsdf.glsl samples the same BSDFs. `transport` is RADIANCE or FLUX.
#include "material/bsdf.glsl"
#include "material/fresnel.glsl"
#include "material/measured.glsl"
#include "material/microfacet.glsl"
#include "scene/features.glsl"
#include "scene/materials.glsl"

BsdfValue evaluate_conductor(Material material, vec3 wo, vec3 wi) {
    vec3 m;
    BsdfValue bsdf = evaluate_reflection(wo, wi, alpha_of(material), m);
    bsdf.value *= fresnel_conductor(dot(wo, m), material.eta, material.k);
    return bsdf;
}

BsdfValue evaluate_dielectric(Material material, vec3 wo, vec3 wi, float eta, bool transport) {
    vec3 m;
    float cos_t;
    if (wi.z > 0.0) {
        BsdfValue bsdf = evaluate_reflection(wo, wi, alpha_of(material), m);
        float reflectance = fresnel_dielectric(min(dot(wo, m), 1.0), eta, cos_t);
        return BsdfValue(bsdf.value * reflectance, bsdf.pdf * reflectance);
    }
    BsdfValue bsdf = evaluate_transmission(wo, wi, alpha_of(material), eta, m);
    float transmittance = 1.0 - fresnel_dielectric(clamp(dot(wo, m), 0.0, 1.0), eta, cos_t);
    float compression = transport == RADIANCE ? 1.0 / (eta * eta) : 1.0;
    return BsdfValue(bsdf.value * material.color * (transmittance * compression), bsdf.pdf * transmittance);
}

BsdfValue evaluate_coat(Material material, vec3 wo, vec3 wi) {
    vec3 m;
    float cos_t;
    BsdfValue bsdf = evaluate_reflection(wo, wi, alpha_of(material), m);
    bsdf.value *= material.color * fresnel_dielectric(min(dot(wo, m), 1.0), material.coat_eta, cos_t);
    return bsdf;
}

// Refracts a direction into a coat. `kept` is the share of light that crosses the boundary and the coat.
vec3 refract_into_coat(Material material, vec3 w, out float kept) {
    float cos_in;
    float reflectance = fresnel_dielectric(min(w.z, 1.0), material.coat_eta, cos_in);
    kept = (1.0 - reflectance) * exp(-material.coat_thickness / max(cos_in, 1.0e-6));
    return normalize(vec3(w.xy / material.coat_eta, max(cos_in, 1.0e-6)));
}

BsdfValue evaluate_coated_conductor(Material material, vec3 wo, vec3 wi) {
    float kept_o, kept_i;
    vec3 inside_o = refract_into_coat(material, wo, kept_o);
    vec3 inside_i = refract_into_coat(material, wi, kept_i);
    BsdfValue bsdf = evaluate_conductor(material, inside_o, inside_i);
    float cos_m = sqrt(0.5 + 0.5 * clamp(dot(inside_o, inside_i), -1.0, 1.0));
    vec3 metal = fresnel_conductor(cos_m, material.eta, material.k);
    // Jacobian: refraction into the coat shrinks solid angles.
    float shrink = wi.z / (material.coat_eta * material.coat_eta * inside_i.z);
    vec3 again = material.color / (1.0 - material.coat_sent_back * metal);
    return BsdfValue(bsdf.value * again * (kept_o * kept_i * shrink), bsdf.pdf * shrink);
}

// Evaluates a rough lobe: BSDF times |cos|, and the pdf with which scatter_specular samples wi.
BsdfValue evaluate_bsdf(Material material, vec3 wo, vec3 wi, vec3 n, vec3 tangent, bool transport) {
    bool outside = dot(wo, n) > 0.0;
    Frame frame = frame_about(outside ? n : -n, tangent);
    vec3 local_o = to_frame(frame, wo);
    vec3 local_i = to_frame(frame, wi);
    BsdfValue bsdf = BsdfValue(vec3(0.0), 0.0);
    if (local_o.z <= 0.0 || local_i.z == 0.0) {
        return bsdf;
    }
    if (HAS_DIELECTRICS && material.kind == DIELECTRIC) {
        float eta = relative_eta(material, outside);
        return evaluate_dielectric(material, local_o, local_i, eta, transport);
    }
    if (local_i.z < 0.0) {
        return bsdf;
    }
    if (HAS_CONDUCTORS && material.kind == CONDUCTOR) {
        bsdf = evaluate_conductor(material, local_o, local_i);
    }
    if (HAS_COATS && material.kind == COAT) {
        bsdf = evaluate_coat(material, local_o, local_i);
    }
    if (HAS_COATS && material.kind == COATED_CONDUCTOR) {
        bsdf = evaluate_coated_conductor(material, local_o, local_i);
    }
    if (HAS_MEASURED && material.kind == MEASURED) {
        vec3 signs = signs_of_side(outside);
        bsdf = evaluate_measured(material.first, signs * local_o, signs * local_i);
    }
    return bsdf;
}
