// Emits photons from lights.
#include "geometry/contact.glsl"
#include "geometry/quadric.glsl"
#include "geometry/surface.glsl"
#include "geometry/surface_point.glsl"
#include "light/guide.glsl"
#include "light/light.glsl"
#include "light/light_image.glsl"
#include "material/texture.glsl"
#include "math/circle.glsl"
#include "math/random.glsl"
#include "math/sampling.glsl"
#include "medium/medium.glsl"
#include "scene/features.glsl"
#include "scene/lights.glsl"
#include "scene/primitives.glsl"
#include "scene/scene.glsl"

struct Emission {
    Ray ray;
    vec3 weight; // flux over the mean flux of a photon, per channel
};

// Samples x in [0, 1] with pdf proportional to smoothstep: solves 2 x^3 - x^4 = u by Newton's method.
float sample_smoothstep(float u) {
    float x = pow(0.5 * u, 1.0 / 3.0);
    for (int i = 0; i < 5; i++) {
        float slope = x * x * (6.0 - 4.0 * x);
        x = clamp(x - (x * x * x * (2.0 - x) - u) / max(slope, 1.0e-6), 0.0, 1.0);
    }
    return x;
}

// Samples a direction in a spot light's cone with pdf proportional to its falloff. `solid_angle` becomes
// the integral of the falloff over solid angle, sr.
vec3 sample_spot(Light light, vec2 u, out float solid_angle) {
    float core = light.falloff_start;
    float rim = 0.5 * (light.falloff_end - light.falloff_start);
    solid_angle = 2.0 * PI * (core + rim);
    float pick = u.x * (core + rim);
    float one_minus_cos = pick < core
        ? pick
        : mix(light.falloff_end, light.falloff_start, sample_smoothstep(min((pick - core) / rim, 1.0)));
    return to_world(sample_cap(vec2(1.0, u.y), one_minus_cos), light.direction);
}

// Samples a point on a sphere, uniformly by area in object space. `area` becomes 1 over the pdf by area.
Surface sample_sphere_area(Quadric quadric, vec2 u, out float area) {
    float height = quadric.z_max - quadric.z_min;
    float z = quadric.z_min + u.x * height;
    float phi = quadric.phi_max * u.y;
    float r = sqrt(max(0.0, 1.0 - z * z));
    vec3 p = vec3(r * circle_point(phi), z);
    // The transform scales areas by the determinant times the length of the transformed normal.
    float growth = quadric.determinant * length(transform_normal(quadric.object_from_render, p));
    area = quadric.phi_max * height * growth;
    return quadric_surface(quadric, true, p);
}

Emission emit_area(Light light, vec2 u_position, vec2 u_direction, float u_side) {
    float area = light.area;
    Surface surface = sample_emitter_point(light, u_position);
    if (HAS_SPHERE_LIGHTS && light.primitive >> KIND_SHIFT == SPHERE) {
        surface = sample_sphere_area(quadrics_at(light.primitive & INDEX_MASK), u_position, area);
    }
    if (HAS_REVOLUTION_LIGHTS && light.primitive >> KIND_SHIFT == REVOLUTION) {
        area = 1.0 / surface.area_pdf;
    }
    bool back = light.two_sided != 0u && u_side < 0.5;
    vec3 direction = sample_cosine(u_direction, back ? -surface.normal : surface.normal);
    float sides = light.two_sided != 0u ? 2.0 : 1.0;
    vec3 exitance = surface_radiance(light, surface) * (PI * sides * opacity(surface));
    if (HAS_MEDIA) {
        set_media(surface);
    }
    return Emission(spawn_ray(surface, direction, false), exitance * area);
}

// Emits parallel light through the faces of the scene's bounding box that face the light, uniformly
// across the direction, so that no ray misses the box. A face is chosen by its projected area.
Emission emit_parallel(vec3 direction, vec3 irradiance, vec2 u, float u_face) {
    vec3 shown = 4.0 * scene.half_extent.yzx * scene.half_extent.zxy * abs(direction);
    float area = shown.x + shown.y + shown.z;
    float pick = u_face * area;
    vec3 facing = mix(vec3(-1.0), vec3(1.0), lessThan(direction, vec3(0.0)));
    vec2 place = 2.0 * u - 1.0;
    vec3 point = pick < shown.x ? vec3(facing.x, place)
               : pick < shown.x + shown.y ? vec3(place.y, facing.y, place.x)
               : vec3(place, facing.z);
    point *= scene.half_extent;
    // The origin lies before the whole scene.
    vec3 origin = scene.center + point - (dot(point, direction) + scene.radius) * direction;
    return Emission(free_ray(origin, direction), irradiance * area);
}

// Emits light through a portal, from a point before the whole scene.
Emission emit_through_portal(Light light, vec2 u_position, vec2 u_direction) {
    LightImage image = light_images_at(light.primitive);
    Portal portal = portal_of(image);
    vec3 w = sample_equal_area(image, u_direction).direction;
    vec3 color;
    float pdf = portal_image_pdf(image, w, color);
    vec3 point = portal.corner + u_position.x * portal.x_edge + u_position.y * portal.y_edge;
    float area = length(cross(portal.x_edge, portal.y_edge)) * max(dot(w, portal.normal), 0.0);
    vec3 origin = point + (length(point - scene.center) + 2.0 * scene.radius) * w;
    return Emission(free_ray(origin, -w), pdf > 0.0 ? light.emission * color * (area / pdf) : vec3(0.0));
}

Emission emit_from(Light light, vec2 u_position, vec2 u_direction, float u_side) {
    if (HAS_AREA_LIGHTS && light.kind == AREA) {
        return emit_area(light, u_position, u_direction, u_side);
    }
    if (HAS_SKIES && light.kind == SKY) {
        ImageSample from = sample_equal_area(light_images_at(light.primitive), u_direction);
        return emit_parallel(-from.direction, light.emission * from.color / from.pdf, u_position, u_side);
    }
    if (HAS_PORTALS && light.kind == PORTAL) {
        return emit_through_portal(light, u_position, u_direction);
    }
    if (HAS_GONIOMETRIC_LIGHTS && light.kind == GONIOMETRIC) {
        ImageSample to = sample_equal_area(light_images_at(light.primitive), u_direction);
        return Emission(free_ray(light.position, to.direction), light.emission * to.color / to.pdf);
    }
    if (HAS_PROJECTION_LIGHTS && light.kind == PROJECTION) {
        ImageSample to = sample_projection(light_images_at(light.primitive), u_direction);
        return Emission(free_ray(light.position, to.direction), light.emission * to.color / to.pdf);
    }
    if (HAS_DISTANT_LIGHTS && light.kind == DISTANT) {
        return emit_parallel(light.direction, light.emission, u_position, u_side);
    }
    if (HAS_INFINITE_LIGHTS && light.kind == INFINITE) {
        vec3 direction = sample_cap(u_direction, 2.0);
        return emit_parallel(direction, light.emission * (4.0 * PI), u_position, u_side);
    }
    float solid_angle = 4.0 * PI;
    vec3 direction;
    if (HAS_SPOT_LIGHTS && light.kind == SPOT) {
        direction = sample_spot(light, u_direction, solid_angle);
    } else {
        direction = sample_cap(u_direction, 2.0);
    }
    return Emission(free_ray(light.position, direction), light.emission * solid_angle);
}

// Samples a light by its power: its index.
uint sample_emitter_index(float u) {
    uint count = scene.emission_count;
    if (HAS_GUIDE) {
        return sample_guide_light(u, count);
    }
    float scaled = u * float(count);
    uint entry = min(uint(scaled), count - 1u);
    AliasEntry chosen = emission_table_at(entry);
    return scaled - float(entry) < chosen.threshold ? chosen.keep : chosen.alias;
}

Light sample_emitter(float u) {
    return lights_at(sample_emitter_index(u));
}

// The color of a photon, by that of its light at its wavelength.
vec3 color_of_photon(Random random, Hue hue) {
    uint colors = scene.colors;
    if (HAS_LIGHT_SPECTRA) {
        colors = colors_of_light(sample_emitter_index(emission_numbers(random).light.x));
    }
    return color_of(colors, hue);
}

// Emits a photon: samples a light by its power, a point and a direction.
Emission emit(EmissionNumbers numbers) {
    Light light = sample_emitter(numbers.light.x);
    Emission emission = emit_from(light, numbers.position, numbers.direction, numbers.light.y);
    emission.weight /= light.emission_pmf * scene.mean_power;
    if (HAS_GUIDE) {
        emission.weight *= numbers.weight;
    }
    if (HAS_MEDIA && light.kind != AREA) {
        emission.ray.medium = light.medium;
    }
    return emission;
}

// Whether the light of a photon is one that no ray meets.
bool is_from_unmet_light(Random random) {
    if (HAS_HITTABLE_LIGHTS) {
        Light light = sample_emitter(emission_numbers(random).light.x);
        bool is_infinite = light.kind == INFINITE || light.kind == SKY || light.kind == PORTAL;
        return light.kind == AREA ? light.reach2 == 0.0 : !is_infinite;
    }
    return true;
}

// Whether the first segment of a photon's path, of this length, ends before the portal of its light: such light is not
// seen.
bool ends_before_portal(Random random, Ray ray, float t) {
    Light light = sample_emitter(emission_numbers(random).light.x);
    if (light.kind == PORTAL) {
        Portal portal = portal_of(light_images_at(light.primitive));
        return t * dot(ray.direction, portal.normal) > dot(portal.corner - ray.origin, portal.normal);
    }
    return false;
}
