// Derivatives of surfaces by their texture coordinates, from which bumps are made (material/bump.glsl).
#include "geometry/quadric.glsl"
#include "geometry/surface_point.glsl"
#include "math/sampling.glsl"
#include "revolution/revolution.glsl"
#include "scene/constants.glsl"
#include "scene/features.glsl"
#include "scene/primitives.glsl"
#include "scene/revolutions.glsl"
#include "scene/scene.glsl"

// Derivative of v over its length, where dv is that of v.
vec3 derivative_of_unit(vec3 v, vec3 dv) {
    float inverse = inversesqrt(dot(v, v));
    vec3 unit = inverse * v;
    return inverse * (dv - dot(unit, dv) * unit);
}

// Derivatives of a triangle, whose shading normal is n. Where texture coordinates define none, they are any frame.
//
// As in pbrt-v4, the derivative of the position by v of a triangle with normals at its corners is taken to be
// perpendicular to that by u, and as long.
Derivatives triangle_derivatives(Triangle triangle, TriangleUvs uvs, vec3 n) {
    vec2 uv1 = uvs.uv1 - uvs.uv0;
    vec2 uv2 = uvs.uv2 - uvs.uv0;
    float determinant = uv1.x * uv2.y - uv1.y * uv2.x;
    bool is_defined = determinant != 0.0;
    float inverse = is_defined ? 1.0 / determinant : 0.0;
    // Of the barycentric coordinates of p1 and p2.
    vec2 by_u = inverse * vec2(uv2.y, -uv1.y);
    vec2 by_v = inverse * vec2(-uv2.x, uv1.x);
    vec3 edge1 = triangle.p1 - triangle.p0;
    vec3 edge2 = triangle.p2 - triangle.p0;
    vec3 dp_du, dp_dv;
    make_frame(n, dp_du, dp_dv);
    if (is_defined) {
        dp_du = by_u.x * edge1 + by_u.y * edge2;
        dp_dv = by_v.x * edge1 + by_v.y * edge2;
    }
    Derivatives derivatives = Derivatives(dp_du, dp_dv, vec3(0.0), vec3(0.0));
    if (HAS_SHADING_NORMALS && triangle.normals != NONE) {
        TriangleNormals normals = triangle_normals_at(triangle.normals);
        vec3 turn1 = normals.n1.xyz - normals.n0.xyz;
        vec3 turn2 = normals.n2.xyz - normals.n0.xyz;
        dp_dv = cross(n, dp_du);
        derivatives = Derivatives(cross(dp_dv, n), dp_dv, by_u.x * turn1 + by_u.y * turn2, by_v.x * turn1 + by_v.y * turn2);
    }
    return derivatives;
}

// Derivatives of a quadric at a point of it in object space; `heights` is the polar angle at v = 1 minus that at
// v = 0, for a sphere.
Derivatives quadric_derivatives(Quadric quadric, bool sphere, vec3 p, float heights) {
    float radius = length(p.xy);
    vec2 outward = radius > 0.0 ? p.xy / radius : vec2(1.0, 0.0);
    vec3 by_u = quadric.phi_max * vec3(-p.y, p.x, 0.0);
    vec3 by_v = sphere ? heights * vec3(p.z * outward, -radius) : vec3((quadric.inner_radius - 1.0) * outward, 0.0);
    Derivatives derivatives;
    derivatives.dp_du = transform_vector(quadric.render_from_object, by_u);
    derivatives.dp_dv = transform_vector(quadric.render_from_object, by_v);
    // The normal of a unit sphere is the point; that of a disk does not turn.
    float sign = !sphere ? 0.0 : quadric.flipped != 0u ? -1.0 : 1.0;
    vec3 n = transform_normal(quadric.object_from_render, sphere ? p : vec3(0.0, 0.0, 1.0));
    derivatives.dn_du = sign * derivative_of_unit(n, transform_normal(quadric.object_from_render, by_u));
    derivatives.dn_dv = sign * derivative_of_unit(n, transform_normal(quadric.object_from_render, by_v));
    return derivatives;
}

// The second derivative of a profile by x.
vec2 profile_curvature(Profile profile, float x) {
    vec2 p = vec2(0.0);
    vec2 d = vec2(0.0);
    vec2 half_of_second = vec2(0.0);
    [[unroll]] for (uint i = 0u; i < REVOLUTION_PAIRS; i++) {
        vec4 pair = profile.c[REVOLUTION_PAIRS - (i + 1u)];
        half_of_second = fma(half_of_second, vec2(x), d);
        d = fma(d, vec2(x), p);
        p = fma(p, vec2(x), pair.zw);
        half_of_second = fma(half_of_second, vec2(x), d);
        d = fma(d, vec2(x), p);
        p = fma(p, vec2(x), pair.xy);
    }
    return 2.0 * half_of_second;
}

// Derivatives of a body of revolution at a point of its profile, at parameter x of a piece; `azimuth` is the unit
// vector from the axis to the point.
Derivatives revolution_derivatives(uint piece, Revolution body, Profile profile, ProfilePoint point, float x, vec2 azimuth) {
    vec2 along = revolution_pieces_at(piece).along;
    float dx_dv = 2.0 / (along.y - along.x);
    vec2 around = 2.0 * PI * vec2(-azimuth.y, azimuth.x);
    vec2 slope = dx_dv * point.d;
    vec2 bend = dx_dv * profile_curvature(profile, x);
    Derivatives derivatives;
    derivatives.dp_du = transform_vector(body.render_from_unit, vec3(point.p.x * around, 0.0));
    derivatives.dp_dv = transform_vector(body.render_from_unit, vec3(slope.x * azimuth, slope.y));
    float sign = body.flipped != 0u ? -1.0 : 1.0;
    vec3 n = transform_normal(body.unit_from_render, vec3(point.d.y * azimuth, -point.d.x));
    vec3 by_u = transform_normal(body.unit_from_render, vec3(point.d.y * around, 0.0));
    vec3 by_v = transform_normal(body.unit_from_render, vec3(bend.y * azimuth, -bend.x));
    derivatives.dn_du = sign * derivative_of_unit(n, by_u);
    derivatives.dn_dv = sign * derivative_of_unit(n, by_v);
    return derivatives;
}

// Transforms derivatives in an instance from object to render space; n is the shading normal in object space.
Derivatives derivatives_out_of_instance(Instance instance, Derivatives derivatives, vec3 n) {
    derivatives.dp_du = transform_vector(instance.render_from_object, derivatives.dp_du);
    derivatives.dp_dv = transform_vector(instance.render_from_object, derivatives.dp_dv);
    vec3 turned = transform_normal(instance.object_from_render, n);
    vec3 by_u = transform_normal(instance.object_from_render, derivatives.dn_du);
    vec3 by_v = transform_normal(instance.object_from_render, derivatives.dn_dv);
    derivatives.dn_du = derivative_of_unit(turned, by_u);
    derivatives.dn_dv = derivative_of_unit(turned, by_v);
    return derivatives;
}
