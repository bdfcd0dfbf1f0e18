// Rays against bodies of revolution: every root of a piece, none lost in fp32.
//
// A piece is a stretch of the profile (u, v) = (radius, height), polynomial in x in
// [-1, 1], on which radius and height are monotone. A ray sweeps a hyperbola in the same
// half plane. Where the hyperbola is flat it is a function of height, and the piece meets
// it where
//     A:  u(x) = rho(v(x)),           rho(h) the ray's distance from the axis;
// where it is steep, each of its branches is a function of radius, and the piece meets it
// where
//     B:  v(x) = z(u(x)),             z(r) the ray's height at that distance.
// Written so, no difference of large squares is ever formed, and in either case the
// hyperbola's slope is bounded by 2 and monotone, so that the derivative of either
// equation over an interval has a simple bound. An interval is then halved until it is
// certain to hold no root or just one, which a bracketed Newton finds. The two domains
// overlap (slope 1/2 to 2): a root at their border is found twice rather than missed.

// |equation| up to this is a root where an interval ends, so that none slips between two
// pieces; a few roundings of coordinates up to 1.
const float REVOLUTION_TOLERANCE = 3.0e-7;
// How far the domains of the two equations reach over their border, in x.
const float BORDER = 1.0e-5;
// An interval this short that may still hold roots holds two that touch, or none.
const float SMALLEST_INTERVAL = 1.0 / 4096.0;
// More are never needed; no ray must hang the device.
const uint MAX_INTERVALS = 128u;

struct Profile {
    vec4 ends;      // u, v at x = -1 and at x = 1
    vec4 slopes;    // least and most of u', least and most of v'
    vec2 curvature; // bounds of |u''| and |v''|
    vec4 c[5];      // coefficients of u and v, two powers of x in each
};

// The ray about its closest approach to the body's centre, in the body's unit space.
struct RevolutionRay {
    vec3 p;
    vec3 d;
    float k_offset; // ray parameter of p
    float a;        // |d.xy|^2
    float b;        // p.xy . d.xy
    float moment;   // |p.xy x d.xy|
};

Profile load_profile(uint piece) {
    Profile profile;
    profile.ends = revolution_pieces.data[piece].ends;
    profile.slopes = revolution_pieces.data[piece].slopes;
    profile.curvature = revolution_pieces.data[piece].curvature;
    for (uint i = 0u; 2u * i <= REVOLUTION_DEGREE; i++) {
        profile.c[i] = revolution_pieces.data[piece].coefficients[i];
    }
    return profile;
}

// A point of the profile and its derivative by x.
struct ProfilePoint {
    vec2 p;
    vec2 d;
};

ProfilePoint evaluate(Profile profile, float x) {
    vec2 p = vec2(0.0);
    vec2 d = vec2(0.0);
    for (uint i = REVOLUTION_DEGREE; i < 9u; i--) {
        vec4 pair = profile.c[i >> 1u];
        d = fma(d, vec2(x), p);
        p = fma(p, vec2(x), (i & 1u) == 0u ? pair.xy : pair.zw);
    }
    // Neighbours share their end points to the bit.
    p = x <= -1.0 ? profile.ends.xy : x >= 1.0 ? profile.ends.zw : p;
    return ProfilePoint(p, d);
}

// The way the profile runs at a point: by its derivative, or where that vanishes (a cusp, a
// repeated control point) by its chord.
vec2 profile_direction(Profile profile, ProfilePoint point) {
    vec2 chord = profile.ends.zw - profile.ends.xy;
    return dot(point.d, point.d) > 1.0e-10 * dot(chord, chord) ? point.d : chord;
}

// One of the equations at a point of the profile.
struct Equation {
    float value;
    float slope; // of the hyperbola
    float k;     // ray parameter
};

// side: 0 for A, -1 and +1 for the near and far branch of B.
Equation equation(RevolutionRay ray, float side, vec2 profile) {
    Equation e;
    float h = profile.y - ray.p.z;
    if (side == 0.0) {
        e.k = h / ray.d.z;
        vec2 q = fma(vec2(e.k), ray.d.xy, ray.p.xy);
        float rho = length(q);
        e.value = profile.x - rho;
        e.slope = rho > 0.0 ? dot(q, ray.d.xy) / (rho * ray.d.z) : 0.0;
        return e;
    }
    float root_a = sqrt(ray.a);
    float along = sqrt(max(0.0, (root_a * profile.x - ray.moment) * (root_a * profile.x + ray.moment)));
    e.k = (side * along - ray.b) / ray.a;
    e.value = h - ray.d.z * e.k;
    e.slope = along > 0.0 ? side * ray.d.z * profile.x / along : side * sign(ray.d.z) * 1.0e20;
    return e;
}

// d value / dx: A is u - rho(v), B is v - z(u).
float equation_derivative(float side, vec2 d, float slope) {
    return side == 0.0 ? d.x - slope * d.y : d.y - slope * d.x;
}

// Bounds of the derivative between two points, from their own derivatives, the bound of
// the curvature and the monotone slope.
vec2 derivative_bounds(Profile profile, float side, vec2 d0, vec2 d1, float slope0, float slope1, float width) {
    vec2 bend = 0.5 * width * profile.curvature;
    vec2 lower = max(profile.slopes.xz, min(d0, d1) - bend);
    vec2 upper = min(profile.slopes.yw, max(d0, d1) + bend);
    if (side != 0.0) {
        lower = lower.yx;
        upper = upper.yx;
    }
    vec4 products = vec4(lower.y, lower.y, upper.y, upper.y) * vec4(slope0, slope1, slope0, slope1);
    float least = min(min(products.x, products.y), min(products.z, products.w));
    float most = max(max(products.x, products.y), max(products.z, products.w));
    return vec2(lower.x - most, upper.x - least);
}

// The root in [x0, x1], whose ends have values of opposite sign.
float bracketed_newton(Profile profile, RevolutionRay ray, float side, float x0, float x1, float f0, float f1) {
    float x = x0 - f0 * ((x1 - x0) / (f1 - f0));
    bool rising = f1 > f0;
    for (int i = 0; i < 20; i++) {
        x = x > x0 && x < x1 ? x : 0.5 * (x0 + x1);
        ProfilePoint point = evaluate(profile, x);
        Equation e = equation(ray, side, point.p);
        if ((e.value > 0.0) == rising) {
            x1 = x;
        } else {
            x0 = x;
        }
        float next = x - e.value / equation_derivative(side, point.d, e.slope);
        if (abs(next - x) < 1.0e-7) {
            break;
        }
        x = next;
    }
    return clamp(x, x0, x1);
}

// One step of Newton's method in (x, k) on both equations of the surface at once: the
// parameter k then has the error of the better conditioned one.
float polish(RevolutionRay ray, ProfilePoint point, float k) {
    vec2 q = fma(vec2(k), ray.d.xy, ray.p.xy);
    float rho = length(q);
    float radial = (rho - point.p.x) * (rho + point.p.x);
    float axial = fma(k, ray.d.z, ray.p.z) - point.p.y;
    vec2 by_k = vec2(2.0 * dot(q, ray.d.xy), ray.d.z);
    vec2 by_x = vec2(-2.0 * point.p.x * point.d.x, -point.d.y);
    float determinant = by_k.x * by_x.y - by_x.x * by_k.y;
    float step = (by_x.x * axial - radial * by_x.y) / determinant;
    return abs(step) < 1.0e-5 ? k + step : k;
}

// Marches over [x, end], halving what is not certain, and keeps the nearest root.
bool solve_side(Profile profile, RevolutionRay ray, float side, float x, float end, float t_min, inout float t_max,
                inout float hit_x) {
    bool found = false;
    ProfilePoint point0 = evaluate(profile, x);
    Equation e0 = equation(ray, side, point0.p);
    float width = end - x;
    for (uint i = 0u; i < MAX_INTERVALS && x < end; i++) {
        float x1 = end - x - width < 1.0e-6 ? end : x + width;
        ProfilePoint point1 = evaluate(profile, x1);
        Equation e1 = equation(ray, side, point1.p);
        vec2 bounds = derivative_bounds(profile, side, point0.d, point1.d, e0.slope, e1.slope, x1 - x);
        bool crosses = (e0.value > 0.0) != (e1.value > 0.0);
        bool monotone = bounds.x > 0.0 || bounds.y < 0.0;
        float reach = max(abs(bounds.x), abs(bounds.y)) * (x1 - x) + REVOLUTION_TOLERANCE;
        bool touches = min(abs(e0.value), abs(e1.value)) <= REVOLUTION_TOLERANCE;
        bool empty = !crosses && (abs(e0.value) + abs(e1.value) > reach || (monotone && !touches));
        if (!empty && !monotone && x1 - x > SMALLEST_INTERVAL) {
            width *= 0.5;
            continue;
        }
        if (crosses || (touches && !empty)) {
            float root = abs(e0.value) < abs(e1.value) ? x : x1;
            if (crosses) {
                root = bracketed_newton(profile, ray, side, x, x1, e0.value, e1.value);
            }
            ProfilePoint point = evaluate(profile, root);
            float t = polish(ray, point, equation(ray, side, point.p).k) + ray.k_offset;
            if (t > t_min && t < t_max) {
                t_max = t;
                hit_x = root;
                found = true;
            }
        }
        x = x1;
        point0 = point1;
        e0 = e1;
        width = min(2.0 * width, end - x);
    }
    return found;
}

// Where the piece's monotone radius passes a value.
float radius_at(Profile profile, float radius) {
    bool rising = profile.ends.z > profile.ends.x;
    float x0 = -1.0;
    float x1 = 1.0;
    for (int i = 0; i < 20; i++) {
        float x = 0.5 * (x0 + x1);
        if ((evaluate(profile, x).p.x < radius) == rising) {
            x0 = x;
        } else {
            x1 = x;
        }
    }
    return 0.5 * (x0 + x1);
}

RevolutionRay revolution_ray(vec3 o, vec3 d) {
    RevolutionRay ray;
    ray.k_offset = -dot(o, d);
    ray.p = fma(vec3(ray.k_offset), d, o);
    ray.d = d;
    ray.a = dot(d.xy, d.xy);
    ray.b = dot(ray.p.xy, d.xy);
    ray.moment = abs(ray.p.x * d.y - ray.p.y * d.x);
    return ray;
}

// The radius at which the hyperbola has a slope: it is flatter below, steeper above. A
// ray that is steeper than the slope everywhere is flat in this sense at any radius.
float radius_of_slope(RevolutionRay ray, float slope) {
    float rest = ray.a - slope * slope * ray.d.z * ray.d.z;
    return rest > 0.0 ? ray.moment * inversesqrt(rest) : INFINITY_T;
}

// Whether a ray passes by the ring around a piece: below or above it, outside, or inside.
bool misses_ring(RevolutionRay ray, vec4 ends, float t_min, float t_max) {
    float least = min(ends.x, ends.z);
    float most = max(ends.x, ends.z);
    if (most * most * ray.a * (1.0 + 1.0e-5) < ray.moment * ray.moment) {
        return true;
    }
    // Rounding moves the slab's faces by less than this; in its plane, k is no number and no
    // comparison holds.
    const float slack = 1.0e-6;
    float k0 = (min(ends.y, ends.w) - slack - ray.p.z) / ray.d.z;
    float k1 = (max(ends.y, ends.w) + slack - ray.p.z) / ray.d.z;
    float near = min(k0, k1);
    float far = max(k0, k1);
    if (near + ray.k_offset > t_max || far + ray.k_offset < t_min) {
        return true;
    }
    // The distance from the axis is convex in k.
    float closest = clamp(-ray.b / ray.a, near, far);
    float base = dot(ray.p.xy, ray.p.xy);
    vec3 k = vec3(near, far, closest);
    vec3 rho2 = fma(k, fma(vec3(ray.a), k, vec3(2.0 * ray.b)), vec3(base));
    return max(rho2.x, rho2.y) < (1.0 - 1.0e-5) * least * least - 1.0e-6
        || rho2.z > (1.0 + 1.0e-5) * most * most + 1.0e-6;
}

// The nearest hit with t_min < t < t_max on a piece; x is where on its profile.
bool intersect_revolution(uint piece, vec3 o, vec3 d, float t_min, inout float t_max, inout float x) {
    float size = length(d);
    RevolutionRay ray = revolution_ray(o, d / size);
    if (misses_ring(ray, revolution_pieces.data[piece].ends, t_min * size, t_max * size)) {
        return false;
    }
    Profile profile = load_profile(piece);
    float least = min(profile.ends.x, profile.ends.z);
    float most = max(profile.ends.x, profile.ends.z);
    bool rising = profile.ends.z > profile.ends.x;
    float steep = radius_of_slope(ray, 0.5);
    float flattest = ray.d.z == 0.0 ? -1.0 : radius_of_slope(ray, 2.0);
    bool found = false;
    float t = t_max * size;
    for (int i = 0; i < 3; i++) {
        // A up to one radius; the near and the far branch of B from another one on.
        bool flat_part = i == 1;
        float limit = flat_part ? flattest : steep;
        bool some = flat_part ? least <= limit : most >= limit;
        bool whole = flat_part ? most <= limit : least >= limit;
        if (some) {
            float begin = -1.0;
            float end = 1.0;
            if (!whole) {
                float border = radius_at(profile, limit);
                if (flat_part == rising) {
                    end = min(1.0, border + BORDER);
                } else {
                    begin = max(-1.0, border - BORDER);
                }
            }
            found = solve_side(profile, ray, float(i - 1), begin, end, t_min * size, t, x) || found;
        }
    }
    t_max = found ? t / size : t_max;
    return found;
}
