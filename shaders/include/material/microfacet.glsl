// Rough surfaces: microfacets of the distribution GGX. Directions are in a frame with z along
// the normal; wo is above. Walter and others 2007; Heitz, "Understanding the Masking-Shadowing
// Function", JCGT 2014.
#include "math/sampling.glsl"
#include "scene/features.glsl"

struct Frame {
    vec3 s; // along the tangent
    vec3 t;
    vec3 n;
};

// A frame about n, turned to the tangent where directions differ.
Frame frame_about(vec3 n, vec3 tangent) {
    Frame frame;
    frame.n = n;
    make_frame(n, frame.s, frame.t);
    if (HAS_ANISOTROPIC) {
        vec3 along = tangent - dot(tangent, n) * n;
        float length2 = dot(along, along);
        if (length2 > 0.0) {
            along *= inversesqrt(length2);
            // Twice is enough, however near the normal the tangent was.
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

// Density of facets with normal m, per area of the surface and solid angle.
float facet_density(vec3 m, vec2 alpha) {
    vec3 stretched = vec3(m.xy / alpha, m.z);
    float d = dot(stretched, stretched);
    return 1.0 / (PI * alpha.x * alpha.y * d * d);
}

// Smith's measure of how much facets hide each other from a direction: 0 is not at all.
float facet_hiding(vec3 w, vec2 alpha) {
    vec2 slope = alpha * w.xy / max(abs(w.z), 1.0e-6);
    return 0.5 * (sqrt(1.0 + dot(slope, slope)) - 1.0);
}

// A facet's normal with pdf proportional to what wo sees of it (Dupuy and Benyoub, "Sampling
// Visible GGX Normals with Spherical Caps", 2023).
vec3 sample_facet(vec3 wo, vec2 alpha, vec2 u) {
    vec3 stretched = normalize(vec3(alpha * wo.xy, wo.z));
    float phi = 2.0 * PI * u.x;
    float z = (1.0 - u.y) * (1.0 + stretched.z) - stretched.z;
    float sin_theta = sqrt(clamp(1.0 - z * z, 0.0, 1.0));
    vec3 m = vec3(sin_theta * cos(phi), sin_theta * sin(phi), z) + stretched;
    // Grazing, the two may cancel.
    return normalize(vec3(alpha * m.xy, max(m.z, 1.0e-6)));
}

// Of those facets that wo sees: the part that wi sees, too.
float facets_seen(vec3 wo, vec3 wi, vec2 alpha) {
    float hidden = facet_hiding(wo, alpha);
    return (1.0 + hidden) / (1.0 + hidden + facet_hiding(wi, alpha));
}

// What a surface does with light from a direction.
struct Response {
    vec3 value; // bsdf * |cos|
    float pdf;  // of sampling this direction, by solid angle
};

// Of facets that reflect all light; m is the facet that does.
Response facets_reflect(vec3 wo, vec3 wi, vec2 alpha, out vec3 m) {
    m = normalize(wo + wi);
    float hidden = facet_hiding(wo, alpha);
    float density = facet_density(m, alpha) / (4.0 * wo.z);
    return Response(vec3(density / (1.0 + hidden + facet_hiding(wi, alpha))), density / (1.0 + hidden));
}

// Of facets that let all flux through to wi, below; eta: that side over this one.
Response facets_transmit(vec3 wo, vec3 wi, vec2 alpha, float eta, out vec3 m) {
    m = normalize(wo + eta * wi);
    m = m.z < 0.0 ? -m : m;
    float cos_o = dot(wo, m);
    float cos_i = dot(wi, m);
    if (cos_o <= 0.0 || cos_i >= 0.0) {
        return Response(vec3(0.0), 0.0);
    }
    float hidden = facet_hiding(wo, alpha);
    float d = cos_i + cos_o / eta;
    float density = facet_density(m, alpha) * cos_o * -cos_i / (d * d * wo.z);
    return Response(vec3(density / (1.0 + hidden + facet_hiding(wi, alpha))), density / (1.0 + hidden));
}
