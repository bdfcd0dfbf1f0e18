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
// hyperbola's slope is at most about 1 and monotone, so that the derivative of either
// equation over an interval has a simple bound. An interval is halved until it is certain
// to hold no root or just one, which a bracketed Newton then finds. The two domains overlap
// a little: a root at their border is found twice rather than missed.

// |equation| up to this is a root where an interval ends, so that none slips between two
// pieces; a few roundings of coordinates up to 1.
const float REVOLUTION_TOLERANCE = 3.0e-7;
// How far the domains of the two equations reach over their border: in slope, and in x.
const float OVERLAP = 1.0e-3;
const float BORDER = 1.0e-5;
// An interval over which the equation changes by less may hold two roots that touch, or none.
// Where the ray passes the axis closely, that takes short intervals.
const float SMALLEST_CHANGE = 6.0e-7;
const float SMALLEST_INTERVAL = 1.0e-6;
// More are never needed; no ray must hang the device.
const uint MAX_STEPS = 1024u;
const uint MAX_ROUNDS = 24u;
// Newton's method is done when it moves less than this in x: polish() squares the error,
// and is let go no farther than that.
const float CONVERGED = 3.0e-6;
const float MAX_POLISH = 1.0e-3;

struct Profile {
    vec4 ends;       // u, v at x = -1 and at x = 1
    vec4 end_slopes; // u', v' there
    vec4 slopes;     // least and most of u', least and most of v'
    vec2 curvature;  // bounds of |u''| and |v''|
    vec4 c[5];       // coefficients of u and v, two powers of x in each
};

// A point of the profile and its derivative by x.
struct ProfilePoint {
    vec2 p;
    vec2 d;
};

// A ray about its closest approach to a body's centre, in the body's unit space.
struct RevolutionRay {
    uint body;      // index into revolutions
    float size;     // length of the ray's direction before it was made a unit vector
    vec3 p;
    vec3 d;         // of unit length
    float t_offset; // ray parameter of p; another point's is t_offset + k / size
    float a;        // |d.xy|^2
    float b;        // p.xy . d.xy
    float moment;   // |p.xy x d.xy|
};

Profile load_profile(uint piece) {
    Profile profile;
    profile.ends = revolution_pieces_at(piece).ends;
    profile.end_slopes = revolution_pieces_at(piece).end_slopes;
    profile.slopes = revolution_pieces_at(piece).slopes;
    profile.curvature = revolution_pieces_at(piece).curvature;
    [[unroll]] for (uint i = 0u; i < REVOLUTION_PAIRS; i++) {
        profile.c[i] = revolution_pieces_at(piece).coefficients[i];
    }
    return profile;
}

ProfilePoint evaluate(Profile profile, float x) {
    vec2 p = vec2(0.0);
    vec2 d = vec2(0.0);
    [[unroll]] for (uint i = 0u; i < REVOLUTION_PAIRS; i++) {
        vec4 pair = profile.c[REVOLUTION_PAIRS - (i + 1u)];
        d = fma(d, vec2(x), p);
        p = fma(p, vec2(x), pair.zw);
        d = fma(d, vec2(x), p);
        p = fma(p, vec2(x), pair.xy);
    }
    // Neighbours share their end points to the bit.
    p = x == -1.0 ? profile.ends.xy : x == 1.0 ? profile.ends.zw : p;
    return ProfilePoint(p, d);
}

ProfilePoint first_point(Profile profile) {
    return ProfilePoint(profile.ends.xy, profile.end_slopes.xy);
}

ProfilePoint last_point(Profile profile) {
    return ProfilePoint(profile.ends.zw, profile.end_slopes.zw);
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

// Which equation: A, or one of the branches of B, in order of k.
const int SIDE_A = 0;
const int SIDE_B_NEAR = -1;
const int SIDE_B_FAR = 1;

Equation equation(RevolutionRay ray, int side, vec2 profile) {
    Equation e;
    float h = profile.y - ray.p.z;
    if (side == SIDE_A) {
        e.k = h / ray.d.z;
        vec2 q = fma(vec2(e.k), ray.d.xy, ray.p.xy);
        float rho = length(q);
        e.value = profile.x - rho;
        e.slope = rho > 0.0 ? dot(q, ray.d.xy) / (rho * ray.d.z) : 0.0;
    } else {
        float reach = sqrt(ray.a) * profile.x;
        float along = float(side) * sqrt(max(0.0, (reach - ray.moment) * (reach + ray.moment)));
        e.k = (along - ray.b) / ray.a;
        e.value = h - ray.d.z * e.k;
        e.slope = along != 0.0 ? ray.d.z * profile.x / along : float(side) * sign(ray.d.z) * 1.0e20;
    }
    return e;
}

// d value / dx: A is u - rho(v), B is v - z(u).
float equation_derivative(int side, vec2 d, float slope) {
    return side == SIDE_A ? d.x - slope * d.y : d.y - slope * d.x;
}

// Bounds of the derivative between two points, from their own derivatives, the bound of
// the curvature and the monotone slope.
vec2 derivative_bounds(Profile profile, int side, vec2 d0, vec2 d1, float slope0, float slope1, float width) {
    vec2 bend = 0.5 * width * profile.curvature;
    vec2 lower = max(profile.slopes.xz, min(d0, d1) - bend);
    vec2 upper = min(profile.slopes.yw, max(d0, d1) + bend);
    if (side != SIDE_A) {
        lower = lower.yx;
        upper = upper.yx;
    }
    vec4 products = vec4(lower.y, lower.y, upper.y, upper.y) * vec4(slope0, slope1, slope0, slope1);
    float least = min(min(products.x, products.y), min(products.z, products.w));
    float most = max(max(products.x, products.y), max(products.z, products.w));
    return vec2(lower.x - most, upper.x - least);
}

// One step of Newton's method in (x, k) on both equations of the surface at once: each then
// has the error of the better conditioned one. Where the ray is all but tangent, a step
// would lead away.
vec2 polish(RevolutionRay ray, ProfilePoint point, float x, float k) {
    vec2 q = fma(vec2(k), ray.d.xy, ray.p.xy);
    float rho = length(q);
    float radial = (rho - point.p.x) * (rho + point.p.x);
    float axial = fma(k, ray.d.z, ray.p.z) - point.p.y;
    vec2 by_k = vec2(2.0 * dot(q, ray.d.xy), ray.d.z);
    vec2 by_x = vec2(-2.0 * point.p.x * point.d.x, -point.d.y);
    float determinant = by_k.x * by_x.y - by_x.x * by_k.y;
    vec2 step = vec2(radial * by_k.y - by_k.x * axial, by_x.x * axial - radial * by_x.y) / determinant;
    return all(lessThan(abs(step), vec2(MAX_POLISH))) ? vec2(x, k) + step : vec2(x, k);
}

// What rounding takes from products a * b, exactly (Dekker 1971), with or without fused
// multiplication and addition.
vec3 product_error(vec3 a, float b, vec3 product) {
    precise vec3 a_big = 4097.0 * a;
    precise vec3 a_high = a_big - (a_big - a);
    precise vec3 a_low = a - a_high;
    precise float b_big = 4097.0 * b;
    precise float b_high = b_big - (b_big - b);
    precise float b_low = b - b_high;
    precise vec3 error = ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low;
    return error;
}

RevolutionRay revolution_ray(uint body, Ray world) {
    vec3 o = transform_point(revolutions_at(body).unit_from_render, world.origin);
    vec3 d = transform_vector(revolutions_at(body).unit_from_render, world.direction);
    RevolutionRay ray;
    ray.body = body;
    ray.size = length(d);
    ray.t_offset = -dot(o, d) / dot(d, d);
    // A far origin must not cost digits: neither the product nor a unit vector's rounding may
    // be multiplied by its distance.
    precise vec3 way = ray.t_offset * d;
    precise vec3 p = (o + way) + product_error(d, ray.t_offset, way);
    ray.p = p;
    ray.d = d / ray.size;
    // Squares of less would be nothing.
    ray.d.xy = dot(ray.d.xy, ray.d.xy) < 1.0e-24 ? vec2(0.0) : ray.d.xy;
    ray.a = dot(ray.d.xy, ray.d.xy);
    ray.b = dot(ray.p.xy, ray.d.xy);
    ray.moment = abs(ray.p.x * ray.d.y - ray.p.y * ray.d.x);
    return ray;
}

// Where a ray parameter is, from the closest approach and as a length.
float k_of(RevolutionRay ray, float t) {
    return (t - ray.t_offset) * ray.size;
}

// The radius at which the hyperbola has a slope: it is flatter below, steeper above. A
// ray that is steeper than the slope everywhere is flat in this sense at any radius.
float radius_of_slope(RevolutionRay ray, float slope) {
    float rest = ray.a - slope * slope * ray.d.z * ray.d.z;
    return rest > 0.0 ? ray.moment * inversesqrt(rest) : INFINITY_T;
}

// Whether a ray passes by the ring around a piece: below or above it, outside, or inside.
bool misses_ring(RevolutionRay ray, vec4 ends, float k_min, float k_max) {
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
    if (near > k_max || far < k_min) {
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

// What a ray does on a piece. Lanes of a processor go through it in lockstep: each step is
// one evaluation of the profile, whatever for, so that none waits for another's.
const uint NEXT_SIDE = 0u; // take up the next equation, if the piece is in its domain
const uint CUT = 1u;       // look for the border of its domain
const uint STRETCH = 2u;   // take up what is inside
const uint INTERVAL = 3u;  // judge an interval
const uint ROOT = 4u;      // look for its root
const uint DONE = 5u;

struct Search {
    uint phase;
    int side;
    float limit;           // the radius where the equation's domain ends
    float x;               // where to evaluate next
    float x0;              // the interval
    float x1;
    ProfilePoint point0;
    ProfilePoint point1;
    Equation e0;
    Equation e1;
    float end;             // of the stretch that it is part of
    bool first;            // it begins where that does
    vec2 bracket;          // of the border or root
    bool rising;           // the value is negative at bracket.x
    uint rounds;           // of Newton's method
};

bool inside(vec2 range, float x) {
    return (x - range.x) * (x - range.y) <= 0.0; // false for no number
}

// A step of Newton's method that stays between points whose values have opposite signs.
float newton(inout Search search, float value, float derivative) {
    if ((value > 0.0) == search.rising) {
        search.bracket.y = search.x;
    } else {
        search.bracket.x = search.x;
    }
    float next = search.x - value / derivative;
    return inside(search.bracket, next) ? next : 0.5 * (search.bracket.x + search.bracket.y);
}

// Takes up the next equation in whose domain some of the piece is. Along a ray the near
// branch of B comes before A, and A before the far one.
void next_side(Profile profile, RevolutionRay ray, inout Search search) {
    float least = min(profile.ends.x, profile.ends.z);
    float most = max(profile.ends.x, profile.ends.z);
    float flattest = radius_of_slope(ray, 1.0 + OVERLAP);
    float steepest = radius_of_slope(ray, 1.0 - OVERLAP);
    // A ray that keeps its height has no A.
    bool has_a = ray.d.z != 0.0 && least <= flattest;
    bool has_b = most >= steepest;
    search.side++;
    search.side += search.side == SIDE_B_NEAR && !has_b ? 1 : 0;
    search.side += search.side == SIDE_A && !has_a ? 1 : 0;
    search.side += search.side == SIDE_B_FAR && !has_b ? 1 : 0;
    bool is_a = search.side == SIDE_A;
    search.limit = is_a ? flattest : steepest;
    search.x0 = -1.0;
    search.x1 = 1.0;
    search.point0 = first_point(profile);
    search.point1 = last_point(profile);
    search.rounds = 0u;
    if (search.side > SIDE_B_FAR) {
        search.phase = DONE;
    } else if (is_a ? most > search.limit : least < search.limit) {
        search.phase = CUT;
        search.bracket = vec2(-1.0, 1.0);
        search.rising = profile.ends.z > profile.ends.x;
        search.x = 2.0 * (search.limit - profile.ends.x) / (profile.ends.z - profile.ends.x) - 1.0;
    } else {
        search.phase = STRETCH;
    }
}

// Leaves the part of the piece with radii up to the limit for A, from it on for B, and a
// little more.
void cut(ProfilePoint point, inout Search search) {
    bool upper_end = (search.side == SIDE_A) == search.rising;
    float border = clamp(search.x + (upper_end ? BORDER : -BORDER), -1.0, 1.0);
    // So near, a tangent is the curve.
    point.p += (border - search.x) * point.d;
    if (upper_end) {
        search.x1 = border;
        search.point1 = point;
    } else {
        search.x0 = border;
        search.point0 = point;
    }
    search.phase = STRETCH;
}

// Starts to march over a stretch, the way that k grows: the first root is the nearest.
void begin_stretch(RevolutionRay ray, inout Search search) {
    search.e0 = equation(ray, search.side, search.point0.p);
    search.e1 = equation(ray, search.side, search.point1.p);
    if (search.e0.k > search.e1.k) {
        Equation e = search.e0;
        search.e0 = search.e1;
        search.e1 = e;
        ProfilePoint point = search.point0;
        search.point0 = search.point1;
        search.point1 = point;
        float x = search.x0;
        search.x0 = search.x1;
        search.x1 = x;
    }
    search.end = search.x1;
    search.first = true;
    search.phase = INTERVAL;
}

// Goes on behind an interval that is done with.
void advance(inout Search search) {
    if (search.x1 == search.end) {
        search.phase = NEXT_SIDE;
        return;
    }
    float width = 2.0 * (search.x1 - search.x0);
    search.first = false;
    search.x0 = search.x1;
    search.point0 = search.point1;
    search.e0 = search.e1;
    search.x = abs(search.end - search.x0) < abs(width) + 1.0e-6 ? search.end : search.x0 + width;
    search.phase = INTERVAL;
}

// Decides whether an interval is empty, has one root, or is to be halved.
void judge(Profile profile, RevolutionRay ray, float k_min, float k_max, inout Search search) {
    float f0 = search.e0.value;
    float f1 = search.e1.value;
    float width = abs(search.x1 - search.x0);
    vec2 bounds = derivative_bounds(profile, search.side, search.point0.d, search.point1.d, search.e0.slope,
                                    search.e1.slope, width);
    bool crosses = (f0 > 0.0) != (f1 > 0.0);
    bool monotone = bounds.x > 0.0 || bounds.y < 0.0;
    float reach = max(abs(bounds.x), abs(bounds.y)) * width + REVOLUTION_TOLERANCE;
    // Inside a stretch a root is on one side of a point or the other.
    bool touches0 = search.first && abs(f0) <= REVOLUTION_TOLERANCE;
    bool touches1 = search.x1 == search.end && abs(f1) <= REVOLUTION_TOLERANCE;
    bool touches = touches0 || touches1 || (!monotone && min(abs(f0), abs(f1)) <= REVOLUTION_TOLERANCE);
    bool empty = !crosses && (abs(f0) + abs(f1) > reach || (monotone && !touches));
    // k is this uncertain where A is flat and where B begins.
    float slack = search.side == SIDE_A ? 1.0e-6 / abs(ray.d.z) : 1.0e-3;
    bool elsewhere = search.e1.k < k_min - slack || search.e0.k > k_max + slack;
    if (empty || elsewhere) {
        advance(search);
    } else if (!monotone && width > SMALLEST_INTERVAL && reach > SMALLEST_CHANGE) {
        search.x = 0.5 * (search.x0 + search.x1);
    } else if (crosses || touches) {
        search.phase = ROOT;
        search.rounds = 0u;
        search.rising = f1 > f0;
        search.bracket = vec2(search.x0, search.x1);
        search.x = search.x0 - f0 * ((search.x1 - search.x0) / (f1 - f0));
        if (!crosses) {
            search.x = abs(f0) < abs(f1) ? search.x0 : search.x1;
            search.bracket = vec2(search.x);
        }
    } else {
        advance(search);
    }
}

// The nearest hit with t_min < t < t_max on a piece; hit_x is where on its profile.
bool intersect_revolution(uint piece, RevolutionRay ray, float t_min, inout float t_max, inout float hit_x) {
    float k_min = k_of(ray, t_min);
    float k_max = k_of(ray, t_max);
    if (misses_ring(ray, revolution_pieces_at(piece).ends, k_min, k_max)) {
        return false;
    }
    Profile profile = load_profile(piece);
    Search search;
    search.phase = NEXT_SIDE;
    search.side = SIDE_B_NEAR - 1;
    for (uint i = 0u; i < MAX_STEPS; i++) {
        if (search.phase == NEXT_SIDE) {
            next_side(profile, ray, search);
        }
        if (search.phase == STRETCH) {
            begin_stretch(ray, search);
            judge(profile, ray, k_min, k_max, search);
        }
        if (search.phase == DONE) {
            break;
        }
        if (search.phase == NEXT_SIDE) {
            continue;
        }
        ProfilePoint point = evaluate(profile, search.x);
        Equation e = equation(ray, search.side, point.p);
        if (search.phase == INTERVAL) {
            search.x1 = search.x;
            search.point1 = point;
            search.e1 = e;
            judge(profile, ray, k_min, k_max, search);
            continue;
        }
        bool is_cut = search.phase == CUT;
        float value = is_cut ? point.p.x - search.limit : e.value;
        float next = newton(search, value, is_cut ? point.d.x : equation_derivative(search.side, point.d, e.slope));
        search.rounds++;
        bool converged = abs(next - search.x) < (is_cut ? 0.1 * BORDER : CONVERGED) || search.rounds >= MAX_ROUNDS;
        if (!converged) {
            search.x = next;
        } else if (is_cut) {
            cut(point, search);
        } else {
            vec2 root = polish(ray, point, search.x, e.k);
            float t = ray.t_offset + root.y / ray.size;
            if (t > t_min && t < t_max) {
                t_max = t;
                hit_x = root.x;
                return true;
            }
            advance(search);
        }
    }
    return false;
}
