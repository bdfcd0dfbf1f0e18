// Lights: the radiance that they emit, and directions to them for next-event estimation.
#include "geometry/contact.glsl"
#include "geometry/quadric.glsl"
#include "geometry/surface.glsl"
#include "geometry/surface_point.glsl"
#include "kernel/invocation.glsl"
#include "light/light_image.glsl"
#include "light/portal.glsl"
#include "material/texture.glsl"
#include "math/circle.glsl"
#include "math/sampling.glsl"
#include "math/select.glsl"
#include "scene/constants.glsl"
#include "scene/features.glsl"
#include "scene/lights.glsl"
#include "scene/primitives.glsl"
#include "scene/scene.glsl"
#include "spectrum/wavelength.glsl"

struct LightSample {
    vec3 target;   // end of the shadow ray, offset from the light's own surface
    vec3 wi;       // unit direction to the light
    vec3 radiance; // that arrives without occlusion, W/(m^2 sr); of a light without area: irradiance, W/m^2
    float pdf;     // of the light and the direction, by solid angle, 1/sr; of a light without area: of the
                   // light. 0 if the sample brings nothing
    bool uses_mis; // a diffuse surface samples its BSDF for this light as well
    bool hittable; // rays may meet the light
    bool is_far;   // infinitely far away; the target is beyond the scene
};

// Whether a diffuse surface samples an area light by MIS of next-event estimation and BSDF sampling: the
// light looks so large from there that BSDF samples are worth a ray. Next-event estimation alone
// samples the others.
bool uses_mis(Light light, vec3 from) {
    vec3 d = light.position - from;
    return dot(d, d) < light.reach2;
}

// Whether rays may meet an area light. One whose alpha is 0 has no reach.
bool is_hittable(Light light) {
    return light.reach2 > 0.0;
}

// Whether `uses_mis` may hold for any light; false if it holds for none.
bool may_use_mis(vec3 from) {
    vec3 d = scene.lights_center - from;
    return dot(d, d) < scene.lights_reach2;
}

// The table of the colors that a light shows at each wavelength, over its color in RGB.
uint colors_of_light(uint index) {
    if (HAS_LIGHT_SPECTRA) {
        return pick(texture_texels_at(scene.light_colors + index / 4u), index % 4u);
    }
    return scene.colors;
}

// A light as a path sees it, by the path's color, with the chance that next-event estimation picks it: with a guide, one
// that a pilot has learned.
Light direct_light(uint index, Hue hue) {
    Light light = lights_at(index);
    if (HAS_GUIDE) {
        light.direct_pmf = direct_table_at(index).chance;
    }
    if (HAS_DISPERSION) {
        light.emission *= color_of(colors_of_light(index), hue);
    }
    return light;
}

// Falloff of a spot light in direction w, in [0, 1].
float spot_falloff(Light light, vec3 w) {
    // 1 - cos without cancellation, which would leave no digits in a narrow cone.
    vec3 d = w - light.direction;
    float width = max(light.falloff_end - light.falloff_start, 1.0e-30);
    float x = clamp((light.falloff_end - 0.5 * dot(d, d)) / width, 0.0, 1.0);
    return x * x * (3.0 - 2.0 * x);
}

// Radiance of a point of an area light, W/(m^2 sr).
vec3 surface_radiance(Light light, Surface surface) {
    if (HAS_IMAGE_EMITTERS) {
        if (light.image != NONE) {
            TextureNode image = texture_nodes_at(light.image); // never another texture
            return light.emission * sample_image_texture(image, texture_coordinates(image, surface).xy);
        }
    }
    return light.emission;
}

// Radiance that a surface emits towards w, W/(m^2 sr).
vec3 emitted_radiance(Light light, Surface surface, vec3 w) {
    return light.two_sided != 0u || dot(surface.normal, w) > 0.0 ? surface_radiance(light, surface) : vec3(0.0);
}

// Factor from pdfs by solid angle in object space to pdfs in render space, for a unit direction w.
float solid_angle_scale(Quadric quadric, vec3 w) {
    float size = length(transform_vector(quadric.object_from_render, w));
    return 1.0 / (quadric.determinant * size * size * size);
}

// A point up to this squared distance from the centre is inside a unit sphere, or on it. From such a
// point all directions are sampled.
const float INSIDE_SPHERE = 1.0001;
// Their rays begin this far from the point, in radii, so that they meet the sphere on its other side.
const float INSIDE_SKIP = 1.0e-3;

// 1 - cos of the cone that a unit sphere fills, seen from squared distance d2, without cancellation; 2,
// for all directions, from inside.
float one_minus_cos_of_cone(float d2) {
    if (d2 <= INSIDE_SPHERE) {
        return 2.0;
    }
    float sin2 = 1.0 / d2;
    return sin2 / (1.0 + sqrt(1.0 - sin2));
}

// Pdf by solid angle of sampling a sphere by the cone that it fills.
float sphere_pdf(Quadric quadric, vec3 from, vec3 wi) {
    vec3 o = transform_point(quadric.object_from_render, from);
    float d2 = dot(o, o);
    return solid_angle_scale(quadric, wi) / (2.0 * PI * one_minus_cos_of_cone(d2));
}

// Pdf by solid angle with which sample_direct chooses this light and finds a point on it.
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

// Samples a point on a sphere by the cone that it fills, seen from a point.
bool sample_sphere(Light light, vec3 from, vec2 u, out Surface surface) {
    Quadric quadric = quadrics_at(light.primitive & INDEX_MASK);
    vec3 o = transform_point(quadric.object_from_render, from);
    float d2 = dot(o, o);
    vec3 axis = d2 > INSIDE_SPHERE ? -o * inversesqrt(d2) : vec3(0.0, 0.0, 1.0);
    vec3 d = to_world(sample_cap(u, one_minus_cos_of_cone(d2)), axis);
    o += d2 > INSIDE_SPHERE ? vec3(0.0) : INSIDE_SKIP * d;
    float t = INFINITY_T;
    bool found = intersect_sphere(quadric, free_ray(o, d), t);
    surface = quadric_surface(quadric, true, o + t * d);
    return found;
}

// Samples a point on a disk, uniformly by area.
Surface sample_disk_light(Light light, vec2 u) {
    Quadric disk = quadrics_at(light.primitive & INDEX_MASK);
    float inner2 = disk.inner_radius * disk.inner_radius;
    float radius = sqrt(mix(inner2, 1.0, u.x));
    float phi = disk.phi_max * u.y;
    return quadric_surface(disk, false, vec3(radius * circle_point(phi), 0.0));
}

// Samples a point on a piece of a body of revolution; surface.area_pdf is its pdf by area.
Surface sample_revolution_light(Light light, vec2 u) {
    uint piece = light.primitive & INDEX_MASK;
    vec4 ends = revolution_pieces_at(piece).ends;
    // A point on the axis has no area and no pdf: keep u above 0. Random numbers are multiples of ROUNDING.
    u.x = max(u.x, 0.5 * ROUNDING);
    // Inverts the distribution of piece_pdf.
    float x = 2.0 * u.x * (ends.x + ends.z) / (ends.x + sqrt(mix(ends.x * ends.x, ends.z * ends.z, u.x))) - 1.0;
    float phi = 2.0 * PI * u.y;
    return revolution_surface(piece, clamp(x, -1.0, 1.0), circle_point(phi));
}

// Samples a point on an emitter that is not a sphere: uniformly by area, or with surface.area_pdf.
Surface sample_emitter_point(Light light, vec2 u) {
    Surface surface;
    uint kind = light.primitive >> KIND_SHIFT;
    if (HAS_TRIANGLE_LIGHTS && kind == TRIANGLE) {
        surface = triangle_surface(light.primitive & INDEX_MASK, sample_triangle(u));
    }
    if (HAS_DISK_LIGHTS && kind == DISK) {
        surface = sample_disk_light(light, u);
    }
    if (HAS_REVOLUTION_LIGHTS && kind == REVOLUTION) {
        surface = sample_revolution_light(light, u);
    }
    return surface;
}

// Samples an area light for next-event estimation from a point.
LightSample sample_area_light(Light light, vec3 from, vec2 u) {
    LightSample direct = LightSample(from, vec3(0.0), vec3(0.0), 0.0, uses_mis(light, from), is_hittable(light), false);
    Surface surface = sample_emitter_point(light, u);
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

// Pdf by solid angle with which sample_direct chooses this sky and a direction of this color.
float sky_pdf(Light sky, LightImage image, vec3 color) {
    return sky.direct_pmf * equal_area_pdf(image, color);
}

LightSample sample_sky(Light sky, vec3 from, vec2 u) {
    LightImage image = light_images_at(sky.primitive);
    ImageSample found = sample_equal_area(image, u);
    vec3 target = from + 2.0 * scene.radius * found.direction;
    float pdf = sky_pdf(sky, image, found.color);
    return LightSample(target, found.direction, sky.emission * found.color, pdf, true, true, true);
}

LightSample sample_portal_sky(Light sky, vec3 from, vec2 u) {
    PortalSample found = sample_portal(light_images_at(sky.primitive), from, u);
    vec3 target = from + 2.0 * scene.radius * found.direction;
    return LightSample(target, found.direction, sky.emission * found.color, sky.direct_pmf * found.pdf, true, true, true);
}

// Factor of a point light's intensity in direction w, per channel.
vec3 intensity_towards(Light light, vec3 w) {
    if (HAS_SPOT_LIGHTS && light.kind == SPOT) {
        return vec3(spot_falloff(light, w));
    }
    if (HAS_GONIOMETRIC_LIGHTS && light.kind == GONIOMETRIC) {
        return equal_area_color(light_images_at(light.primitive), w);
    }
    if (HAS_PROJECTION_LIGHTS && light.kind == PROJECTION) {
        return projected_color(light_images_at(light.primitive), w);
    }
    return vec3(1.0);
}

// Samples a light by the direct table for a path, and a direction to it.
LightSample sample_direct(vec3 from, Hue hue, float u_light, vec2 u) {
    uint count = scene.direct_count;
    float scaled = u_light * float(count);
    uint entry = min(uint(scaled), count - 1u);
    AliasEntry chosen = direct_table_at(entry);
    Light light = direct_light(scaled - float(entry) < chosen.threshold ? chosen.keep : chosen.alias, hue);
    if (HAS_AREA_LIGHTS && light.kind == AREA) {
        return sample_area_light(light, from, u);
    }
    if (HAS_SKIES && light.kind == SKY) {
        return sample_sky(light, from, u);
    }
    if (HAS_PORTALS && light.kind == PORTAL) {
        return sample_portal_sky(light, from, u);
    }
    if (HAS_DISTANT_LIGHTS && light.kind == DISTANT) {
        vec3 target = from - 2.0 * scene.radius * light.direction;
        return LightSample(target, -light.direction, light.emission, light.direct_pmf, false, false, true);
    }
    vec3 to_light = light.position - from;
    float distance2 = dot(to_light, to_light);
    vec3 wi = to_light * inversesqrt(distance2);
    vec3 radiance = light.emission * intensity_towards(light, -wi) / distance2;
    return LightSample(light.position, wi, radiance, light.direct_pmf, false, false, false);
}

// MIS weight of a technique by the power heuristic (Veach 1997), against one other technique. It is
// finite even if both pdfs are 0.
float mis_weight(float pdf, float other) {
    float ratio = other / max(pdf, 1.0e-30);
    return 1.0 / (1.0 + ratio * ratio);
}

// Radiance of the infinite lights for a path that leaves the scene in direction w, W/(m^2 sr). bsdf_pdf is
// the pdf of w, for the MIS weight of skies, which next-event estimation samples as well; it is
// INFINITY_T where next-event estimation does not, such as behind a mirror.
vec3 radiance_from_infinity(vec3 from, vec3 w, Hue hue, float bsdf_pdf) {
    vec3 radiance = scene.infinite;
    if (HAS_DISPERSION) {
        radiance *= color_of(scene.infinite_colors, hue);
    }
    if (HAS_SKIES) {
        [[dont_unroll]] for (uint i = 0u; i < scene.sky_count; i++) {
            Light sky = direct_light(i, hue);
            LightImage image = light_images_at(sky.primitive);
            if (HAS_PORTALS) {
                if (sky.kind == PORTAL) {
                    PortalSample found = look_through_portal(image, from, w);
                    float weight = mis_weight(max(bsdf_pdf, 1.0e-20), sky.direct_pmf * found.pdf);
                    radiance += sky.emission * found.color * weight;
                    continue;
                }
            }
            vec3 color = equal_area_color(image, w);
            float weight = mis_weight(max(bsdf_pdf, 1.0e-20), sky_pdf(sky, image, color));
            radiance += sky.emission * color * weight;
        }
    }
    return radiance;
}
