// The point at which a ray meets a surface.
#include "geometry/contact.glsl"
#include "geometry/derivatives.glsl"
#include "geometry/hit.glsl"
#include "geometry/instance.glsl"
#include "geometry/quadric.glsl"
#include "geometry/surface_contact.glsl"
#include "geometry/surface_point.glsl"
#include "math/sampling.glsl"
#include "revolution/revolution.glsl"
#include "scene/constants.glsl"
#include "scene/features.glsl"
#include "scene/primitives.glsl"
#include "scene/revolutions.glsl"
#include "scene/scene.glsl"

vec3 any_perpendicular(vec3 n) {
    return abs(n.x) > abs(n.z) ? vec3(-n.y, n.x, 0.0) : vec3(0.0, -n.z, n.y);
}

// The tangent, or any direction in the surface where texture coordinates define none.
vec3 tangent_or_any(vec3 tangent, vec3 n) {
    return dot(tangent, tangent) > 0.0 ? tangent : any_perpendicular(n);
}

vec3 triangle_tangent(Triangle triangle, TriangleUvs uvs, vec3 n) {
    vec2 uv1 = uvs.uv1 - uvs.uv0;
    vec2 uv2 = uvs.uv2 - uvs.uv0;
    float determinant = uv1.x * uv2.y - uv1.y * uv2.x;
    vec3 along = uv2.y * (triangle.p1 - triangle.p0) - uv1.y * (triangle.p2 - triangle.p0);
    return tangent_or_any(determinant < 0.0 ? -along : determinant > 0.0 ? along : vec3(0.0), n);
}

// Bound of the rounding error of a point with coordinates up to those of p plus `size`: 7 roundings to
// interpolate it, and 9 to transform a ray's origin to the space in which the ray is intersected next.
float position_error(vec3 p, float size) {
    return 16.0 * ROUNDING * (max(max(abs(p.x), abs(p.y)), abs(p.z)) + size);
}

// The surface at barycentric coordinates of a triangle.
Surface triangle_surface(uint index, vec2 barycentric) {
    Triangle triangle = triangles_at(index);
    Surface surface;
    float b0 = 1.0 - barycentric.x - barycentric.y;
    surface.position = b0 * triangle.p0 + barycentric.x * triangle.p1 + barycentric.y * triangle.p2;
    vec3 extent = max(max(abs(triangle.p0), abs(triangle.p1)), abs(triangle.p2));
    surface.error = position_error(extent, 0.0);
    surface.normal = normalize(cross(triangle.p1 - triangle.p0, triangle.p2 - triangle.p0));
    surface.shading_normal = surface.normal;
    set_material(surface, triangle.material);
    surface.light = triangle.light;
    if (HAS_SHADING_NORMALS && triangle.normals != NONE) {
        TriangleNormals normals = triangle_normals_at(triangle.normals);
        vec3 n = b0 * normals.n0.xyz + barycentric.x * normals.n1.xyz + barycentric.y * normals.n2.xyz;
        float length2 = dot(n, n);
        if (length2 > 0.0) {
            n *= inversesqrt(length2);
            surface.shading_normal = dot(n, surface.normal) < 0.0 ? -n : n;
        }
    }
    if (HAS_TEXTURES) {
        TriangleUvs uvs = triangle_uvs_at(index);
        surface.uv = b0 * uvs.uv0 + barycentric.x * uvs.uv1 + barycentric.y * uvs.uv2;
    }
    if (HAS_ANISOTROPIC) {
        surface.tangent = triangle_tangent(triangle, triangle_uvs_at(index), surface.normal);
    }
    if (HAS_BUMPS) {
        surface.by_uv = triangle_derivatives(triangle, triangle_uvs_at(index), surface.shading_normal);
    }
    return surface;
}

// The polar angle of points of the unit sphere at height z, radians.
float polar_angle(float z) {
    return atan(sqrt(max(0.0, 1.0 - z * z)), z);
}

vec2 quadric_uv(Quadric quadric, bool sphere, vec3 p) {
    float u = azimuth(p.xy) / quadric.phi_max;
    if (sphere) {
        float bottom = polar_angle(quadric.z_min);
        return vec2(u, (atan(length(p.xy), p.z) - bottom) / (polar_angle(quadric.z_max) - bottom));
    }
    return vec2(u, (1.0 - length(p.xy)) / (1.0 - quadric.inner_radius));
}

// The surface of a quadric at a point near it, in object space.
Surface quadric_surface(Quadric quadric, bool sphere, vec3 p) {
    Surface surface;
    vec3 n = sphere ? normalize(p) : vec3(0.0, 0.0, 1.0);
    vec3 on_surface = sphere ? n : vec3(p.xy, 0.0);
    surface.position = transform_point(quadric.render_from_object, on_surface);
    surface.error = position_error(surface.position, quadric.size);
    n = normalize(transform_normal(quadric.object_from_render, n));
    surface.normal = quadric.flipped != 0u ? -n : n;
    surface.shading_normal = surface.normal;
    set_material(surface, quadric.material);
    surface.light = quadric.light;
    if (HAS_TEXTURES) {
        surface.uv = quadric_uv(quadric, sphere, on_surface);
    }
    if (HAS_ANISOTROPIC) {
        vec3 tangent = transform_vector(quadric.render_from_object, vec3(-on_surface.y, on_surface.x, 0.0));
        surface.tangent = tangent_or_any(tangent, surface.normal);
    }
    if (HAS_BUMPS) {
        float heights = polar_angle(quadric.z_max) - polar_angle(quadric.z_min);
        surface.by_uv = quadric_derivatives(quadric, sphere, on_surface, heights);
    }
    return surface;
}

// Pdf, up to a factor, of sampling x in [-1, 1] on a piece: linear between the radii of its ends, so that
// points near the axis, on small rings, are rare.
float piece_pdf(vec2 radii, float x) {
    return mix(radii.x, radii.y, 0.5 + 0.5 * x) / (radii.x + radii.y);
}

// Texture coordinates of a point of a body of revolution: azimuth from the x axis, and position along the
// profile, both in [0, 1].
vec2 revolution_uv(uint piece, float x, vec2 around) {
    vec2 along = revolution_pieces_at(piece).along;
    return vec2(azimuth(around) / (2.0 * PI), mix(along.x, along.y, 0.5 + 0.5 * x));
}

// The surface of a body of revolution at parameter x of a piece of its profile; `azimuth` is the unit
// vector from the axis to the point.
Surface revolution_surface(uint piece, float x, vec2 azimuth) {
    Profile profile = load_profile(piece);
    Revolution body = revolutions_at(revolution_pieces_at(piece).body);
    ProfilePoint point = evaluate_profile(profile, x);
    Surface surface;
    surface.position = transform_point(body.render_from_unit, vec3(point.p.x * azimuth, point.p.y));
    vec3 size = vec3(length(body.render_from_unit[0].xyz), length(body.render_from_unit[1].xyz),
                     length(body.render_from_unit[2].xyz));
    surface.error = position_error(surface.position, max(max(size.x, size.y), size.z));
    vec2 slope = profile_direction(profile, point);
    vec3 n = transform_normal(body.unit_from_render, vec3(slope.y * azimuth, -slope.x));
    float growth = length(n);
    surface.normal = n * ((body.flipped != 0u ? -1.0 : 1.0) / growth);
    surface.shading_normal = surface.normal;
    set_material(surface, body.material);
    surface.light = revolution_pieces_at(piece).light;
    surface.area_pdf = 0.0;
    if (HAS_AREA_LIGHTS && surface.light != NONE) {
        // The ring between x and x + dx has the area 2 pi u |(u', v')| dx in unit space.
        float ring = 2.0 * PI * point.p.x * body.determinant * growth * length(point.d) / length(slope);
        surface.area_pdf = piece_pdf(profile.ends.xz, x) / max(ring, 1.0e-30);
    }
    if (HAS_TEXTURES) {
        surface.uv = revolution_uv(piece, x, azimuth);
    }
    if (HAS_ANISOTROPIC) {
        surface.tangent = transform_vector(body.render_from_unit, vec3(-azimuth.y, azimuth.x, 0.0));
    }
    if (HAS_BUMPS) {
        surface.by_uv = revolution_derivatives(piece, body, profile, point, x, azimuth);
    }
    return surface;
}

// Transforms a surface in an instance from object to render space.
Surface surface_out_of_instance(uint index, Surface surface) {
    Instance instance = instances_at(index);
    surface.position = transform_point(instance.render_from_object, surface.position);
    surface.error = instance.growth * surface.error + instance.error;
    surface.normal = normalize(transform_normal(instance.object_from_render, surface.normal));
    if (HAS_BUMPS) {
        surface.by_uv = derivatives_out_of_instance(instance, surface.by_uv, surface.shading_normal);
    }
    vec3 n = normalize(transform_normal(instance.object_from_render, surface.shading_normal));
    surface.shading_normal = dot(n, surface.normal) < 0.0 ? -n : n;
    if (HAS_ANISOTROPIC) {
        surface.tangent = transform_vector(instance.render_from_object, surface.tangent);
    }
    return surface;
}

// The surface at a hit, for a ray in the space of the primitive that it hit.
Surface local_surface(Ray ray, Hit hit) {
    uint kind = hit.primitive >> KIND_SHIFT;
    uint index = hit.primitive & INDEX_MASK;
    if (is_triangle(kind)) {
        return triangle_surface(index, hit.barycentric);
    }
    if (is_revolution(kind)) {
        uint body = revolution_pieces_at(index).body;
        vec3 o = transform_point(revolutions_at(body).unit_from_render, ray.origin);
        vec3 d = transform_vector(revolutions_at(body).unit_from_render, ray.direction);
        vec2 q = o.xy + hit.t * d.xy;
        float rho = length(q);
        return revolution_surface(index, hit.barycentric.x, rho > 0.0 ? q / rho : vec2(1.0, 0.0));
    }
    Quadric quadric = quadrics_at(index);
    vec3 o = transform_point(quadric.object_from_render, ray.origin);
    vec3 d = transform_vector(quadric.object_from_render, ray.direction);
    return quadric_surface(quadric, is_sphere(kind), o + hit.t * d);
}

// The surface at a hit of a ray, in render space.
Surface surface_at(Ray ray, Hit hit) {
    bool is_inside = HAS_INSTANCES && hit.instance != NONE;
    Ray local = ray;
    if (is_inside) {
        local = ray_into_instance(hit.instance, ray);
    }
    Surface surface = local_surface(local, hit);
    if (is_inside) {
        surface = surface_out_of_instance(hit.instance, surface);
    }
    set_contact(surface, ray, hit.t);
    return surface;
}

// Origin for a ray that leaves a surface along `direction` and must not meet it again.
vec3 offset_origin(Surface surface, vec3 direction) {
    vec3 n = dot(direction, surface.normal) < 0.0 ? -surface.normal : surface.normal;
    return surface.position + normal_error(surface) * n;
}

// Whether a path crosses a surface: wo and wi are on different sides.
bool crosses_surface(Surface surface, vec3 wo, vec3 wi) {
    return dot(wo, surface.normal) * dot(wi, surface.normal) < 0.0;
}

// Sets the medium of a ray that starts at a surface whose media are set.
void set_ray_medium(inout Ray ray, Surface surface) {
    if (HAS_MEDIA) {
        ray.medium = dot(ray.direction, surface.normal) > 0.0 ? surface.media.x : surface.media.y;
    }
}

// A ray that leaves a surface along a direction. `passes`: its path crosses the surface.
Ray spawn_ray(Surface surface, vec3 direction, bool passes) {
    Ray ray = free_ray(offset_origin(surface, direction), direction);
    set_ray_contacts(ray, surface, passes);
    set_ray_medium(ray, surface);
    return ray;
}

// A ray from a surface in direction wi that reaches a target at t = 1. `passes`: its path crosses the
// surface.
Ray shadow_ray(Surface surface, vec3 wi, vec3 target, bool passes) {
    vec3 origin = offset_origin(surface, wi);
    Ray ray = free_ray(origin, target - origin);
    set_ray_contacts(ray, surface, passes);
    set_ray_medium(ray, surface);
    return ray;
}
