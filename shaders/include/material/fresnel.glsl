// Fresnel reflectances.

// Fresnel reflectance of a dielectric boundary for unpolarised light. eta: index of the far side over
// the near side; cos_i >= 0. cos_t becomes the cosine of the refracted ray, 0 at total reflection.
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

// Added to sums of squares that must not be 0: a metal's index may be 0, or that of the medium around it.
const float LEAST_SQUARE = 1.0e-30;

// Fresnel reflectance of a metal with index eta + i k, per channel, in the exact form. Lazanyi and
// Szirmay-Kalos 2005 compare it with approximations.
vec3 fresnel_conductor(float cos_i, vec3 eta, vec3 k) {
    float cos2 = cos_i * cos_i;
    float sin2 = 1.0 - cos2;
    vec3 t0 = eta * eta - k * k - sin2;
    vec3 a2_plus_b2 = sqrt(t0 * t0 + 4.0 * eta * eta * k * k);
    vec3 a = sqrt(max(vec3(0.0), 0.5 * (a2_plus_b2 + t0)));
    vec3 t1 = a2_plus_b2 + cos2 + LEAST_SQUARE;
    vec3 t2 = 2.0 * cos_i * a;
    vec3 perpendicular = (t1 - t2) / (t1 + t2);
    vec3 t3 = cos2 * a2_plus_b2 + sin2 * sin2 + LEAST_SQUARE;
    vec3 t4 = t2 * sin2;
    vec3 parallel = perpendicular * (t3 - t4) / (t3 + t4);
    return 0.5 * (perpendicular + parallel);
}
