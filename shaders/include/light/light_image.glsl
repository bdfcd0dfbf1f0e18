// Images of lights: colours by direction, and directions by the power that comes from them.
// src/octahedral.rs and src/scene/light_image.rs have the conventions.
#include "math/equal_area.glsl"
#include "math/sampling.glsl"
#include "scene/lights.glsl"
#include "scene/scene.glsl"

// A place in an image by the power that comes through it.
struct ImageSample {
    vec3 direction; // from which a sky shines, to which a point does
    vec3 color;
    float pdf;      // solid angle
};

float mean_of_channels(vec3 color) {
    return (color.x + color.y + color.z) / 3.0;
}

vec3 to_image(LightImage image, vec3 w) {
    return vec3(dot(image.x_axis, w), dot(image.y_axis, w), dot(image.z_axis, w));
}

vec3 from_image(LightImage image, vec3 w) {
    return image.x_axis * w.x + image.y_axis * w.y + image.z_axis * w.z;
}

// x with the sign of s, which is positive for 0.
vec2 with_signs(vec2 x, vec2 s) {
    return vec2(s.x < 0.0 ? -x.x : x.x, s.y < 0.0 ? -x.y : x.y);
}

// The place of a unit direction.
vec2 octahedral_place(vec3 w) {
    float r = length(w.xy) * inversesqrt(1.0 + abs(w.z));
    float turn = atan(abs(w.y), abs(w.x)) * (2.0 / PI);
    vec2 p = vec2(r - r * turn, r * turn);
    p = w.z < 0.0 ? 1.0 - p.yx : p;
    return 0.5 + 0.5 * with_signs(p, w.xy);
}

// The texel at a place in the unit square.
uint texel_at_place(LightImage image, vec2 place) {
    uvec2 last = uvec2(image.width, image.height) - 1u;
    uvec2 at = min(uvec2(max(place, 0.0) * vec2(last + 1u)), last);
    return image.first + image.height + at.y * image.width + at.x;
}

vec3 octahedral_color(LightImage image, vec3 w) {
    return light_texels_at(texel_at_place(image, octahedral_place(to_image(image, w)))).color;
}

// Pdf, by solid angle, with which sample_octahedral finds a color.
float octahedral_pdf(LightImage image, vec3 color) {
    return mean_of_channels(color) / (4.0 * PI * image.average);
}

// What a projector lets through in direction w.
vec3 projected_color(LightImage image, vec3 w) {
    vec3 local = to_image(image, w);
    vec2 place = 0.5 + 0.5 * local.xy / (max(local.z, 1.0e-20) * image.half_extent);
    bool inside = local.z > 0.0 && place == clamp(place, 0.0, 1.0);
    vec3 color = light_texels_at(texel_at_place(image, inside ? place : vec2(0.0))).color;
    return inside ? color : vec3(0.0);
}

// Chooses one of an alias table's entries by u, which is uniform again after that.
uint choose(uint first, uint count, inout float u) {
    float scaled = u * float(count);
    uint entry = min(uint(scaled), count - 1u);
    float rest = scaled - float(entry);
    uint choice = light_texels_at(first + entry).choice;
    float threshold = float(choice & 0xffffu) * (1.0 / 65536.0);
    bool keep = rest < threshold;
    u = keep ? rest / threshold : (rest - threshold) / (1.0 - threshold);
    return keep ? entry : choice >> 16u;
}

// The place, the middle of its texel, and the color there.
vec2 sample_place(LightImage image, vec2 u, out vec2 middle, out vec3 color) {
    uint row = choose(image.first, image.height, u.y);
    uint column = choose(image.first + image.height + row * image.width, image.width, u.x);
    vec2 corner = vec2(column, row);
    vec2 size = vec2(image.width, image.height);
    color = light_texels_at(image.first + image.height + row * image.width + column).color;
    middle = (corner + 0.5) / size;
    return (corner + u) / size;
}

ImageSample sample_octahedral(LightImage image, vec2 u) {
    vec2 middle;
    vec3 color;
    vec2 place = sample_place(image, u, middle, color);
    return ImageSample(from_image(image, equal_area_direction(place)), color, octahedral_pdf(image, color));
}

// A point of the window on the plane z = 1.
vec3 window_point(LightImage image, vec2 place) {
    return vec3((2.0 * place - 1.0) * image.half_extent, 1.0);
}

ImageSample sample_projection(LightImage image, vec2 u) {
    vec2 middle;
    vec3 color;
    vec3 to = window_point(image, sample_place(image, u, middle, color));
    // Texels are chosen by the solid angle at their middle; a solid angle is the area of the
    // window over the cube of the distance.
    float cubes = pow(dot(to, to) / dot(window_point(image, middle), window_point(image, middle)), 1.5);
    float area = 4.0 * image.half_extent.x * image.half_extent.y;
    float pdf = mean_of_channels(color) * cubes / (area * image.average);
    return ImageSample(from_image(image, normalize(to)), color, pdf);
}
