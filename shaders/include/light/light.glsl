// Light sources: radiance they emit, directions to them, photons from them.
#include "geometry/contact.glsl"
#include "geometry/quadric.glsl"
#include "geometry/surface.glsl"
#include "geometry/surface_point.glsl"
#include "kernel/invocation.glsl"
#include "light/light_image.glsl"
#include "material/texture.glsl"
#include "math/sampling.glsl"
#include "scene/constants.glsl"
#include "scene/features.glsl"
#include "scene/lights.glsl"
#include "scene/primitives.glsl"
#include "scene/scene.glsl"

struct LightSample {
    vec3 target;   // the end of the shadow ray, offset from the light's own surface
    vec3 wi;       // unit direction to the light
    vec3 radiance; // arriving if unoccluded, or irradiance for lights without area
    float pdf;     // solid angle, selection included; 0 if there is nothing to gain
    bool competes; // directions of a diffuse bsdf look for this light, too
    bool hittable; // rays may find it
};

// Whether an area light is so large as seen from a point that directions of the bsdf are worth
// a ray: MIS has both techniques look for such lights, and one for the others.
bool competes(Light light, vec3 from) {
    vec3 d = light.position - from;
    return dot(d, d) < light.reach2;
}

// Whether rays may meet an area light: not one whose alpha is 0, which has no reach.
bool is_hittable(Light light) {
    return light.reach2 > 0.0;
}

// Whether there may be any such light.
bool is_near_lights(vec3 from) {
    vec3 d = scene.lights_center - from;
    return dot(d, d) < scene.lights_reach2;
}

// Smooth falloff of a spot light in direction w.
float spot_falloff(Light light, vec3 w) {
    // 1 - cos, without the cancellation that would be all there is of a narrow cone.
    vec3 d = w - light.direction;
    float width = max(light.falloff_end - light.falloff_start, 1.0e-30);
    float x = clamp((light.falloff_end - 0.5 * dot(d, d)) / width, 0.0, 1.0);
    return x * x * (3.0 - 2.0 * x);
}

// Radiance of a point of an area light.
vec3 surface_radiance(Light light, Surface surface) {
    if (HAS_IMAGE_EMITTERS) {
        return light.emission * textured(light.image, vec3(1.0), surface);
    }
    return light.emission;
}

// Radiance that a surface emits towards w.
vec3 emitted_radiance(Light light, Surface surface, vec3 w) {
    return light.two_sided != 0u || dot(surface.normal, w) > 0.0 ? surface_radiance(light, surface) : vec3(0.0);
}

// Size of a direction's image in object space, for unit w: solid angles grow by
// determinant / size^3 from render to object space.
float direction_density(Quadric quadric, vec3 w) {
    float size = length(transform_vector(quadric.object_from_render, w));
    return 1.0 / (quadric.determinant * size * size * size);
}

// Squared distances up to this are inside a unit sphere or on it: a sphere that lights its
// own inside must look across, not at the point that it is seen from.
const float ON_SPHERE = 1.0001;
// What such a view skips, in radii.
const float SKIPPED = 1.0e-3;

// 1 - cos of the cone that a unit sphere fills from squared distance d2, without
// cancellation; of all directions, from inside.
float cone_of_sphere(float d2) {
    if (d2 <= ON_SPHERE) {
        return 2.0;
    }
    float sin2 = 1.0 / d2;
    return sin2 / (1.0 + sqrt(1.0 - sin2));
}

// Pdf of sampling a sphere by the cone it fills (by all directions, from inside).
float sphere_pdf(Quadric quadric, vec3 from, vec3 wi) {
    vec3 o = transform_point(quadric.object_from_render, from);
    float d2 = dot(o, o);
    return direction_density(quadric, wi) / (2.0 * PI * cone_of_sphere(d2));
}

// Pdf, selection included, with which direct_sample finds a point on an area light.
float direct_pdf(Light light, vec3 from, Surface surface, vec3 wi) {
    if (HAS_SPHERE_LIGHTS && light.primitive >> KIND_SHIFT == SPHERE) {
        return light.direct_pmf * sphere_pdf(quadrics_at(light.primitive & INDEX_MASK), from, wi);
    }
    vec3 to_light = surface.position - from;
    float cos_light = abs(dot(surface.normal, wi));
    float area_pdf = 1.0 / light.area;
    if (HAS_REVOLUTION_LIGHTS && light.primitive >> KIND_SHIFT == REVOLUTION) {
        area_pdf = surface.area_pdf;
    }
    return light.direct_pmf * area_pdf * dot(to_light, to_light) / max(cos_light, 1.0e-20);
}

// A point on a sphere in the cone it fills as seen from a point.
bool sample_sphere(Light light, vec3 from, vec2 u, out Surface surface) {
    Quadric quadric = quadrics_at(light.primitive & INDEX_MASK);
    vec3 o = transform_point(quadric.object_from_render, from);
    float d2 = dot(o, o);
    vec3 axis = d2 > ON_SPHERE ? -o * inversesqrt(d2) : vec3(0.0, 0.0, 1.0);
    vec3 d = to_world(sample_cap(u, cone_of_sphere(d2)), axis);
    o += d2 > ON_SPHERE ? vec3(0.0) : SKIPPED * d;
    float t = INFINITY_T;
    bool found = intersect_sphere(quadric, free_ray(o, d), t);
    surface = quadric_surface(quadric, true, o + t * d);
    return found;
}

// A point uniform by area on a disk.
Surface sample_flat_disk(Light light, vec2 u) {
    Quadric disk = quadrics_at(light.primitive & INDEX_MASK);
    float inner2 = disk.inner_radius * disk.inner_radius;
    // A whole disk keeps strata together; a cut one is sampled in polar coordinates.
    float radius = sqrt(mix(inner2, 1.0, u.x));
    float phi = disk.phi_max * u.y;
    return quadric_surface(disk, false, vec3(radius * cos(phi), radius * sin(phi), 0.0));
}

// A point on a piece of a body of revolution, with surface.area_pdf.
Surface sample_revolution(Light light, vec2 u) {
    uint piece = light.primitive & INDEX_MASK;
    vec4 ends = revolution_pieces_at(piece).ends;
    // Inverts the distribution of piece_pdf.
    // Points on the axis have no area and no pdf; numbers are multiples of ROUNDING.
    u.x = max(u.x, 0.5 * ROUNDING);
    float x = 2.0 * u.x * (ends.x + ends.z) / (ends.x + sqrt(mix(ends.x * ends.x, ends.z * ends.z, u.x))) - 1.0;
    float phi = 2.0 * PI * u.y;
    return revolution_surface(piece, clamp(x, -1.0, 1.0), vec2(cos(phi), sin(phi)));
}

// A point on an emitter, but a sphere: uniform by area, or with surface.area_pdf.
Surface sample_emitter(Light light, vec2 u) {
    Surface surface;
    uint kind = light.primitive >> KIND_SHIFT;
    if (HAS_TRIANGLE_LIGHTS && kind == TRIANGLE) {
        surface = triangle_surface(light.primitive & INDEX_MASK, sample_triangle(u));
    }
    if (HAS_DISK_LIGHTS && kind == DISK) {
        surface = sample_flat_disk(light, u);
    }
    if (HAS_REVOLUTION_LIGHTS && kind == REVOLUTION) {
        surface = sample_revolution(light, u);
    }
    return surface;
}

// An emitter seen from a point by next-event estimation.
LightSample sample_area(Light light, vec3 from, vec2 u) {
    LightSample direct = LightSample(from, vec3(0.0), vec3(0.0), 0.0, competes(light, from), is_hittable(light));
    Surface surface = sample_emitter(light, u);
    if (HAS_SPHERE_LIGHTS && light.primitive >> KIND_SHIFT == SPHERE) {
        if (!sample_sphere(light, from, u, surface)) {
            return direct;
        }
    }
    vec3 to_light = surface.position - from;
    direct.wi = normalize(to_light);
    direct.target = offset_origin(surface, -direct.wi);
    direct.radiance = emitted_radiance(light, surface, -direct.wi) * opacity(surface);
    direct.pdf = direct_pdf(light, from, surface, direct.wi);
    return direct;
}

// Pdf, selection included, with which sample_direct finds a color of a sky.
float sky_pdf(Light sky, LightImage image, vec3 color) {
    return sky.direct_pmf * octahedral_pdf(image, color);
}

LightSample sample_sky(Light sky, vec3 from, vec2 u) {
    LightImage image = light_images_at(sky.primitive);
    ImageSample found = sample_octahedral(image, u);
    vec3 target = from + 2.0 * scene.radius * found.direction;
    float pdf = sky_pdf(sky, image, found.color);
    return LightSample(target, found.direction, sky.emission * found.color, pdf, true, true);
}

// Factor of a point light's intensity in direction w.
vec3 intensity_towards(Light light, vec3 w) {
    if (HAS_SPOT_LIGHTS && light.kind == SPOT) {
        return vec3(spot_falloff(light, w));
    }
    if (HAS_GONIOMETRIC_LIGHTS && light.kind == GONIOMETRIC) {
        return octahedral_color(light_images_at(light.primitive), w);
    }
    if (HAS_PROJECTION_LIGHTS && light.kind == PROJECTION) {
        return projected_color(light_images_at(light.primitive), w);
    }
    return vec3(1.0);
}

// A light chosen by the direct table, and a direction to it.
LightSample sample_direct(vec3 from, float u_light, vec2 u) {
    uint count = scene.direct_count;
    float scaled = u_light * float(count);
    uint entry = min(uint(scaled), count - 1u);
    AliasEntry chosen = direct_table_at(entry);
    Light light = lights_at(scaled - float(entry) < chosen.threshold ? chosen.keep : chosen.alias);
    if (HAS_AREA_LIGHTS && light.kind == AREA) {
        return sample_area(light, from, u);
    }
    if (HAS_SKIES && light.kind == SKY) {
        return sample_sky(light, from, u);
    }
    if (HAS_DISTANT_LIGHTS && light.kind == DISTANT) {
        vec3 target = from - 2.0 * scene.radius * light.direction;
        return LightSample(target, -light.direction, light.emission, light.direct_pmf, false, false);
    }
    vec3 to_light = light.position - from;
    float distance2 = dot(to_light, to_light);
    vec3 wi = to_light * inversesqrt(distance2);
    vec3 radiance = light.emission * intensity_towards(light, -wi) / distance2;
    return LightSample(light.position, wi, radiance, light.direct_pmf, false, false);
}

// Weight of one of two strategies (Veach 1997, power heuristic): a number even if neither finds
// the light.
float mis_weight(float pdf, float other) {
    float ratio = other / max(pdf, 1.0e-30);
    return 1.0 / (1.0 + ratio * ratio);
}

// Radiance that a ray meets where it leaves the scene in direction w. Where next-event
// estimation looks for the same light, bsdf_pdf is the pdf of w, and what that finds is left
// out; elsewhere it is INFINITY_T, as of a mirror.
vec3 radiance_from_infinity(vec3 w, float bsdf_pdf) {
    vec3 radiance = scene.infinite;
    if (HAS_SKIES) {
        [[dont_unroll]] for (uint i = 0u; i < scene.sky_count; i++) {
            Light sky = lights_at(i);
            LightImage image = light_images_at(sky.primitive);
            vec3 color = octahedral_color(image, w);
            float weight = mis_weight(max(bsdf_pdf, 1.0e-20), sky_pdf(sky, image, color));
            radiance += sky.emission * color * weight;
        }
    }
    return radiance;
}
