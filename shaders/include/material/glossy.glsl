// What rough surfaces do with light from a given direction: bsdf.glsl samples the same.
#include "material/bsdf.glsl"
#include "material/fresnel.glsl"
#include "material/microfacet.glsl"
#include "scene/features.glsl"
#include "scene/materials.glsl"

Response respond_conductor(Material material, vec3 wo, vec3 wi) {
    vec3 m;
    Response response = facets_reflect(wo, wi, alpha_of(material), m);
    response.value *= fresnel_conductor(dot(wo, m), material.eta, material.k);
    return response;
}

Response respond_dielectric(Material material, vec3 wo, vec3 wi, float eta, bool carries) {
    vec3 m;
    float cos_t;
    if (wi.z > 0.0) {
        Response response = facets_reflect(wo, wi, alpha_of(material), m);
        float reflectance = fresnel_dielectric(min(dot(wo, m), 1.0), eta, cos_t);
        return Response(response.value * reflectance, response.pdf * reflectance);
    }
    Response response = facets_transmit(wo, wi, alpha_of(material), eta, m);
    float transmittance = 1.0 - fresnel_dielectric(clamp(dot(wo, m), 0.0, 1.0), eta, cos_t);
    float compression = carries == RADIANCE ? 1.0 / (eta * eta) : 1.0;
    return Response(response.value * material.color * (transmittance * compression), response.pdf * transmittance);
}

Response respond_coat(Material material, vec3 wo, vec3 wi) {
    vec3 m;
    float cos_t;
    Response response = facets_reflect(wo, wi, alpha_of(material), m);
    response.value *= material.color * fresnel_dielectric(min(dot(wo, m), 1.0), material.coat_eta, cos_t);
    return response;
}

// A direction inside a coat, and what part of light gets there.
vec3 into_coat(Material material, vec3 w, out float kept) {
    float cos_in;
    float reflectance = fresnel_dielectric(min(w.z, 1.0), material.coat_eta, cos_in);
    kept = (1.0 - reflectance) * exp(-material.coat_thickness / max(cos_in, 1.0e-6));
    return normalize(vec3(w.xy / material.coat_eta, max(cos_in, 1.0e-6)));
}

Response respond_coated_conductor(Material material, vec3 wo, vec3 wi) {
    float kept_o, kept_i;
    vec3 inside_o = into_coat(material, wo, kept_o);
    vec3 inside_i = into_coat(material, wi, kept_i);
    Response response = respond_conductor(material, inside_o, inside_i);
    float cos_m = sqrt(0.5 + 0.5 * clamp(dot(inside_o, inside_i), -1.0, 1.0));
    vec3 metal = fresnel_conductor(cos_m, material.eta, material.k);
    // Solid angles shrink on the way in.
    float shrink = wi.z / (material.coat_eta * material.coat_eta * inside_i.z);
    vec3 again = material.color / (1.0 - material.coat_sent_back * metal);
    return Response(response.value * again * (kept_o * kept_i * shrink), response.pdf * shrink);
}

// bsdf * |cos| of a rough lobe, and the pdf with which scatter_specular finds wi.
Response respond(Material material, vec3 wo, vec3 wi, vec3 n, vec3 tangent, bool carries) {
    bool outside = dot(wo, n) > 0.0;
    Frame frame = frame_about(outside ? n : -n, tangent);
    vec3 local_o = to_frame(frame, wo);
    vec3 local_i = to_frame(frame, wi);
    Response response = Response(vec3(0.0), 0.0);
    if (local_o.z <= 0.0 || local_i.z == 0.0) {
        return response;
    }
    if (HAS_DIELECTRICS && material.kind == DIELECTRIC) {
        float eta = outside ? material.eta.x : 1.0 / material.eta.x;
        return respond_dielectric(material, local_o, local_i, eta, carries);
    }
    if (local_i.z < 0.0) {
        return response;
    }
    if (HAS_CONDUCTORS && material.kind == CONDUCTOR) {
        response = respond_conductor(material, local_o, local_i);
    }
    if (HAS_COATS && material.kind == COAT) {
        response = respond_coat(material, local_o, local_i);
    }
    if (HAS_COATS && material.kind == COATED_CONDUCTOR) {
        response = respond_coated_conductor(material, local_o, local_i);
    }
    return response;
}
