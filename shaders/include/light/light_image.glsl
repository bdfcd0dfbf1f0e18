// Images of lights: the color of a direction, and directions sampled by color. The conventions are those
// of src/geometry/equal_area.rs and src/scene/directives/light_image.rs.
#include "math/equal_area.glsl"
#include "math/sampling.glsl"
#include "scene/features.glsl"
#include "scene/lights.glsl"
#include "scene/scene.glsl"

// A direction sampled by the color of its texel.
struct ImageSample {
    vec3 direction; // sky: from which light arrives; point light: in which light leaves
    vec3 color;
    float pdf;      // by solid angle, 1/sr
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

// x with the sign of s, where 0 is positive.
vec2 with_signs(vec2 x, vec2 s) {
    return vec2(s.x < 0.0 ? -x.x : x.x, s.y < 0.0 ? -x.y : x.y);
}

// The point of the unit square for a unit direction; equal_area_direction inverts it.
vec2 equal_area_point(vec3 w) {
    float r = length(w.xy) * inversesqrt(1.0 + abs(w.z));
    float turn = atan(abs(w.y), abs(w.x)) * (2.0 / PI);
    vec2 p = vec2(r - r * turn, r * turn);
    p = w.z < 0.0 ? 1.0 - p.yx : p;
    return 0.5 + 0.5 * with_signs(p, w.xy);
}

// Index of the texel at a point of the unit square.
uint texel_index(LightImage image, vec2 point) {
    uvec2 last = uvec2(image.width, image.height) - 1u;
    uvec2 at = min(uvec2(max(point, 0.0) * vec2(last + 1u)), last);
    return image.first + image.height + at.y * image.width + at.x;
}

vec3 equal_area_color(LightImage image, vec3 w) {
    return light_texels_at(texel_index(image, equal_area_point(to_image(image, w)))).color;
}

// Pdf by solid angle with which sample_equal_area finds a direction of this color.
float equal_area_pdf(LightImage image, vec3 color) {
    return mean_of_channels(color) / (4.0 * PI * image.average);
}

// Color of a projector's image in direction w; 0 outside of the image.
vec3 projected_color(LightImage image, vec3 w) {
    vec3 local = to_image(image, w);
    vec2 point = 0.5 + 0.5 * local.xy / (max(local.z, 1.0e-20) * image.half_extent);
    bool inside = local.z > 0.0 && point == clamp(point, 0.0, 1.0);
    vec3 color = light_texels_at(texel_index(image, inside ? point : vec2(0.0))).color;
    return inside ? color : vec3(0.0);
}

// Samples an entry of an alias table (Vose 1991) by u, which is uniform again afterwards.
uint sample_alias_table(uint first, uint count, inout float u) {
    float scaled = u * float(count);
    uint entry = min(uint(scaled), count - 1u);
    float rest = scaled - float(entry);
    uint choice = light_texels_at(first + entry).choice;
    float threshold = float(choice & 0xffffu) * (1.0 / 65536.0);
    bool keep = rest < threshold;
    u = keep ? rest / threshold : (rest - threshold) / (1.0 - threshold);
    return keep ? entry : choice >> 16u;
}

// Chance of an entry of a cumulative table and of those before it.
float cumulative_chance(uint first, uint entry) {
    return float(light_texels_at(first + entry).choice) * (1.0 / 4294967296.0);
}

// Samples an entry of a cumulative table by u, which is uniform again afterwards. The entries rise with u.
uint sample_cumulative_table(uint first, uint count, inout float u) {
    uint entry = 0u;
    for (uint last = count - 1u; entry < last;) {
        uint middle = (entry + last) / 2u;
        bool is_before = u >= cumulative_chance(first, middle);
        entry = is_before ? middle + 1u : entry;
        last = is_before ? last : middle;
    }
    float begin = entry > 0u ? cumulative_chance(first, entry - 1u) : 0.0;
    float chance = cumulative_chance(first, entry) - begin;
    u = clamp((u - begin) / max(chance, 1.0e-30), 0.0, 0.99999994);
    return entry;
}

// Samples an entry of the table of a row, or of the rows. Guided emission needs neighbours to stay neighbours.
uint sample_table(uint first, uint count, inout float u) {
    if (HAS_GUIDE) {
        return sample_cumulative_table(first, count, u);
    }
    return sample_alias_table(first, count, u);
}

// Samples a texel by its row and column. Returns a point in it; `middle` is its centre.
vec2 sample_texel(LightImage image, vec2 u, out vec2 middle, out vec3 color) {
    uint row = sample_table(image.first, image.height, u.y);
    uint column = sample_table(image.first + image.height + row * image.width, image.width, u.x);
    vec2 corner = vec2(column, row);
    vec2 size = vec2(image.width, image.height);
    color = light_texels_at(image.first + image.height + row * image.width + column).color;
    middle = (corner + 0.5) / size;
    return (corner + u) / size;
}

ImageSample sample_equal_area(LightImage image, vec2 u) {
    vec2 middle;
    vec3 color;
    vec2 point = sample_texel(image, u, middle, color);
    return ImageSample(from_image(image, equal_area_direction(point)), color, equal_area_pdf(image, color));
}

// The point of a projector's window, on the plane z = 1, for a point of the unit square.
vec3 window_point(LightImage image, vec2 point) {
    return vec3((2.0 * point - 1.0) * image.half_extent, 1.0);
}

ImageSample sample_projection(LightImage image, vec2 u) {
    vec2 middle;
    vec3 color;
    vec3 to = window_point(image, sample_texel(image, u, middle, color));
    // Texels are chosen by their solid angle as if it were that of their centre in all points: area of the
    // window over the cube of the distance.
    float cubes = pow(dot(to, to) / dot(window_point(image, middle), window_point(image, middle)), 1.5);
    float area = 4.0 * image.half_extent.x * image.half_extent.y;
    float pdf = mean_of_channels(color) * cubes / (area * image.average);
    return ImageSample(from_image(image, normalize(to)), color, pdf);
}
