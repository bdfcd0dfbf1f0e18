// How far glass has spread the wavelengths of a path: the derivatives of the path by its wavelength.
//
// They follow the path as ray differentials do (Igehy, "Tracing Ray Differentials", 1999), for planes: the curvature of
// a surface is left out. They decide over how many wavelengths the color of a path is averaged, and nothing else. The
// radius within which this blurs the image shrinks as the gather radius does, so an error changes how fast colors
// sharpen, and not the limit.
#include "spectrum/wavelength.glsl"

// Changes per unit of wavelength.
struct Spread {
    vec3 position;  // of the path's last vertex, on the surface there, render units
    vec3 direction; // of its next segment
};

Spread no_spread() {
    return Spread(vec3(0.0), vec3(0.0));
}

// Least |cos| of a ray at a surface: at a grazing angle all wavelengths meet the surface far apart.
const float LEAST_COSINE = 0.05;

// Goes on along a segment of unit direction d to a surface with normal n.
void move_spread(inout Spread spread, vec3 d, float t, vec3 n) {
    spread.position += t * spread.direction;
    float cosine = dot(d, n);
    cosine = cosine < 0.0 ? min(cosine, -LEAST_COSINE) : max(cosine, LEAST_COSINE);
    spread.position -= d * (dot(spread.position, n) / cosine);
}

// Goes on from wo to wi at a smooth surface or at a microfacet. eta: index of the medium that the path enters over the
// one it leaves, 1 if it stays; `slope`: derivative of eta by the wavelength.
void bend_spread(inout Spread spread, vec3 wo, vec3 wi, float eta, float slope) {
    vec3 sum = wo + eta * wi;
    float size2 = dot(sum, sum);
    if (size2 < 1.0e-8) {
        return; // the path goes straight on
    }
    vec3 m = sum * inversesqrt(size2);
    if (eta == 1.0) {
        spread.direction -= 2.0 * dot(spread.direction, m) * m;
        return;
    }
    m = dot(m, wo) < 0.0 ? -m : m;
    // Derivatives of Snell's law, wi = (cos_i / eta - cos_t) m - wo / eta.
    float cos_i = dot(wo, m);
    float cos_t = max(-dot(wi, m), LEAST_COSINE);
    float inverse = 1.0 / eta;
    float change = -slope * inverse * inverse; // of 1 / eta
    float change_i = -dot(spread.direction, m); // of cos_i
    float change_t = (inverse * inverse * cos_i * change_i - inverse * change * (1.0 - cos_i * cos_i)) / cos_t;
    spread.direction = -change * wo + inverse * spread.direction + (change * cos_i + inverse * change_i - change_t) * m;
}

// Width of the window of a color, in gather radii on the surface: with less, colors have more noise than places.
const float COLOR_RADII = 2.0;

// The window over which the color of a path is averaged, where the image blurs places within `radius`, in render units.
float window_of(Spread spread, float radius) {
    return clamp(COLOR_RADII * radius / max(length(spread.position), 1.0e-20), 0.0, 1.0);
}
