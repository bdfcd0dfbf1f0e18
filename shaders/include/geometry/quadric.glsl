// Transforms, and intersections of rays with unit spheres and disks in object space.
#include "geometry/contact.glsl"
#include "scene/features.glsl"
#include "scene/primitives.glsl"

vec3 transform_point(vec4 rows[3], vec3 p) {
    vec4 q = vec4(p, 1.0);
    return vec3(dot(rows[0], q), dot(rows[1], q), dot(rows[2], q));
}

vec3 transform_vector(vec4 rows[3], vec3 v) {
    return vec3(dot(rows[0].xyz, v), dot(rows[1].xyz, v), dot(rows[2].xyz, v));
}

// Transforms a ray to another space. The direction is not normalised, so that t is the same in both.
Ray ray_in(vec4 rows[3], Ray ray) {
    ray.origin = transform_point(rows, ray.origin);
    ray.direction = transform_vector(rows, ray.direction);
    return ray;
}

// Transforms a normal, by the transpose of the inverse transform, whose rows are given. Not normalised.
vec3 transform_normal(vec4 inverse_rows[3], vec3 n) {
    return n.x * inverse_rows[0].xyz + n.y * inverse_rows[1].xyz + n.z * inverse_rows[2].xyz;
}

// Angle about z in [0, 2 pi).
float azimuth(vec2 p) {
    float phi = atan(p.y, p.x);
    return phi < 0.0 ? phi + 6.28318530718 : phi;
}

// Whether a point is on the part of a sphere that z_min, z_max and phi_max leave. Rounding may move a
// point beyond a pole or the seam: there, a sphere without cuts has no hole.
bool is_inside_cuts(Quadric sphere, vec3 p) {
    return (p.z >= sphere.z_min || sphere.z_min <= -1.0) && (p.z <= sphere.z_max || sphere.z_max >= 1.0)
        && (azimuth(p.xy) <= sphere.phi_max || sphere.phi_max >= 6.283185);
}

// Finds the nearest hit with t < t_max on the unit sphere. The quadratic is solved from the point of the
// ray closest to the centre, so that a distant origin costs no digits.
bool intersect_sphere(Quadric sphere, Ray ray, inout float t_max) {
    vec3 o = ray.origin;
    vec3 d = ray.direction;
    float inv_a = 1.0 / dot(d, d);
    float t_closest = -dot(o, d) * inv_a;
    vec3 p = o + t_closest * d;
    float h2 = 1.0 - dot(p, p);
    if (h2 < 0.0) {
        return false;
    }
    float half_chord = sqrt(h2 * inv_a);
    float t0 = t_closest - half_chord;
    float t1 = t_closest + half_chord;
    bool use0 = may_meet(ray, sphere.material, sphere.flipped != 0u, t0) && t0 < t_max;
    bool use1 = may_meet(ray, sphere.material, sphere.flipped == 0u, t1) && t1 < t_max;
    if (HAS_CUT_SPHERES) {
        use0 = use0 && is_inside_cuts(sphere, o + t0 * d);
        use1 = use1 && is_inside_cuts(sphere, o + t1 * d);
    }
    if (use0 || use1) {
        t_max = use0 ? t0 : t1;
    }
    return use0 || use1;
}

// Finds the hit with t < t_max on the unit disk.
bool intersect_disk(Quadric disk, Ray ray, inout float t_max) {
    vec3 d = ray.direction;
    float t = -ray.origin.z / d.z;
    // The comparisons also reject the NaN and infinity of a ray in the plane.
    if (!(may_meet(ray, disk.material, (d.z > 0.0) == (disk.flipped == 0u), t) && t < t_max)) {
        return false;
    }
    vec2 p = ray.origin.xy + t * d.xy;
    float r2 = dot(p, p);
    if (r2 > 1.0 || r2 < disk.inner_radius * disk.inner_radius || azimuth(p) > disk.phi_max) {
        return false;
    }
    t_max = t;
    return true;
}
