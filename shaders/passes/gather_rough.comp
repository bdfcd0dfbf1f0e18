// gather_rough: sums, for each rough point, the photons on its disc, each times the BSDF for the direction that it came
// from.
//
// Invocations: one per pixel. One that has looked at many photons stores its position in `places` and counts as
//   unfinished; another dispatch goes on from there, so that no dispatch is long.
// Reads: the scene (set 0), rough_points, grid_extent, cells, grid_photons; places where it resumes.
// Writes: flux_red, flux_green, flux_blue (the second half), places, counters (atomic).
// Units: lengths in render units; sums as rough_flux.glsl says.
// Source: Jensen, "Global Illumination using Photon Maps", 1996, equation 8. The radius follows the length of the eye
//   path and shrinks by the same factor for all points (Knaus and Zwicker 2011, equation 20), since two points of a
//   pixel may lie on different surfaces.
#version 460
#include "geometry/normal.glsl"
#include "geometry/surface_point.glsl"
#include "kernel/counters.glsl"
#include "kernel/interruption.glsl"
#include "kernel/invocation.glsl"
#include "lookup/disc.glsl"
#include "lookup/flux.glsl"
#include "lookup/flux_sums.glsl"
#include "lookup/grid.glsl"
#include "lookup/records.glsl"
#include "lookup/rough.glsl"
#include "material/bsdf.glsl"
#include "material/bump.glsl"
#include "material/glossy.glsl"
#include "scene/constants.glsl"
#include "scene/features.glsl"
#include "scene/materials.glsl"
#include "scene/scene.glsl"

// Where an invocation has got to.
struct RoughPlace {
    uint cell;  // number of the cell among those that the disc may touch
    uint entry; // number of the photon among those of the cell
};

TEXELS(RoughPoint, rough_points)
VALUE(GridExtent, grid_extent)
BUFFER(Cell, cells)
TEXELS(PhotonRecord, grid_photons)
UPDATED_BUFFER(RoughPlace, places)

layout(push_constant) uniform Push {
    uint pixel_count; // number of pixels
    uint resumed;     // 1 to go on from `places`
    uint offset;      // first invocation of this dispatch
    float per_length; // first radius over the length of the eye path
    float least;      // least first radius, render units
    float most;       // largest first radius, render units
    float shrink;      // factor of the squared radius, the same for all points
    float radius2;     // squared radius of the largest disc, by which the photons were sorted
};

// Photons that a lane looks at, at most, to find its next one before all lanes evaluate theirs.
const uint MAX_STEPS = 16u;
// Rounds of one dispatch: each has up to MAX_STEPS rounds of its own and those of a measured BSDF, and all are fewer than
// the 65,535 that llvmpipe allows an invocation.
const uint MAX_ROUNDS = 1600u;
// The largest term of a sum.
const float MOST = 34359738368.0; // 2^35

// What an invocation gathers for.
struct Point {
    vec3 position;
    vec3 wo;
    float radius2;   // squared radius of the disc
    vec3 factor;     // throughput times the area of the largest disc over that of the disc
    bool is_negative; // the throughput is, and the factor is not
    Surface surface;
    Material material;
    ivec3 first;     // cell of the disc's lower corner
    ivec3 size;      // cells along each axis that the disc may touch
};

Point load_point(RoughPoint rough, float inverse_size) {
    float radius = clamp(per_length * rough.path_length, least, most);
    // Widened, so that rounding leaves no cell out.
    float reach = 1.0001 * radius * sqrt(shrink);
    ivec3 first = cell_of(rough.position - reach, inverse_size);
    ivec3 last = cell_of(rough.position + reach, inverse_size);
    float area_ratio = most / radius;
    vec3 throughput = rough.throughput;
    bool is_negative = any(lessThan(throughput, vec3(0.0)));
    if (HAS_DISPERSION) {
        is_negative = false; // each term has its signs
    }
    throughput = is_negative ? abs(throughput) : throughput;
    return Point(rough.position, rough.wo, radius * radius * shrink, throughput * (area_ratio * area_ratio),
                 is_negative, surface_of(rough), material_of(rough), first, last - first + 1);
}

// A cell of those that the disc may touch, by its number.
ivec3 cell_at(Point point, uint number) {
    int i = int(number);
    return point.first + ivec3(i % point.size.x, (i / point.size.x) % point.size.y, i / (point.size.x * point.size.y));
}

// Whether a photon lies on the disc. Only what refracts light is met on both sides: elsewhere the direction of the
// photon tells the side.
bool is_met(Point point, PhotonRecord photon) {
    vec3 d = photon.position - point.position;
    vec3 n = unpack_normal(photon.normal);
    n = point.material.kind != DIELECTRIC && dot(n, point.surface.normal) < 0.0 ? -n : n;
    return dot(d, d) < point.radius2 && is_on_disc(d, n, point.surface.normal, point.radius2);
}

// The radiance towards the eye by a photon, in the units of the sums.
vec3 term_of(Point point, PhotonRecord photon) {
    vec3 wi = unpack_normal(photon.cell);
    Surface surface = point.surface;
    vec3 value = evaluate_bsdf(point.material, point.wo, wi, surface.shading_normal, surface.tangent, RADIANCE).value;
    value *= media_factor(surface, point.material, point.wo, wi);
    float cosine = max(abs(dot(wi, surface.shading_normal)), 1.0e-6);
    return photon.weight * value * point.factor / cosine;
}

// Adds a term to a sum; counts one that would not fit.
void add_term(inout Flux sum, vec3 term) {
    if (!all(lessThan(abs(term), vec3(MOST)))) {
        atomicAdd(counters.value.saturated, 1u);
        return;
    }
    uvec2 red = to_words(term.r);
    uvec2 green = to_words(term.g);
    uvec2 blue = to_words(term.b);
    uvec3 low = uvec3(red.x, green.x, blue.x);
    uvec3 high = uvec3(red.y, green.y, blue.y);
    uvec3 before = sum.high;
    sum.low += low;
    uvec3 carry = mix(uvec3(0u), uvec3(1u), lessThan(sum.low, low));
    sum.high += high + carry;
    uvec3 overflow = sum.high;
    if (HAS_DISPERSION) {
        overflow = (before ^ sum.high) & (high ^ sum.high);
    }
    if (any(greaterThanEqual(overflow, uvec3(0x80000000u)))) {
        atomicAdd(counters.value.saturated, 1u);
    }
}

// Adds what has been gathered to the pixel's sum, which no other invocation changes.
void add_to_pixel(Flux sum, bool is_negative, uint pixel) {
    if (is_negative) {
        sum = opposite(sum);
    }
    Flux before = load_flux(pixel_count + pixel);
    uvec3 low = before.low + sum.low;
    store_flux(pixel_count + pixel,
               Flux(low, before.high + sum.high + mix(uvec3(0u), uvec3(1u), lessThan(low, sum.low))));
}

void main() {
    uint pixel = offset + invocation_index();
    if (pixel >= pixel_count || grid_extent.value.recorded == 0u) {
        return;
    }
    RoughPoint rough = rough_points_at(pixel);
    RoughPlace place = RoughPlace(0u, 0u);
    if (resumed != 0u) {
        place = places.data[pixel];
    }
    float inverse_size = 1.0 / cell_size(floatBitsToUint(radius2));
    Point point = load_point(rough, inverse_size);
    uint count = rough.path_length > 0.0 ? uint(point.size.x * point.size.y * point.size.z) : 0u;
    Flux sum = Flux(uvec3(0u), uvec3(0u));
    ivec3 at = cell_at(point, place.cell);
    Cell cell = cells.data[cell_hash(at, grid_extent.value.cell_mask)];
    for (uint round = 0u; round < MAX_ROUNDS && place.cell < count; round++) {
        // All lanes look for their next photon before any lane evaluates the BSDF, so that few are idle.
        bool found = false;
        PhotonRecord photon;
        for (uint i = 0u; i < MAX_STEPS && place.cell < count && !found; i++) {
            if (place.entry < cell.count) {
                photon = grid_photons_at(cell.first + place.entry);
                // Photons of other cells may have the same hash.
                found = cell_of(photon.position, inverse_size) == at && is_met(point, photon);
                place.entry++;
            } else {
                place = RoughPlace(place.cell + 1u, 0u);
                at = cell_at(point, place.cell);
                cell = cells.data[cell_hash(at, grid_extent.value.cell_mask)];
            }
        }
        if (found) {
            add_term(sum, term_of(point, photon));
        }
    }
    if ((sum.low | sum.high) != uvec3(0u)) {
        add_to_pixel(sum, point.is_negative, pixel);
    }
    places.data[pixel] = place;
    if (place.cell < count) {
        atomicAdd(counters.value.unfinished, 1u);
    }
    if (interrupted()) {
        atomicAdd(counters.value.interrupted, 1u);
    }
}
