// Measured materials (Dupuy and Jakob, "An Adaptive Parameterization for Efficient Material Acquisition and
// Rendering", 2018). src/gpu_scene/pack/material/measured.rs makes the tables, which are in texture_texels.
//
// The direction wo, from which a path comes, is the incident direction of the tables. A point of the unit square
// selects, by the luminance seen from wo, another one, that selects a normal by the distribution of the normals
// visible from wo; wi is wo reflected about it. Colors are a table of the point between the two.
//
// Directions are in a frame with z along the normal; wo.z > 0. Other points of the unit square are directions: see
// point_of_direction.
#include "material/microfacet.glsl"
#include "math/circle.glsl"
#include "math/sampling.glsl"
#include "scene/scene.glsl"

// Where the parts of a table are, as indices of elements, and their sizes as columns and rows.
struct MeasuredTable {
    uvec2 normals_size;
    uvec2 area_size;
    uvec2 visible_size;
    uvec2 luminance_size; // of the colors, too
    uint azimuth_count;
    uint polar_count;
    bool is_isotropic;
    uint reduction; // how many times the range of azimuths goes into a full turn
    uint azimuths;
    uint polar_angles;
    uint normals;
    uint area;
    uint visible;
    uint luminance;
    uint colors;
};

vec4 measured_at(uint i) {
    return uintBitsToFloat(texture_texels_at(i));
}

MeasuredTable measured_table(uint first) {
    uvec4 sizes = texture_texels_at(first);
    uvec4 slice_sizes = texture_texels_at(first + 1u);
    uvec4 rest = texture_texels_at(first + 2u);
    MeasuredTable table;
    table.normals_size = sizes.xy;
    table.area_size = sizes.zw;
    table.visible_size = slice_sizes.xy;
    table.luminance_size = slice_sizes.zw;
    table.azimuth_count = rest.x;
    table.polar_count = rest.y;
    table.is_isotropic = rest.z != 0u;
    table.reduction = rest.w;
    uint slices = rest.x * rest.y;
    table.azimuths = first + 3u;
    table.polar_angles = table.azimuths + table.azimuth_count;
    table.normals = table.polar_angles + table.polar_count;
    table.area = table.normals + table.normals_size.x * table.normals_size.y;
    table.visible = table.area + table.area_size.x * table.area_size.y;
    table.luminance = table.visible + slices * table.visible_size.x * table.visible_size.y;
    table.colors = table.luminance + slices * table.luminance_size.x * table.luminance_size.y;
    return table;
}

// Azimuth of a direction from -pi to pi; 0 at the pole.
float azimuth_of(vec3 w) {
    return w.x == 0.0 && w.y == 0.0 ? 0.0 : atan(w.y, w.x);
}

float polar_angle_of(vec3 w) {
    return atan(length(w.xy), w.z);
}

// The point of the unit square of a direction: the square root of its polar angle over a right angle, and its azimuth
// in turns from -x on.
vec2 point_of_direction(float polar_angle, float azimuth) {
    return vec2(sqrt(polar_angle * (2.0 / PI)), fract(0.5 + azimuth / (2.0 * PI)));
}

// Slices of a table, and the weights by which they are interpolated between incident directions.
struct Blend {
    uvec4 slices;
    vec4 weights;
};

// The index of an angle's interval among angles of a table, and how far the angle is in it, from 0 to 1.
uint find_angle(uint first, uint count, float angle, out float part) {
    part = 0.0;
    uint low = 0u;
    uint high = max(count, 1u) - 1u;
    while (high > low + 1u) {
        uint middle = (low + high) / 2u;
        bool is_above = measured_at(first + middle).x > angle;
        low = is_above ? low : middle;
        high = is_above ? middle : high;
    }
    if (count > 1u) {
        vec4 node = measured_at(first + low);
        part = clamp((angle - node.x) * node.y, 0.0, 1.0);
    }
    return low;
}

Blend blend_of(MeasuredTable table, float polar_angle, float azimuth) {
    vec2 part;
    uint i = find_angle(table.azimuths, table.azimuth_count, azimuth, part.x);
    uint j = find_angle(table.polar_angles, table.polar_count, polar_angle, part.y);
    uint next_i = min(i + 1u, table.azimuth_count - 1u);
    uint next_j = min(j + 1u, table.polar_count - 1u);
    uvec2 rows = uvec2(i, next_i) * table.polar_count;
    vec2 rest = 1.0 - part;
    return Blend(uvec4(rows.x + j, rows.x + next_j, rows.y + j, rows.y + next_j),
                 vec4(rest.x * rest.y, rest.x * part.y, part.x * rest.y, part.x * part.y));
}

// An element of a grid that has slices. Isotropic materials have one azimuth.
vec4 blended(uint first, uvec2 size, Blend blend, uint at) {
    uvec4 places = first + blend.slices * (size.x * size.y) + at;
    vec4 sum = blend.weights.x * measured_at(places.x) + blend.weights.y * measured_at(places.y);
    if (blend.weights.z + blend.weights.w > 0.0) {
        sum += blend.weights.z * measured_at(places.z) + blend.weights.w * measured_at(places.w);
    }
    return sum;
}

// The cell of a point of the unit square, and the point's place in it.
uvec2 cell_of(vec2 point, uvec2 size, out vec2 place) {
    vec2 scaled = clamp(point, 0.0, 1.0) * vec2(size - 1u);
    uvec2 cell = min(uvec2(scaled), size - 2u);
    place = scaled - vec2(cell);
    return cell;
}

// A value of a grid without slices.
float value_at(uint first, uvec2 size, vec2 point) {
    vec2 place;
    uvec2 cell = cell_of(point, size, place);
    vec4 corners = measured_at(first + cell.y * size.x + cell.x);
    vec2 column = mix(corners.xy, corners.zw, place.y);
    return mix(column.x, column.y, place.x);
}

// An element of a grid that has slices, and the next one of its row, interpolated.
vec4 blended_along(uint first, uvec2 size, Blend blend, uint at, float x) {
    return mix(blended(first, size, blend, at), blended(first, size, blend, at + 1u), x);
}

// An element of a grid that has slices, and the one of the next row, interpolated.
vec4 blended_across(uint first, uvec2 size, Blend blend, uint at, float y) {
    return mix(blended(first, size, blend, at), blended(first, size, blend, at + size.x), y);
}

vec3 measured_color(MeasuredTable table, Blend blend, vec2 point) {
    vec2 place;
    uvec2 size = table.luminance_size;
    uvec2 cell = cell_of(point, size, place);
    uint at = cell.y * size.x + cell.x;
    vec4 upper = blended_along(table.colors, size, blend, at, place.x);
    vec4 lower = blended_along(table.colors, size, blend, at + size.x, place.x);
    return mix(upper, lower, place.y).xyz;
}

// A point of the unit square with a density that is bilinear between the values of a grid.
struct WarpedPoint {
    vec2 point;
    float pdf; // by area of the unit square
};

float density_scale(uvec2 size) {
    return float(size.x - 1u) * float(size.y - 1u);
}

float density_at(uint first, uvec2 size, Blend blend, vec2 point) {
    vec2 place;
    uvec2 cell = cell_of(point, size, place);
    uint at = cell.y * size.x + cell.x;
    vec4 values = blended_across(first, size, blend, at, place.y);
    return mix(values.x, values.y, place.x) * density_scale(size);
}

// The integral up to x, from 0 to 1, of a density that is linear from a to b.
float integral_of_linear(float a, float b, float x) {
    return x * (a + 0.5 * x * (b - a));
}

// Inverts integral_of_linear.
float invert_linear(float a, float b, float integral) {
    float root = sqrt(max(a * a + 2.0 * (b - a) * integral, 0.0));
    return clamp(2.0 * integral / max(a + root, 1.0e-30), 0.0, 1.0);
}

// Samples a point with the density of a grid: a row, then a place in it.
WarpedPoint sample_density(uint first, uvec2 size, Blend blend, vec2 u) {
    uint row = 0u;
    uint end = size.y - 1u;
    while (end > row + 1u) {
        uint middle = (row + end) / 2u;
        bool is_above = blended(first, size, blend, middle * size.x).w > u.y;
        row = is_above ? row : middle;
        end = is_above ? middle : end;
    }
    uint upper = row * size.x;
    uint lower = upper + size.x;
    float upper_integral = blended(first, size, blend, upper + size.x - 1u).z;
    float lower_integral = blended(first, size, blend, lower + size.x - 1u).z;
    float y = invert_linear(upper_integral, lower_integral, u.y - blended(first, size, blend, upper).w);
    float integral = u.x * mix(upper_integral, lower_integral, y);
    uint column = 0u;
    end = size.x - 1u;
    while (end > column + 1u) {
        uint middle = (column + end) / 2u;
        bool is_above = blended_across(first, size, blend, upper + middle, y).z > integral;
        column = is_above ? column : middle;
        end = is_above ? middle : end;
    }
    vec4 values = blended_across(first, size, blend, upper + column, y);
    float x = invert_linear(values.x, values.y, integral - values.z);
    vec2 point = (vec2(column, row) + vec2(x, y)) / vec2(size - 1u);
    return WarpedPoint(point, mix(values.x, values.y, x) * density_scale(size));
}

// The numbers by which sample_density finds a point; the pdf is that of the point.
WarpedPoint invert_density(uint first, uvec2 size, Blend blend, vec2 point) {
    vec2 place;
    uvec2 cell = cell_of(point, size, place);
    uint row = cell.y * size.x;
    vec4 upper = blended(first, size, blend, row + cell.x);
    vec4 lower = blended(first, size, blend, row + size.x + cell.x);
    float upper_integral = blended(first, size, blend, row + size.x - 1u).z;
    float lower_integral = blended(first, size, blend, row + 2u * size.x - 1u).z;
    vec3 values = mix(upper.xyz, lower.xyz, place.y);
    float integral = mix(upper_integral, lower_integral, place.y);
    float before = values.z + integral_of_linear(values.x, values.y, place.x);
    vec2 u = vec2(before / max(integral, 1.0e-30),
                  upper.w + integral_of_linear(upper_integral, lower_integral, place.y));
    return WarpedPoint(clamp(u, 0.0, 1.0), mix(values.x, values.y, place.x) * density_scale(size));
}

// Signs of directions in a frame that is right-handed on both sides. As in pbrt, a direction behind the surface is that
// in front of it through the point, and not in the mirror of the surface.
vec3 signs_of_side(bool outside) {
    return vec3(outside ? 1.0 : -1.0, 1.0, 1.0);
}

// Signs that turn wo to the azimuths of the table: of a material that looks the same after half a turn, or in a
// mirror along each axis.
vec2 signs_of(MeasuredTable table, vec3 wo) {
    vec2 signs = vec2(wo.x < 0.0 ? 1.0 : -1.0, wo.y < 0.0 ? 1.0 : -1.0);
    return table.reduction == 4u ? signs : table.reduction == 2u ? signs.yy : vec2(1.0);
}

// The incident direction of the tables.
struct Incident {
    float azimuth;
    float area; // of the microfacets, projected along it
    Blend blend;
};

Incident incident_of(MeasuredTable table, vec3 wo) {
    float azimuth = azimuth_of(wo);
    float polar_angle = polar_angle_of(wo);
    float area = value_at(table.area, table.area_size, point_of_direction(polar_angle, azimuth));
    return Incident(azimuth, area, blend_of(table, polar_angle, azimuth));
}

// Least area of the unit square's part per solid angle that a normal's direction takes: it is 0 along z.
const float LEAST_JACOBIAN = 1.0e-9;

// The BSDF for a normal at a point of the unit square. `u` selects that point, `density` is the pdf of both warps, and
// cos_m the cosine of wo and the normal, whose polar angle has the sine sin_m.
BsdfValue measured_value(MeasuredTable table, Incident incident, vec2 point, vec2 u, float density, float sin_m,
                         float cos_m) {
    float jacobian = max(2.0 * PI * PI * point.x * sin_m, LEAST_JACOBIAN);
    float facets = value_at(table.normals, table.normals_size, point) / (4.0 * incident.area);
    return BsdfValue(measured_color(table, incident.blend, u) * facets, density / (4.0 * cos_m * jacobian));
}

// Evaluates the BSDF: wi.z > 0. `first` is the first element of its table.
BsdfValue evaluate_measured(uint first, vec3 wo, vec3 wi) {
    MeasuredTable table = measured_table(first);
    vec2 signs = signs_of(table, wo);
    wo.xy *= signs;
    wi.xy *= signs;
    Incident incident = incident_of(table, wo);
    vec3 m = normalize(wo + wi);
    float azimuth = azimuth_of(m) - (table.is_isotropic ? incident.azimuth : 0.0);
    vec2 point = point_of_direction(polar_angle_of(m), azimuth);
    WarpedPoint visible = invert_density(table.visible, table.visible_size, incident.blend, point);
    float density = visible.pdf * density_at(table.luminance, table.luminance_size, incident.blend, visible.point);
    return measured_value(table, incident, point, visible.point, density, length(m.xy), max(dot(wo, m), 1.0e-6));
}

// Samples wi. `weight` is the BSDF times |cos| over the pdf; 0 where wi is below the horizon.
vec3 sample_measured(uint first, vec3 wo, vec2 u, out vec3 weight) {
    MeasuredTable table = measured_table(first);
    vec2 signs = signs_of(table, wo);
    wo.xy *= signs;
    Incident incident = incident_of(table, wo);
    WarpedPoint bright = sample_density(table.luminance, table.luminance_size, incident.blend, u);
    WarpedPoint visible = sample_density(table.visible, table.visible_size, incident.blend, bright.point);
    vec2 polar = circle_point(0.5 * PI * visible.point.x * visible.point.x);
    float azimuth = (2.0 * visible.point.y - 1.0) * PI + (table.is_isotropic ? incident.azimuth : 0.0);
    vec3 m = vec3(polar.y * circle_point(azimuth), polar.x);
    float cos_m = dot(wo, m);
    vec3 wi = 2.0 * cos_m * m - wo;
    float density = bright.pdf * visible.pdf;
    BsdfValue bsdf = measured_value(table, incident, visible.point, bright.point, density, polar.y, max(cos_m, 1.0e-6));
    bool is_above = cos_m > 0.0 && wi.z > 0.0 && bsdf.pdf > 0.0;
    weight = is_above ? bsdf.value / bsdf.pdf : vec3(0.0);
    wi.xy *= signs;
    return wi;
}
