// Intersects rays with bodies of revolution by the classical method: a baseline for measurements.
//
// A ray meets a profile (u, v) = (radius, height) of degree n where the polynomial
//     F(t) = dz^2 u^2 - |(v - oz) d.xy + dz o.xy|^2
// of degree 2n vanishes. The height is eliminated by k = (v - oz) / dz; the host expands u^2 and v^2.
// Newton's method finds a root, synthetic division removes it, and so on. The iterations start where the
// ray's line meets piecewise linear approximations of the profile: its chords and its tangents.
//
// The method misses roots, and is kept to show how many. In fp32, F is a small difference of large squares;
// the quotient of a division has the errors of the roots before; a start may converge to another root or
// to none; and a horizontal ray has no height to eliminate. Renders use revolution.glsl.
#include "geometry/contact.glsl"
#include "geometry/hit.glsl"
#include "geometry/quadric.glsl"
#include "kernel/invocation.glsl"
#include "scene/features.glsl"
#include "scene/primitives.glsl"
#include "scene/revolutions.glsl"
#include "scene/scene.glsl"

// Largest number of steps of Newton's method.
const int NEWTON_STEPS = 16;
// The iteration ends at a step shorter than this, in t. A hundredth of this is below the rounding noise of F
// and would miss a hundred times as many roots; ten times this would make roots less exact.
const float NEWTON_TOLERANCE = 1.0e-4;
// Rays in a scene begin at this t: with roots of this accuracy, a ray that began at 0 would meet the surface
// that it leaves. From 0, twenty times as many paths are lost in glass; at ten times this, thin walls are
// missed.
const float NEWTON_BEGIN = 3.0e-4;

// Coefficients by powers of t.
struct Polynomial {
    float c[NEWTON_COEFFICIENTS];
};

// The highest degree of F of any segment, known at compile time: twice the degree of a profile, of which
// each pair has two powers.
int newton_degree() {
    uint pairs = REVOLUTION_PAIRS;
    return min(4 * int(pairs) - 2, int(NEWTON_COEFFICIENTS) - 1);
}

// The polynomial F of a segment and a ray.
Polynomial expand(uint segment, vec3 o, vec3 d) {
    float a = dot(d.xy, d.xy);
    float b = dot(d.xy, o.xy);
    vec3 factors = vec3(d.z * d.z, -a, 2.0 * (a * o.z - b * d.z));
    Polynomial f;
    [[unroll]] for (int i = newton_degree(); i >= 0; i--) {
        f.c[i] = dot(factors, revolution_segments.data[segment].powers[i].xyw);
    }
    vec2 w = d.z * o.xy - o.z * d.xy;
    f.c[0] -= dot(w, w);
    return f;
}

// Moves t to a root. Returns false if Newton's method does not converge.
bool find_root(Polynomial f, inout float t) {
    for (int n = 0; n < NEWTON_STEPS; n++) {
        float value = 0.0;
        float derivative = 0.0;
        [[unroll]] for (int i = newton_degree(); i >= 0; i--) {
            derivative = fma(derivative, t, value);
            value = fma(value, t, f.c[i]);
        }
        float change = value / derivative;
        t -= change;
        if (abs(change) <= NEWTON_TOLERANCE) {
            return true;
        }
    }
    return false;
}

// Divides by (t - root) and drops the remainder.
void deflate(inout Polynomial f, float root) {
    float quotient = 0.0;
    [[unroll]] for (int i = newton_degree(); i >= 0; i--) {
        float c = f.c[i];
        f.c[i] = quotient;
        quotient = fma(quotient, root, c);
    }
}

// Intersects the ray's line with the cone between two vertices. Returns the t of one of the two roots, or a
// t in no range if there is none.
float meet_cone(NewtonStart begin, NewtonStart end, vec3 o, vec3 d, bool second) {
    vec2 along = end.point - begin.point;
    vec2 w = (begin.point.y - o.z) * d.xy + d.z * o.xy;
    float a = d.z * d.z * along.x * along.x - dot(d.xy, d.xy) * along.y * along.y;
    float b = d.z * d.z * begin.point.x * along.x - dot(w, d.xy) * along.y;
    float c = d.z * d.z * begin.point.x * begin.point.x - dot(w, w);
    float discriminant = b * b - a * c;
    if (discriminant < 0.0) {
        return -1.0;
    }
    // Without cancellation: one root is q / a, the other c / q.
    float root = sqrt(discriminant);
    float q = b < 0.0 ? root - b : -root - b;
    return mix(begin.t, end.t, second ? c / q : q / a);
}

// Finds the next start of a segment. Each cone may give two starts; `number` counts them.
bool next_start(uint segment, vec3 o, vec3 d, inout uint number, out float t) {
    uint first = revolution_segments.data[segment].first_start;
    uint count = 2u * (revolution_segments.data[segment].start_count - 1u);
    for (; number < count; number++) {
        NewtonStart begin = newton_starts.data[first + (number >> 1u)];
        NewtonStart end = newton_starts.data[first + (number >> 1u) + 1u];
        t = meet_cone(begin, end, o, d, (number & 1u) != 0u);
        // No t is in this range between two approximations, where t falls.
        if (t >= begin.t && t <= end.t) {
            number++;
            return true;
        }
    }
    return false;
}

float height_at(uint segment, float t) {
    float height = 0.0;
    [[unroll]] for (int i = newton_degree() / 2; i >= 0; i--) {
        height = fma(height, t, revolution_segments.data[segment].powers[i].w);
    }
    return height;
}

// Returns the piece that contains a point of a segment; x becomes the parameter on it.
uint piece_at(uint segment, float t, out float x) {
    vec2 ends = revolution_segments.data[segment].along;
    float along = mix(ends.x, ends.y, t);
    uint piece = revolution_segments.data[segment].first_piece;
    uint last = piece + revolution_segments.data[segment].piece_count - 1u;
    while (piece < last && revolution_pieces_at(piece).along.y < along) {
        piece++;
    }
    vec2 range = revolution_pieces_at(piece).along;
    // Rounding may make the range of a piece empty.
    x = clamp((2.0 * along - range.x - range.y) / max(range.y - range.x, 1.0e-30), -1.0, 1.0);
    return piece;
}

// Finds the nearest hit with t_min < t < t_max on a segment, as far as the method finds it. `primitive`
// becomes a reference to the piece, x the parameter on it.
bool intersect_segment(uint segment, vec3 o, vec3 d, float t_min, inout float t_max, inout float x,
                       inout uint primitive) {
    if (d.z == 0.0) {
        return false; // no height to eliminate
    }
    Polynomial f = expand(segment, o, d);
    uint roots = revolution_segments.data[segment].degree;
    float nearest = -1.0;
    uint number = 0u;
    float t;
    while (roots > 0u && next_start(segment, o, d, number, t)) {
        if (!find_root(f, t)) {
            continue;
        }
        deflate(f, t);
        roots--;
        float k = (height_at(segment, t) - o.z) / d.z;
        if (t >= 0.0 && t <= 1.0 && k > t_min && k < t_max) {
            t_max = k;
            nearest = t;
        }
    }
    if (nearest < 0.0) {
        return false;
    }
    primitive = REVOLUTION << KIND_SHIFT | piece_at(segment, nearest, x);
    return true;
}

// As intersect_segment, for a ray in the space that contains the body.
bool meet_segment(uint segment, Ray ray, uint instance, inout Hit hit) {
    uint body = revolution_segments.data[segment].body;
    vec3 o = transform_point(revolutions_at(body).unit_from_render, ray.origin);
    vec3 d = transform_vector(revolutions_at(body).unit_from_render, ray.direction);
    bool found = intersect_segment(segment, o, d, NEWTON_BEGIN, hit.t, hit.barycentric.x, hit.primitive);
    hit.instance = found ? instance : hit.instance;
    return found;
}
