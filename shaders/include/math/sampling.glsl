// Samples points and directions by numbers u, uniform in [0, 1).
#include "math/circle.glsl"

const float PI = 3.14159265358979;

// Completes a unit vector n to a right-handed orthonormal basis (s, t, n) (Duff and others, "Building an
// Orthonormal Basis, Revisited", JCGT 2017).
void make_frame(vec3 n, out vec3 s, out vec3 t) {
    float sign = n.z >= 0.0 ? 1.0 : -1.0;
    float a = -1.0 / (sign + n.z);
    float b = n.x * n.y * a;
    s = vec3(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x);
    t = vec3(b, sign + n.y * n.y * a, -n.y);
}

// Transforms a vector from a frame with z along n.
vec3 to_world(vec3 local, vec3 n) {
    vec3 s, t;
    make_frame(n, s, t);
    return local.x * s + local.y * t + local.z * n;
}

// A point on the unit disk, uniform by area, by the concentric map (Shirley and Chiu 1997).
vec2 sample_disk(vec2 u) {
    vec2 offset = 2.0 * u - 1.0;
    if (offset.x == 0.0 && offset.y == 0.0) {
        return vec2(0.0);
    }
    bool wide = abs(offset.x) > abs(offset.y);
    float radius = wide ? offset.x : offset.y;
    float angle = wide ? 0.25 * PI * (offset.y / offset.x) : 0.5 * PI - 0.25 * PI * (offset.x / offset.y);
    return radius * circle_point(angle);
}

// A direction about n with pdf cos / pi.
vec3 sample_cosine(vec2 u, vec3 n) {
    vec2 disk = sample_disk(u);
    float z = sqrt(max(0.0, 1.0 - dot(disk, disk)));
    return to_world(vec3(disk, z), n);
}

// A direction, uniform on the cap z >= z_min of the unit sphere. The argument is 1 - z_min, which keeps
// its digits for small caps; it is 2 for the whole sphere.
vec3 sample_cap(vec2 u, float one_minus_z_min) {
    float one_minus_z = u.x * one_minus_z_min;
    float sin_theta = sqrt(max(0.0, one_minus_z * (2.0 - one_minus_z)));
    float phi = 2.0 * PI * u.y;
    return vec3(sin_theta * circle_point(phi), 1.0 - one_minus_z);
}

// Barycentric coordinates of p1 and p2, uniform on a triangle, by folding the unit square
// (Heitz, "A Low-Distortion Map Between Triangle and Square", 2019).
vec2 sample_triangle(vec2 u) {
    return u.x < u.y ? vec2(0.5 * u.x, u.y - 0.5 * u.x) : vec2(u.x - 0.5 * u.y, 0.5 * u.y);
}
