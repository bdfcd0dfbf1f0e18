// Skies that are seen through a rectangle, the portal. Light reaches a point along those directions in which the
// portal lies, on the side of the sky.
//
// Next-event estimation takes one of two densities by chance, and weighs a sample by the mean of both (the balance
// heuristic, Veach 1997, section 9.2): the image's, and that of the rectified window: uniform in the two angles
// atan(x / z) and atan(y / z) about the axes of the portal (Bitterli and others 2015, "Portal-masked environment map
// sampling", section 3).
#include "light/light_image.glsl"
#include "math/equal_area.glsl"
#include "math/sampling.glsl"
#include "scene/constants.glsl"
#include "scene/lights.glsl"
#include "scene/scene.glsl"

// A portal, render units.
struct Portal {
    vec3 corner;
    vec3 x_edge;
    vec3 y_edge;
    vec3 normal; // points to the sky; of unit length
};

// A direction to a portal's sky.
struct PortalSample {
    vec3 direction;
    vec3 color;
    float pdf;      // by solid angle, 1/sr; 0 if the direction does not lead through the portal
};

Portal portal_of(LightImage image) {
    vec3 corner = light_texels_at(image.first - 3u).color;
    vec3 x_edge = light_texels_at(image.first - 2u).color;
    vec3 y_edge = light_texels_at(image.first - 1u).color;
    return Portal(corner, x_edge, y_edge, normalize(cross(x_edge, y_edge)));
}

// Whether a ray leads through the portal.
bool leads_through(Portal portal, vec3 from, vec3 w) {
    float height = dot(portal.corner - from, portal.normal);
    float facing = dot(w, portal.normal);
    if (height <= 0.0 || facing <= 0.0) {
        return false;
    }
    vec3 point = from + w * (height / facing) - portal.corner;
    vec2 place = vec2(dot(point, portal.x_edge) / dot(portal.x_edge, portal.x_edge),
                      dot(point, portal.y_edge) / dot(portal.y_edge, portal.y_edge));
    return place == clamp(place, 0.0, 1.0);
}

// The first angle of the window along an axis of the portal, and its extent. x is along that axis.
vec2 window_angles(float x, float length, float height) {
    return vec2(atan(x, height), atan(length * height, height * height + x * (x + length)));
}

// Pdf of an image's density in a direction, whose color is returned.
float portal_image_pdf(LightImage image, vec3 w, out vec3 color) {
    uint texel = texel_index(image, equal_area_point(to_image(image, w)));
    color = light_texels_at(texel).color;
    float weight = light_texels_at(texel + image.width * image.height).color.x;
    // All of the sky that is seen may be black.
    return mean_of_channels(color) * weight / (4.0 * PI * max(image.average, 1.0e-30));
}

// Pdf of the rectified window by solid angle.
float window_pdf(Portal portal, vec3 from, vec3 w) {
    float x_length = length(portal.x_edge);
    float y_length = length(portal.y_edge);
    vec3 x_axis = portal.x_edge / x_length;
    vec3 y_axis = portal.y_edge / y_length;
    vec3 to_corner = portal.corner - from;
    float height = dot(to_corner, portal.normal);
    float extent = window_angles(dot(to_corner, x_axis), x_length, height).y
                 * window_angles(dot(to_corner, y_axis), y_length, height).y;
    float facing = dot(w, portal.normal);
    float x = dot(w, x_axis);
    float y = dot(w, y_axis);
    // Solid angle over the product of the angles: facing (1 / ((1 - x^2) (1 - y^2))), for unit directions.
    return facing / ((1.0 - x * x) * (1.0 - y * y) * max(extent, 1.0e-20));
}

// Evaluates a portal's sky in a direction, with the pdf of sample_portal.
PortalSample look_through_portal(LightImage image, vec3 from, vec3 w) {
    Portal portal = portal_of(image);
    PortalSample found = PortalSample(w, vec3(0.0), 0.0);
    if (leads_through(portal, from, w)) {
        float by_image = portal_image_pdf(image, w, found.color);
        found.pdf = 0.5 * (by_image + window_pdf(portal, from, w));
    }
    return found;
}

// Samples a direction from a point through a portal.
PortalSample sample_portal(LightImage image, vec3 from, vec2 u) {
    Portal portal = portal_of(image);
    bool by_window = u.x < 0.5;
    u.x = by_window ? 2.0 * u.x : 2.0 * u.x - 1.0;
    vec3 w = sample_equal_area(image, u).direction;
    if (by_window) {
        vec3 x_axis = normalize(portal.x_edge);
        vec3 y_axis = normalize(portal.y_edge);
        vec3 to_corner = portal.corner - from;
        float height = dot(to_corner, portal.normal);
        vec2 x = window_angles(dot(to_corner, x_axis), length(portal.x_edge), height);
        vec2 y = window_angles(dot(to_corner, y_axis), length(portal.y_edge), height);
        w = normalize(tan(x.x + u.x * x.y) * x_axis + tan(y.x + u.y * y.y) * y_axis + portal.normal);
    }
    return look_through_portal(image, from, w);
}
