// Intersects rays with bodies of revolution: finds every root of a piece in fp32.
//
// A piece is a part of the profile (u, v) = (radius, height) on which both are monotone, as polynomials
// in x in [-1, 1]. Turned about the axis into the half plane of the profile, a ray is a hyperbola. Where
// the hyperbola is flat, it is a function of height, and it meets the piece where
//     A:  u(x) = rho(v(x)),           rho(h): the ray's distance from the axis at height h.
// Where it is steep, each of its two branches is a function of radius, and it meets the piece where
//     B:  v(x) = z(u(x)),             z(r): the ray's height at distance r from the axis.
// In this form no difference of large squares occurs. In both equations the slope of the hyperbola is
// monotone and at most about 1, so that the derivative of the equation over an interval has a simple
// bound. An interval is halved until it certainly holds no root or exactly one root, which a bracketed
// Newton iteration then finds. The domains of A and B overlap a little: a root at their border is found
// twice rather than missed.
#include "geometry/contact.glsl"
#include "kernel/invocation.glsl"
#include "revolution/ray.glsl"
#include "revolution/rings.glsl"
#include "scene/features.glsl"
#include "scene/scene.glsl"

// A value of the equation up to this, at the end of an interval, is a root: no root is lost between two
// pieces. It is a few roundings of coordinates up to 1.
const float REVOLUTION_TOLERANCE = 3.0e-7;
// Overlap of the domains of the two equations, in x.
const float BORDER = 1.0e-5;
// An interval over which the equation changes by less is not halved: it may hold two roots that touch,
// or none. Where the ray passes the axis closely, such intervals are short, but no shorter than the
// second bound.
const float SMALLEST_CHANGE = 6.0e-7;
const float SMALLEST_INTERVAL = 1.0e-6;
// Bound of the rounding error of a piece's end, in height.
const float HEIGHT_SLACK = 1.0e-6;
// Bounds of loops. No ray needs as many steps; they keep the device from hanging.
const uint MAX_STEPS = 1024u;
const uint MAX_ROUNDS = 24u;
// Newton's method stops at a step in x below CONVERGED, since polish() squares the error. A step of
// polish() above MAX_POLISH is left out.
const float CONVERGED = 3.0e-6;
const float MAX_POLISH = 1.0e-3;

struct Profile {
    vec4 ends;       // u, v at x = -1, and at x = 1
    vec2 curvature;  // bounds of |u''| and |v''|
    vec4 c[5];       // coefficients of u and v, two powers of x in each
};

// A point of the profile and its derivative by x.
struct ProfilePoint {
    vec2 p;
    vec2 d;
};


Profile load_profile(uint piece) {
    Profile profile;
    profile.ends = revolution_pieces_at(piece).ends;
    profile.curvature = revolution_pieces_at(piece).curvature;
    [[unroll]] for (uint i = 0u; i < REVOLUTION_PAIRS; i++) {
        profile.c[i] = revolution_pieces_at(piece).coefficients[i];
    }
    return profile;
}

// A point of the profile by its polynomials.
ProfilePoint evaluate_polynomial(Profile profile, float x) {
    vec2 p = vec2(0.0);
    vec2 d = vec2(0.0);
    [[unroll]] for (uint i = 0u; i < REVOLUTION_PAIRS; i++) {
        vec4 pair = profile.c[REVOLUTION_PAIRS - (i + 1u)];
        d = fma(d, vec2(x), p);
        p = fma(p, vec2(x), pair.zw);
        d = fma(d, vec2(x), p);
        p = fma(p, vec2(x), pair.xy);
    }
    return ProfilePoint(p, d);
}

// A point of the profile. Neighbouring pieces share their end points to the bit.
ProfilePoint evaluate_profile(Profile profile, float x) {
    ProfilePoint point = evaluate_polynomial(profile, x);
    point.p = x == -1.0 ? profile.ends.xy : x == 1.0 ? profile.ends.zw : point.p;
    return point;
}

// Direction of the profile at a point: its derivative, or its chord where the derivative vanishes (at
// a cusp or a repeated control point).
vec2 profile_direction(Profile profile, ProfilePoint point) {
    vec2 chord = profile.ends.zw - profile.ends.xy;
    return dot(point.d, point.d) > 1.0e-10 * dot(chord, chord) ? point.d : chord;
}

// An equation, evaluated at a point of the profile.
struct Equation {
    float value;
    float slope; // of the hyperbola
    float k;     // ray parameter of the hyperbola's point
};

// Sides: equation A, or B with the branch before or after the closest approach to the axis.
const int SIDE_B_NEAR = -1;
const int SIDE_A = 0;
const int SIDE_B_FAR = 1;

// Evaluates either equation by one sequence of instructions, since lanes run in lockstep.
Equation equation(RevolutionRay ray, int side, vec2 profile) {
    bool is_a = side == SIDE_A;
    float h = profile.y - ray.p.z;
    float k_a = h / ray.d.z;
    vec2 q = fma(vec2(k_a), ray.d.xy, ray.p.xy);
    float reach = ray.root_a * profile.x;
    float root = sqrt(is_a ? dot(q, q) : max(0.0, (reach - ray.moment) * (reach + ray.moment)));
    float along = float(side) * root;
    float run = is_a ? root * ray.d.z : along;
    float rise = is_a ? dot(q, ray.d.xy) : ray.d.z * profile.x;
    Equation e;
    e.k = is_a ? k_a : (along - ray.b) / ray.a;
    e.value = is_a ? profile.x - root : h - ray.d.z * e.k;
    e.slope = root > 0.0 ? rise / run : float(side) * sign(ray.d.z) * 1.0e20;
    return e;
}

// Derivative of the equation's value by x; A is u - rho(v), B is v - z(u).
float equation_derivative(int side, vec2 d, float slope) {
    return side == SIDE_A ? d.x - slope * d.y : d.y - slope * d.x;
}

// Bounds the derivative of the equation between two points: returns the middle of its range, and half of
// the range's width. The derivative of the profile is bounded by its values at the two points and by
// the second derivative; the slope of the hyperbola is monotone. The bound is wide on purpose: a tight
// one would take the rounding noise of a grazing ray for certainty.
vec2 derivative_bounds(Profile profile, int side, vec2 d0, vec2 d1, float slope0, float slope1, float width) {
    vec2 middle = 0.5 * (d0 + d1);
    vec2 bend = 0.5 * fma(vec2(width), profile.curvature, abs(d1 - d0));
    bool is_a = side == SIDE_A;
    vec2 whole = is_a ? vec2(middle.x, bend.x) : vec2(middle.y, bend.y);
    vec2 part = is_a ? vec2(middle.y, bend.y) : vec2(middle.x, bend.x);
    float slope = 0.5 * (slope0 + slope1);
    float spread = 0.5 * abs(slope0 - slope1);
    return vec2(whole.x - slope * part.x, whole.y + abs(slope) * part.y + spread * (abs(part.x) + part.y));
}

// Takes one step of Newton's method in (x, k) on both equations of the surface at once, so that both
// unknowns have the error of the better conditioned equation. Leaves out a large step, which occurs
// where the ray is almost tangent.
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

bool is_between(vec2 range, float x) {
    return (x - range.x) * (x - range.y) <= 0.0; // false for NaN
}

// One step of Newton's method within a bracket, whose ends have values of opposite signs; bisection where
// the step leaves the bracket.
float newton(inout vec2 bracket, bool rising, float x, float value, float derivative) {
    if ((value > 0.0) == rising) {
        bracket.y = x;
    } else {
        bracket.x = x;
    }
    float next = x - value / derivative;
    return is_between(bracket, next) ? next : 0.5 * (bracket.x + bracket.y);
}

// The x at which the radius of a profile is the border.
float find_border(Profile profile, float border) {
    vec2 ends = profile.ends.xz - border;
    float x = 1.0;
    float next = (ends.x + ends.y) / (ends.x - ends.y);
    vec2 bracket = vec2(-1.0, 1.0);
    for (uint i = 0u; i < MAX_ROUNDS && abs(next - x) >= 0.1 * BORDER; i++) {
        x = next;
        ProfilePoint point = evaluate_polynomial(profile, x);
        next = newton(bracket, ends.y > ends.x, x, point.p.x - border, point.d.x);
    }
    return next;
}

// State of the search for roots. It visits candidate pieces one by one, on each piece the stretches on
// which one of the equations holds, and on each stretch interval by interval.
struct Search {
    uint piece;
    uint sides;    // sides of the piece still to visit: bit 0 near branch of B, 1 A, 2 far branch of B
    int side;      // of the current stretch
    float border;  // x that separates the domains of A and B
    float x0;      // the interval, from x0 to x1
    float x1;
    float end;     // end of the stretch
    bool first;    // the interval begins where the stretch begins
    vec2 d0;       // derivative of the profile at x0
    Equation e0;
    Equation e1;
};

// The sides on which a piece may have roots: equations in whose domain a part of the piece is, and of B
// the branches that pass through the ring of the piece.
uint sides_of(RevolutionRay ray, vec4 ends, float k_min, float k_max) {
    float least = min(ends.x, ends.z);
    float most = max(ends.x, ends.z);
    // A horizontal ray has no equation A.
    uint sides = ray.d.z != 0.0 && least <= ray.border ? 2u : 0u;
    // Uncertainty of k where the domain of B begins.
    const float slack = 1.0e-3;
    vec2 k_ends = (ends.yw - ray.p.z) * ray.inverse;
    float near = max(k_min, min(k_ends.x, k_ends.y) - HEIGHT_SLACK * abs(ray.inverse)) - slack;
    float far = min(k_max, max(k_ends.x, k_ends.y) + HEIGHT_SLACK * abs(ray.inverse)) + slack;
    vec2 reach = ray.root_a * vec2(least, most);
    vec2 along = sqrt(max(vec2(0.0), (reach - ray.moment) * (reach + ray.moment))) * ray.inverse_a;
    bool has_b = most >= ray.border;
    sides |= has_b && ray.closest - along.y <= far && ray.closest - along.x >= near ? 1u : 0u;
    sides |= has_b && ray.closest + along.x <= far && ray.closest + along.y >= near ? 4u : 0u;
    return sides;
}

// Begins the next stretch: the part of the piece on which the next side's equation holds, in order of k.
void next_stretch(Profile profile, RevolutionRay ray, inout Search search) {
    search.side = findLSB(search.sides) - 1;
    search.sides &= search.sides - 1u;
    bool is_a = search.side == SIDE_A;
    vec2 radii = profile.ends.xz;
    bool widens = radii.y > radii.x;
    bool cut = is_a ? max(radii.x, radii.y) > ray.border : min(radii.x, radii.y) < ray.border;
    bool cut_end = is_a == widens;
    float lower = cut && !cut_end ? max(search.border - BORDER, -1.0) : -1.0;
    float upper = cut && cut_end ? min(search.border + BORDER, 1.0) : 1.0;
    bool forward = is_a ? (profile.ends.w > profile.ends.y) == (ray.d.z > 0.0) : widens == (search.side > 0);
    search.x0 = forward ? lower : upper;
    search.end = forward ? upper : lower;
    search.first = true;
    ProfilePoint point = evaluate_profile(profile, search.x0);
    search.d0 = point.d;
    search.e0 = equation(ray, search.side, point.p);
    search.x1 = search.end;
}

// Verdicts on an interval: it has no root, it is to be halved, or it has exactly one root.
const uint EMPTY = 0u;
const uint HALVE = 1u;
const uint ROOT = 2u;

uint classify_interval(Profile profile, RevolutionRay ray, float k_min, float k_max, Search search, vec2 d1) {
    float f0 = search.e0.value;
    float f1 = search.e1.value;
    float width = abs(search.x1 - search.x0);
    vec2 bounds =
        derivative_bounds(profile, search.side, search.d0, d1, search.e0.slope, search.e1.slope, width);
    bool crosses = (f0 > 0.0) != (f1 > 0.0);
    bool monotone = abs(bounds.x) > bounds.y;
    float reach = (abs(bounds.x) + bounds.y) * width + REVOLUTION_TOLERANCE;
    // Within a stretch, a root near a point belongs to the interval before or after that point.
    bool touches0 = search.first && abs(f0) <= REVOLUTION_TOLERANCE;
    bool touches1 = search.x1 == search.end && abs(f1) <= REVOLUTION_TOLERANCE;
    bool touches = touches0 || touches1 || (!monotone && min(abs(f0), abs(f1)) <= REVOLUTION_TOLERANCE);
    bool empty = !crosses && (abs(f0) + abs(f1) > reach || (monotone && !touches));
    // Uncertainty of k where A is flat, and where the domain of B begins.
    float slack = search.side == SIDE_A ? 1.0e-6 * abs(ray.inverse) : 1.0e-3;
    bool elsewhere = search.e1.k < k_min - slack || search.e0.k > k_max + slack;
    bool halve = !monotone && width > SMALLEST_INTERVAL && reach > SMALLEST_CHANGE;
    return empty || elsewhere ? EMPTY : halve ? HALVE : crosses || touches ? ROOT : EMPTY;
}

// Goes on to the interval behind the current one.
void advance(inout Search search, vec2 d1) {
    float width = 2.0 * (search.x1 - search.x0);
    search.first = false;
    search.x0 = search.x1;
    search.d0 = d1;
    search.e0 = search.e1;
    search.x1 = abs(search.end - search.x0) < abs(width) + 1.0e-6 ? search.end : search.x0 + width;
}

// Finds the only root of an interval. Returns its x and k.
vec2 find_root(Profile profile, RevolutionRay ray, Search search) {
    float f0 = search.e0.value;
    float f1 = search.e1.value;
    bool crosses = (f0 > 0.0) != (f1 > 0.0);
    vec2 bracket = vec2(search.x0, search.x1);
    float next = search.x0 - f0 * ((search.x1 - search.x0) / (f1 - f0));
    if (!crosses) {
        next = abs(f0) < abs(f1) ? search.x0 : search.x1;
        bracket = vec2(next);
    }
    float x;
    ProfilePoint point;
    Equation e;
    uint rounds = 0u;
    do {
        x = next;
        point = evaluate_profile(profile, x);
        e = equation(ray, search.side, point.p);
        next = newton(bracket, f1 > f0, x, e.value, equation_derivative(search.side, point.d, e.slope));
        rounds++;
    } while (abs(next - x) >= CONVERGED && rounds < MAX_ROUNDS);
    return polish(ray, point, x, e.k);
}

// Whether a ray may meet a body at x of its profile, by the order of surfaces in contact (contact.glsl).
bool may_meet_profile_in_order(Profile profile, RevolutionRay ray, float x, float k, float t) {
    vec2 q = fma(vec2(k), ray.d.xy, ray.p.xy);
    vec2 slope = profile_direction(profile, evaluate_profile(profile, x));
    // Cosine of the direction with the outer normal, times the distance from the axis.
    float cosine = slope.y * dot(q, ray.d.xy) - slope.x * ray.d.z * length(q);
    bool leaves = (cosine > 0.0) == (revolutions_at(ray.body).flipped == 0u);
    bool is_free = ray.whole.begin == 0.0 && ray.whole.otherwise == 0.0; // no surface is excluded
    return is_free || may_meet(ray.whole, revolutions_at(ray.body).material, leaves, t);
}

bool may_meet_profile(Profile profile, RevolutionRay ray, float x, float k, float t) {
    if (HAS_CONTACTS) {
        return may_meet_profile_in_order(profile, ray, x, k, t);
    }
    return true;
}

// Begins the search on a piece.
void begin_piece(Profile profile, RevolutionRay ray, float k_min, float k_max, inout Search search) {
    search.sides = sides_of(ray, profile.ends, k_min, k_max);
    vec2 radii = profile.ends.xz - ray.border;
    if (radii.x * radii.y <= 0.0) {
        search.border = find_border(profile, ray.border);
    }
}

// Classifies the interval of the search. Halves it, or goes on behind it if it is empty; then `fresh`
// tells whether the stretch is finished. Returns true if the interval holds a root.
bool examine_interval(Profile profile, RevolutionRay ray, float k_min, float k_max, inout Search search,
                      inout bool fresh) {
    ProfilePoint point = evaluate_profile(profile, search.x1);
    search.e1 = equation(ray, search.side, point.p);
    uint verdict = classify_interval(profile, ray, k_min, k_max, search, point.d);
    fresh = false;
    if (verdict == HALVE) {
        search.x1 = 0.5 * (search.x0 + search.x1);
    } else if (verdict == EMPTY) {
        fresh = search.x1 == search.end;
        advance(search, point.d);
    }
    return verdict == ROOT;
}

// Finds the nearest hit with t_min < t < t_max on candidate pieces, or any such hit with any_hit. hit_x
// is the parameter on hit_piece.
bool intersect_pieces(Pieces candidates, RevolutionRay ray, float t_min, bool any_hit,
                      inout float t_max, inout float hit_x, inout uint hit_piece) {
    float k_min = k_of(ray, t_min);
    bool found = false;
    uint steps = 0u;
    Search search;
    Profile profile;
    search.sides = 0u;
    bool fresh = true; // the next stretch is to begin
    while (!is_empty(candidates) || search.sides != 0u || !fresh) {
        bool has_root = false;
        float k_max = k_of(ray, t_max);
        // Each lane searches until it has a root, then all lanes refine their roots together.
        while (!has_root && (!is_empty(candidates) || search.sides != 0u || !fresh)) {
            if (fresh && search.sides == 0u) {
                search.piece = take_piece(candidates);
                profile = load_profile(search.piece);
                steps = 0u;
                begin_piece(profile, ray, k_min, k_max, search);
                if (search.sides == 0u) {
                    continue;
                }
            }
            if (fresh) {
                next_stretch(profile, ray, search);
            }
            has_root = examine_interval(profile, ray, k_min, k_max, search, fresh);
            if (++steps > MAX_STEPS) {
                candidates.mask = uvec4(0u);
                search.sides = 0u;
                fresh = true;
            }
        }
        if (has_root) {
            vec2 root = find_root(profile, ray, search);
            float t = ray.t_offset + root.y / ray.size;
            bool hit = t > t_min && t < t_max && may_meet_profile(profile, ray, root.x, root.y, t);
            if (hit) {
                t_max = t;
                hit_x = root.x;
                hit_piece = search.piece;
                found = true;
                // The rest of the piece is farther: stretches and intervals come in order of k.
                search.sides = 0u;
                candidates.mask = any_hit ? uvec4(0u) : candidates.mask;
            }
            fresh = hit || search.x1 == search.end;
            vec2 d1 = evaluate_profile(profile, search.x1).d;
            advance(search, d1);
        }
    }
    return found;
}

// Finds the nearest hit with t_min < t < t_max on one piece.
bool intersect_revolution(uint piece, RevolutionRay ray, float t_min, inout float t_max, inout float hit_x) {
    return intersect_pieces(Pieces(piece, uvec4(1u, 0u, 0u, 0u)), ray, t_min, false, t_max, hit_x, piece);
}
