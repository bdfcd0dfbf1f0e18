// Bumps: textures that bend the shading normals of surfaces. Kernels of scenes without bumps leave out this code.
//
// Source: Blinn, "Simulation of Wrinkled Surfaces", 1978, for displacements. As in pbrt-v4, the bent normal alone
// decides what a material does, also on which side of the surface light comes and goes; the geometric normal decides
// where rays start and which medium they are in. Photons have the factors of the adjoint BSDF (Veach 1997, section
// 5.3).
#extension GL_EXT_control_flow_attributes : require
#include "geometry/surface_point.glsl"
#include "material/bsdf.glsl"
#include "material/texture.glsl"
#include "scene/constants.glsl"
#include "scene/features.glsl"
#include "scene/materials.glsl"
#include "scene/scene.glsl"

// Step of both texture coordinates over which the slope of a displacement is measured. pbrt's step is .0005 where it
// does not know the footprint of a pixel. Here it is a power of two, so that sums with coordinates up to some
// thousands have no rounding error that the small step would enlarge.
const float BUMP_STEP = 1.0 / 2048.0;

// Whether a texture bends the normal of a material.
bool is_bent(Material material) {
    return HAS_BUMPS && (material.flags & (DISPLACED | NORMAL_MAPPED)) != 0u;
}

// Whether a direction is on the front of a surface. Without bumps the geometric normal decides: by the shading
// normal, the eye could see through.
bool is_on_front(Surface surface, Material material, vec3 w) {
    vec3 n = surface.normal;
    if (is_bent(material)) {
        n = surface.shading_normal;
    }
    return dot(w, n) >= 0.0;
}

// Index of the medium that a path enters from wo to wi over the one it leaves, where n decides the sides.
float index_change(Material material, vec3 n, vec3 wo, vec3 wi) {
    float side = dot(wo, n);
    return side * dot(wi, n) < 0.0 ? relative_eta(material, side > 0.0) : 1.0;
}

// Factor of a dielectric's BSDF for radiance where the bent normal and the geometric normal disagree about which media
// wo and wi are in. What refraction keeps is the radiance over the squared index. By the bent normal alone, light that
// is reflected into glass would gain the squared index when it leaves the glass.
float media_factor(Surface surface, Material material, vec3 wo, vec3 wi) {
    if (HAS_DIELECTRICS && is_bent(material) && material.kind == DIELECTRIC) {
        float ratio = index_change(material, surface.shading_normal, wo, wi) / index_change(material, surface.normal, wo, wi);
        return ratio * ratio;
    }
    return 1.0;
}

// Takes the media of a scattered path from the geometric normal. `transport` is RADIANCE or FLUX.
void keep_media(inout Scatter scattered, Surface surface, Material material, vec3 wo, bool transport) {
    if (HAS_DIELECTRICS && is_bent(material) && material.kind == DIELECTRIC) {
        float factor = media_factor(surface, material, wo, scattered.wi);
        scattered.weight *= transport == RADIANCE ? factor : 1.0 / factor;
        scattered.eta = index_change(material, surface.normal, wo, scattered.wi);
    }
}

// Makes n the shading normal, on the side of the geometric normal. Leaves the normal where n is not finite or has no
// direction, as at the pole of a sphere.
void bend_to(inout Surface surface, vec3 n, vec3 tangent) {
    float length2 = dot(n, n);
    if (length2 > 0.0 && length2 < INFINITY_T) {
        n *= inversesqrt(length2);
        surface.shading_normal = dot(n, surface.normal) < 0.0 ? -n : n;
        surface.tangent = tangent;
    }
}

// A multiple of v whose products have a length that fp32 holds.
vec3 to_moderate_length(vec3 v) {
    return v / max(max(abs(v.x), abs(v.y)), max(abs(v.z), 1.0e-37));
}

// Bends the normal to that of the surface raised by a height.
void bend_by_displacement(inout Surface surface, Material material) {
    Derivatives by_uv = surface.by_uv;
    vec3 heights; // at the point, and a step along u and along v
    [[dont_unroll]] for (uint i = 0u; i < 3u; i++) { // the code of textures is large
        Surface at = surface;
        vec2 steps = BUMP_STEP * vec2(i == 1u ? 1.0 : 0.0, i == 2u ? 1.0 : 0.0);
        at.uv += steps;
        at.position += steps.x * by_uv.dp_du + steps.y * by_uv.dp_dv;
        heights[i] = material.bump_scale * textured(material.bump_texture, vec3(0.0), at).x;
    }
    vec2 slopes = (heights.yz - heights.x) / BUMP_STEP;
    vec3 along_u = by_uv.dp_du + slopes.x * surface.shading_normal + heights.x * by_uv.dn_du;
    vec3 along_v = by_uv.dp_dv + slopes.y * surface.shading_normal + heights.x * by_uv.dn_dv;
    bend_to(surface, cross(to_moderate_length(along_u), to_moderate_length(along_v)), along_u);
}

// Bends the normal to that of an image.
void bend_by_normal_map(inout Surface surface, Material material) {
    vec3 n = sample_image_texture(texture_nodes_at(material.bump_texture), surface.uv);
    vec3 s = to_moderate_length(surface.by_uv.dp_du);
    vec3 t = cross(surface.shading_normal, s);
    vec3 bent = (n.x * s + n.y * t) * inversesqrt(dot(s, s)) + n.z * surface.shading_normal;
    bend_to(surface, bent, surface.by_uv.dp_du);
}

// Bends the shading normal of a surface of a material, if the material has bumps.
void apply_bumps(inout Surface surface, Material material) {
    if (HAS_DISPLACEMENTS) {
        if ((material.flags & DISPLACED) != 0u) {
            bend_by_displacement(surface, material);
        }
    }
    if (HAS_NORMAL_MAPS) {
        if ((material.flags & NORMAL_MAPPED) != 0u) {
            bend_by_normal_map(surface, material);
        }
    }
}
