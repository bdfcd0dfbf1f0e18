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
#include "geometry/contact.glsl"
#include "kernel/invocation.glsl"
#include "revolution/ray.glsl"
#include "revolution/rings.glsl"
#include "scene/features.glsl"
#include "scene/scene.glsl"

// |equation| up to this is a root where an interval ends, so that none slips between two
// pieces; a few roundings of coordinates up to 1.
const float REVOLUTION_TOLERANCE = 3.0e-7;
// How far the domains of the two equations reach over their border, in x.
const float BORDER = 1.0e-5;
// An interval over which the equation changes by less may hold two roots that touch, or none.
// Where the ray passes the axis closely, that takes short intervals.
const float SMALLEST_CHANGE = 6.0e-7;
const float SMALLEST_INTERVAL = 1.0e-6;
// Rounding moves the ends of pieces by less than this along a ray's height.
const float HEIGHT_SLACK = 1.0e-6;
// More are never needed; no ray must hang the device.
const uint MAX_STEPS = 1024u;
const uint MAX_ROUNDS = 24u;
// Newton's method is done when it moves less than this in x: polish() squares the error,
// and is let go no farther than that.
const float CONVERGED = 3.0e-6;
const float MAX_POLISH = 1.0e-3;

struct Profile {
    vec4 ends;       // u, v at x = -1 and at x = 1
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

// A point between the ends.
ProfilePoint evaluate_inside(Profile profile, float x) {
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

// Neighbours share their end points to the bit.
ProfilePoint evaluate(Profile profile, float x) {
    ProfilePoint point = evaluate_inside(profile, x);
    point.p = x == -1.0 ? profile.ends.xy : x == 1.0 ? profile.ends.zw : point.p;
    return point;
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
const int SIDE_B_NEAR = -1;
const int SIDE_A = 0;
const int SIDE_B_FAR = 1;

// Both are computed as one: lanes of a processor go through either in lockstep.
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

// d value / dx: A is u - rho(v), B is v - z(u).
float equation_derivative(int side, vec2 d, float slope) {
    return side == SIDE_A ? d.x - slope * d.y : d.y - slope * d.x;
}

// The derivative between two points: its middle, and how far from that it may be. That of
// the profile is bounded by those at the points and the second one, the slope is monotone.
// The bound is generous: a tight one would take the noise of a grazing ray for certainty.
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

bool inside(vec2 range, float x) {
    return (x - range.x) * (x - range.y) <= 0.0; // false for no number
}

// A step of Newton's method that stays between points whose values have opposite signs.
float newton(inout vec2 bracket, bool rising, float x, float value, float derivative) {
    if ((value > 0.0) == rising) {
        bracket.y = x;
    } else {
        bracket.x = x;
    }
    float next = x - value / derivative;
    return inside(bracket, next) ? next : 0.5 * (bracket.x + bracket.y);
}

// Where the radius of a profile is the border's.
float find_border(Profile profile, float border) {
    vec2 ends = profile.ends.xz - border;
    float x = 1.0;
    float next = (ends.x + ends.y) / (ends.x - ends.y);
    vec2 bracket = vec2(-1.0, 1.0);
    for (uint i = 0u; i < MAX_ROUNDS && abs(next - x) >= 0.1 * BORDER; i++) {
        x = next;
        ProfilePoint point = evaluate_inside(profile, x);
        next = newton(bracket, ends.y > ends.x, x, point.p.x - border, point.d.x);
    }
    return next;
}

// What a ray looks for: it goes over candidates, pieces that it may meet, and over the
// stretches of each that belong to one of the equations, interval by interval.
struct Search {
    uint piece;
    uint sides;    // those to come of the piece: bit 0 near branch of B, 1 A, 2 far branch
    int side;
    float border;  // between their domains, in x
    float x0;      // the interval
    float x1;
    float end;     // of the stretch that it is part of
    bool first;    // it begins where that does
    vec2 d0;       // derivative of the profile at x0
    Equation e0;
    Equation e1;
};

// The equations in whose domain some of a piece is; of B, the branches that pass through its
// ring.
uint sides_of(RevolutionRay ray, vec4 ends, float k_min, float k_max) {
    float least = min(ends.x, ends.z);
    float most = max(ends.x, ends.z);
    // A ray that keeps its height has no A.
    uint sides = ray.d.z != 0.0 && least <= ray.border ? 2u : 0u;
    // k is this uncertain where B begins.
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

// Takes up the next stretch: of the piece on which the equation holds, in order of k.
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
    ProfilePoint point = evaluate(profile, search.x0);
    search.d0 = point.d;
    search.e0 = equation(ray, search.side, point.p);
    search.x1 = search.end;
}

// What becomes of an interval.
const uint EMPTY = 0u;
const uint HALVE = 1u;
const uint ROOT = 2u;

uint judge(Profile profile, RevolutionRay ray, float k_min, float k_max, Search search, vec2 d1) {
    float f0 = search.e0.value;
    float f1 = search.e1.value;
    float width = abs(search.x1 - search.x0);
    vec2 bounds =
        derivative_bounds(profile, search.side, search.d0, d1, search.e0.slope, search.e1.slope, width);
    bool crosses = (f0 > 0.0) != (f1 > 0.0);
    bool monotone = abs(bounds.x) > bounds.y;
    float reach = (abs(bounds.x) + bounds.y) * width + REVOLUTION_TOLERANCE;
    // Inside a stretch a root is on one side of a point or the other.
    bool touches0 = search.first && abs(f0) <= REVOLUTION_TOLERANCE;
    bool touches1 = search.x1 == search.end && abs(f1) <= REVOLUTION_TOLERANCE;
    bool touches = touches0 || touches1 || (!monotone && min(abs(f0), abs(f1)) <= REVOLUTION_TOLERANCE);
    bool empty = !crosses && (abs(f0) + abs(f1) > reach || (monotone && !touches));
    // k is this uncertain where A is flat and where B begins.
    float slack = search.side == SIDE_A ? 1.0e-6 * abs(ray.inverse) : 1.0e-3;
    bool elsewhere = search.e1.k < k_min - slack || search.e0.k > k_max + slack;
    bool halve = !monotone && width > SMALLEST_INTERVAL && reach > SMALLEST_CHANGE;
    return empty || elsewhere ? EMPTY : halve ? HALVE : crosses || touches ? ROOT : EMPTY;
}

// Goes on behind an interval that is done with.
void advance(inout Search search, vec2 d1) {
    float width = 2.0 * (search.x1 - search.x0);
    search.first = false;
    search.x0 = search.x1;
    search.d0 = d1;
    search.e0 = search.e1;
    search.x1 = abs(search.end - search.x0) < abs(width) + 1.0e-6 ? search.end : search.x0 + width;
}

// The only root between two points; its x and k.
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
        point = evaluate(profile, x);
        e = equation(ray, search.side, point.p);
        next = newton(bracket, f1 > f0, x, e.value, equation_derivative(search.side, point.d, e.slope));
        rounds++;
    } while (abs(next - x) >= CONVERGED && rounds < MAX_ROUNDS);
    return polish(ray, point, x, e.k);
}

// Whether a ray may meet a body at x of its profile, by the order of contact: at parameter t, which is
// k from p.
bool may_meet_contact(Profile profile, RevolutionRay ray, float x, float k, float t) {
    vec2 q = fma(vec2(k), ray.d.xy, ray.p.xy);
    vec2 slope = profile_direction(profile, evaluate(profile, x));
    // Of the direction and the outer normal, times the distance from the axis.
    float cosine = slope.y * dot(q, ray.d.xy) - slope.x * ray.d.z * length(q);
    bool leaves = (cosine > 0.0) == (revolutions_at(ray.body).flipped == 0u);
    bool is_free = ray.whole.begin == 0.0 && ray.whole.otherwise == 0.0; // t_min alone bounds it
    return is_free || may_meet(ray.whole, revolutions_at(ray.body).material, leaves, t);
}

bool may_meet_profile(Profile profile, RevolutionRay ray, float x, float k, float t) {
    if (HAS_CONTACTS) {
        return may_meet_contact(profile, ray, x, k, t);
    }
    return true;
}

// The nearest hit with t_min < t < t_max on some pieces that the ray may meet; with any_hit, some hit. hit_x is where
// on the profile of hit_piece.
bool intersect_pieces(Pieces candidates, RevolutionRay ray, float t_min, bool any_hit,
                      inout float t_max, inout float hit_x, inout uint hit_piece) {
    float k_min = k_of(ray, t_min);
    bool found = false;
    uint steps = 0u;
    Search search;
    Profile profile;
    search.sides = 0u;
    bool fresh = true; // a stretch is to be taken up
    while (!is_empty(candidates) || search.sides != 0u || !fresh) {
        bool has_root = false;
        float k_max = k_of(ray, t_max);
        // Lanes of a processor look on until each has a root to find.
        while (!has_root && (!is_empty(candidates) || search.sides != 0u || !fresh)) {
            if (fresh && search.sides == 0u) {
                search.piece = take_piece(candidates);
                profile = load_profile(search.piece);
                steps = 0u;
                search.sides = sides_of(ray, profile.ends, k_min, k_max);
                vec2 radii = profile.ends.xz - ray.border;
                if (radii.x * radii.y <= 0.0) {
                    search.border = find_border(profile, ray.border);
                }
                if (search.sides == 0u) {
                    continue;
                }
            }
            if (fresh) {
                next_stretch(profile, ray, search);
            }
            ProfilePoint point = evaluate(profile, search.x1);
            search.e1 = equation(ray, search.side, point.p);
            uint verdict = judge(profile, ray, k_min, k_max, search, point.d);
            fresh = false;
            has_root = verdict == ROOT;
            if (verdict == HALVE) {
                search.x1 = 0.5 * (search.x0 + search.x1);
            } else if (verdict == EMPTY) {
                fresh = search.x1 == search.end;
                advance(search, point.d);
            }
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
                // Stretches and intervals come in order of k.
                search.sides = 0u;
                candidates.mask = any_hit ? uvec4(0u) : candidates.mask;
            }
            fresh = hit || search.x1 == search.end;
            vec2 d1 = evaluate(profile, search.x1).d;
            advance(search, d1);
        }
    }
    return found;
}

// The nearest hit with t_min < t < t_max on a piece.
bool intersect_revolution(uint piece, RevolutionRay ray, float t_min, inout float t_max, inout float hit_x) {
    return intersect_pieces(Pieces(piece, uvec4(1u, 0u, 0u, 0u)), ray, t_min, false, t_max, hit_x, piece);
}
