// How far glass has spread the wavelengths of a path: the derivatives of the path by its wavelength.
//
// They follow the path as ray differentials do (Igehy, "Tracing Ray Differentials", 1999), for planes: the curvature of
// a surface is left out. They decide over how many wavelengths the color of a path is averaged, and nothing else. The
// radius within which this blurs the image shrinks as the gather radius does, so an error changes how fast colors
// sharpen, and not the limit.
#include "spectrum/wavelength.glsl"

// Changes per unit of wavelength, for the middle wavelength: all wavelengths that take a way find the same window, without
// which the mean over wavelengths would not be white.
struct Spread {
    vec3 position;  // of the path's last vertex, on the surface there, render units
    vec3 direction; // of its next segment
    vec3 middle;    // direction of the next segment of the middle wavelength, once `direction` is not zero
};

Spread no_spread() {
    return Spread(vec3(0.0), vec3(0.0), vec3(0.0));
}

// Direction of the middle wavelength where the path has direction d.
vec3 middle_direction(Spread spread, vec3 d) {
    return spread.middle == vec3(0.0) ? d : spread.middle;
}

// Least |cos| of a ray at a surface: at a grazing angle all wavelengths meet the surface far apart.
const float LEAST_COSINE = 0.05;

// Goes on along a segment of unit direction d to a surface with normal n.
void move_spread(inout Spread spread, vec3 d, float t, vec3 n) {
    float own = dot(d, n);
    d = middle_direction(spread, d);
    float cosine = dot(d, n);
    cosine = cosine < 0.0 ? min(cosine, -LEAST_COSINE) : max(cosine, LEAST_COSINE);
    spread.position += t * clamp(own / cosine, 0.5, 2.0) * spread.direction;
    spread.position -= d * (dot(spread.position, n) / cosine);
}

// Goes on from wo to wi at a smooth surface or at a microfacet. eta: index of the medium that the path enters over the
// one it leaves, 1 if it stays. `middle`: that of the middle wavelength; `slope`: its derivative by the wavelength.
void bend_spread(inout Spread spread, vec3 wo, vec3 wi, float eta, float middle, float slope) {
    vec3 sum = wo + eta * wi;
    float size2 = dot(sum, sum);
    if (size2 < 1.0e-8) {
        return; // the path goes straight on
    }
    if (slope == 0.0 && spread.direction == vec3(0.0)) {
        spread.middle = vec3(0.0);
        return;
    }
    vec3 m = sum * inversesqrt(size2);
    wo = -middle_direction(spread, -wo);
    if (eta == 1.0) {
        spread.direction -= 2.0 * dot(spread.direction, m) * m;
        spread.middle = 2.0 * dot(wo, m) * m - wo;
        return;
    }
    m = dot(m, wo) < 0.0 ? -m : m;
    // Snell's law, wi = (cos_i / eta - cos_t) m - wo / eta, and its derivative.
    float cos_i = dot(wo, m);
    float inverse = 1.0 / middle;
    float cos_t = max(sqrt(max(1.0 - inverse * inverse * (1.0 - cos_i * cos_i), 0.0)), LEAST_COSINE);
    float change = -slope * inverse * inverse; // of 1 / eta
    float change_i = -dot(spread.direction, m); // of cos_i
    float change_t = (inverse * inverse * cos_i * change_i - inverse * change * (1.0 - cos_i * cos_i)) / cos_t;
    spread.direction = -change * wo + inverse * spread.direction + (change * cos_i + inverse * change_i - change_t) * m;
    spread.middle = normalize((cos_i * inverse - cos_t) * m - inverse * wo);
}

// What a segment of a path begins with, and the radius that the image blurs there.
struct Split {
    Hue hue;
    Spread spread;
    float radius; // render units
};

Split no_split() {
    return Split(no_hue(), no_spread(), 0.0);
}

// The window over which the color of a path is averaged, where the image blurs places within `radius`, in render units.
float window_of(Spread spread, float radius) {
    return clamp(radius / max(length(spread.position), 1.0e-20), 0.0, 1.0);
}

// The hue at length t of a segment.
Hue hue_along(Split split, float t) {
    Hue hue = split.hue;
    hue.window = window_of(Spread(split.spread.position + t * split.spread.direction, vec3(0.0), vec3(0.0)), split.radius);
    return hue;
}
