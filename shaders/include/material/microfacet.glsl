// Rough surfaces: microfacets with the GGX distribution (Walter and others 2007) and the Smith
// masking-shadowing function (Heitz, "Understanding the Masking-Shadowing Function", JCGT 2014).
// Directions are in a frame with z along the normal; wo.z > 0.
#include "math/circle.glsl"
#include "math/sampling.glsl"
#include "scene/features.glsl"

struct Frame {
    vec3 s; // along the tangent
    vec3 t;
    vec3 n;
};

// A frame about n. Where roughness is anisotropic, s is along the tangent.
Frame frame_about(vec3 n, vec3 tangent) {
    Frame frame;
    frame.n = n;
    make_frame(n, frame.s, frame.t);
    if (HAS_ANISOTROPIC) {
        vec3 along = tangent - dot(tangent, n) * n;
        float length2 = dot(along, along);
        if (length2 > 0.0) {
            along *= inversesqrt(length2);
            // The second projection mends the rounding of the first, even of a tangent near the normal.
            frame.s = normalize(along - dot(along, n) * n);
            frame.t = cross(n, frame.s);
        }
    }
    return frame;
}

vec3 to_frame(Frame frame, vec3 v) {
    return vec3(dot(v, frame.s), dot(v, frame.t), dot(v, frame.n));
}

vec3 from_frame(Frame frame, vec3 v) {
    return v.x * frame.s + v.y * frame.t + v.z * frame.n;
}

// GGX distribution D(m): area of the microfacets with normal m per area of the surface and solid angle,
// 1/sr.
float ggx_density(vec3 m, vec2 alpha) {
    vec3 stretched = vec3(m.xy / alpha, m.z);
    float d = dot(stretched, stretched);
    return 1.0 / (PI * alpha.x * alpha.y * d * d);
}

// Smith's auxiliary function Lambda(w), 0 or more; masking G1(w) is 1 / (1 + Lambda(w)).
float smith_lambda(vec3 w, vec2 alpha) {
    vec2 slope = alpha * w.xy / max(abs(w.z), 1.0e-6);
    return 0.5 * (sqrt(1.0 + dot(slope, slope)) - 1.0);
}

// Samples a microfacet normal with pdf proportional to its area that is visible from wo (Dupuy and
// Benyoub, "Sampling Visible GGX Normals with Spherical Caps", 2023).
vec3 sample_visible_normal(vec3 wo, vec2 alpha, vec2 u) {
    vec3 stretched = normalize(vec3(alpha * wo.xy, wo.z));
    float phi = 2.0 * PI * u.x;
    float z = (1.0 - u.y) * (1.0 + stretched.z) - stretched.z;
    float sin_theta = sqrt(clamp(1.0 - z * z, 0.0, 1.0));
    vec3 m = vec3(sin_theta * circle_point(phi), z) + stretched;
    // At grazing angles the two terms may cancel.
    return normalize(vec3(alpha * m.xy, max(m.z, 1.0e-6)));
}

// Height-correlated Smith masking-shadowing over masking, G2(wo, wi) / G1(wo).
float smith_g2_over_g1(vec3 wo, vec3 wi, vec2 alpha) {
    float lambda_o = smith_lambda(wo, alpha);
    return (1.0 + lambda_o) / (1.0 + lambda_o + smith_lambda(wi, alpha));
}

// The BSDF for one pair of directions.
struct BsdfValue {
    vec3 value; // BSDF times |cos| of wi, 1/sr
    float pdf;  // of sampling wi, by solid angle, 1/sr
};

// Reflection by microfacets of reflectance 1; m is the normal of those that reflect wo to wi.
BsdfValue evaluate_reflection(vec3 wo, vec3 wi, vec2 alpha, out vec3 m) {
    m = normalize(wo + wi);
    float lambda_o = smith_lambda(wo, alpha);
    float density = ggx_density(m, alpha) / (4.0 * wo.z);
    return BsdfValue(vec3(density / (1.0 + lambda_o + smith_lambda(wi, alpha))), density / (1.0 + lambda_o));
}

// Transmission by microfacets of transmittance 1, to wi with wi.z < 0. eta: index of that side over the
// index of wo's side. m is the normal of the microfacets that refract wo to wi.
BsdfValue evaluate_transmission(vec3 wo, vec3 wi, vec2 alpha, float eta, out vec3 m) {
    m = normalize(wo + eta * wi);
    m = m.z < 0.0 ? -m : m;
    float cos_o = dot(wo, m);
    float cos_i = dot(wi, m);
    if (cos_o <= 0.0 || cos_i >= 0.0) {
        return BsdfValue(vec3(0.0), 0.0);
    }
    float lambda_o = smith_lambda(wo, alpha);
    float d = cos_i + cos_o / eta;
    float density = ggx_density(m, alpha) * cos_o * -cos_i / (d * d * wo.z);
    return BsdfValue(vec3(density / (1.0 + lambda_o + smith_lambda(wi, alpha))), density / (1.0 + lambda_o));
}
