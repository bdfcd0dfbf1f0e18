// How surfaces scatter. Directions wo and wi point away from the surface.

// What a path carries from the eye or from a light: radiance is compressed where it
// enters glass, flux is not (Veach 1997, section 5.2).
const bool RADIANCE = true;
const bool FLUX = false;

struct Scatter {
    vec3 wi;
    vec3 weight;      // bsdf * |cos| / pdf
    float eta;        // refractive index of the medium ahead over that behind; 1 if not crossed
};

// Whether a path is in glass, by the product of the indices it has passed. Bodies share
// surfaces (wine in a glass): sides of surfaces alone could not tell. Less than 1 is the way
// out of where the path began.
bool is_in_glass(float index) {
    return index > 1.001;
}

// Reflectance of a dielectric boundary for unpolarised light. eta: the far side over
// the near side; cos_i >= 0. Also gives the cosine of the refracted ray.
float fresnel_dielectric(float cos_i, float eta, out float cos_t) {
    float sin2_t = (1.0 - cos_i * cos_i) / (eta * eta);
    if (sin2_t >= 1.0) {
        cos_t = 0.0;
        return 1.0;
    }
    cos_t = sqrt(1.0 - sin2_t);
    float parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    float perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    return 0.5 * (parallel * parallel + perpendicular * perpendicular);
}

// Reflectance of a metal with index eta + i k, per channel (Lazanyi and Szirmay-Kalos
// 2005 compare it with approximations; this is the exact form).
vec3 fresnel_conductor(float cos_i, vec3 eta, vec3 k) {
    float cos2 = cos_i * cos_i;
    float sin2 = 1.0 - cos2;
    vec3 t0 = eta * eta - k * k - sin2;
    vec3 a2_plus_b2 = sqrt(t0 * t0 + 4.0 * eta * eta * k * k);
    vec3 a = sqrt(max(vec3(0.0), 0.5 * (a2_plus_b2 + t0)));
    vec3 t1 = a2_plus_b2 + cos2;
    vec3 t2 = 2.0 * cos_i * a;
    vec3 perpendicular = (t1 - t2) / (t1 + t2);
    vec3 t3 = cos2 * a2_plus_b2 + sin2 * sin2;
    vec3 t4 = t2 * sin2;
    vec3 parallel = perpendicular * (t3 - t4) / (t3 + t4);
    return 0.5 * (perpendicular + parallel);
}

bool is_specular(Material material) {
    return HAS_SPECULAR && material.kind != DIFFUSE;
}

Scatter scatter_dielectric(Material material, vec3 wo, vec3 n, float u, bool carries) {
    float cos_o = dot(wo, n);
    bool outside = cos_o > 0.0;
    vec3 facing = outside ? n : -n;
    float eta = outside ? material.eta.x : 1.0 / material.eta.x;
    float cos_t;
    float reflectance = fresnel_dielectric(abs(cos_o), eta, cos_t);
    if (u < reflectance) {
        return Scatter(2.0 * abs(cos_o) * facing - wo, vec3(1.0), 1.0);
    }
    vec3 wi = normalize((abs(cos_o) * facing - wo) / eta - cos_t * facing);
    float compression = carries == RADIANCE ? 1.0 / (eta * eta) : 1.0;
    return Scatter(wi, material.color * compression, eta);
}

Scatter scatter_conductor(Material material, vec3 wo, vec3 n) {
    vec3 facing = dot(wo, n) < 0.0 ? -n : n;
    float cos_o = dot(wo, facing);
    return Scatter(2.0 * cos_o * facing - wo, fresnel_conductor(cos_o, material.eta, material.k), 1.0);
}

// A direction from a surface without a diffuse lobe; the other is chosen by u.
Scatter scatter_specular(Material material, vec3 wo, vec3 n, float u, bool carries) {
    Scatter scattered = Scatter(wo, vec3(0.0), 1.0);
    if (HAS_DIELECTRICS && material.kind == DIELECTRIC) {
        scattered = scatter_dielectric(material, wo, n, u, carries);
    }
    if (HAS_CONDUCTORS && material.kind == CONDUCTOR) {
        scattered = scatter_conductor(material, wo, n);
    }
    return scattered;
}

// A direction from the surface's bsdf; the lobe is chosen by u_lobe.
Scatter scatter(Material material, vec3 wo, vec3 n, float u_lobe, vec2 u, bool carries) {
    if (is_specular(material)) {
        return scatter_specular(material, wo, n, u_lobe, carries);
    }
    vec3 facing = dot(wo, n) < 0.0 ? -n : n;
    return Scatter(sample_cosine(u, facing), material.color, 1.0);
}
