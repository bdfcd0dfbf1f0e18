// update: turns the flux of an iteration into radiance, adds it to the image, and shrinks the pixel's
// radius.
//
// Invocations: one per pixel.
// Reads: visible_radii2, visible_throughputs, visible_radiances, and flux_red, flux_green, flux_blue,
//   flux_counts, which it clears.
// Writes: sum_red, sum_green, sum_blue, sum_second (exact, see sum.glsl), pixel_states, counters
//   (atomic).
// Units: radiance in W/(m^2 sr); the sums in the unit 1 / per_unit.
// Source: Hachisuka and Jensen 2009, equations 6 to 9, scale the flux of all earlier iterations when the
//   radius shrinks: tau' / r'^2 = (tau + phi) / r^2. So tau / r^2 is the sum over iterations of
//   phi / r^2, each with its own radius, and the image is the mean of the images of its iterations,
//   however their radii were chosen (Knaus and Zwicker 2011, section 3).
#version 460
#include "kernel/complete.glsl"
#include "kernel/counters.glsl"
#include "kernel/invocation.glsl"
#include "lookup/data_radius.glsl"
#include "lookup/flux.glsl"
#include "lookup/flux_counts.glsl"
#include "lookup/flux_sums.glsl"
#include "lookup/records.glsl"
#include "lookup/shrink.glsl"
#include "math/sum.glsl"
#include "scene/constants.glsl"
#include "scene/features.glsl"

TEXELS(float, visible_radii2)
TEXELS(vec4, visible_throughputs)
TEXELS(vec4, visible_radiances)
UPDATED_TEXELS(PixelState, pixel_states)
GROUPED_UPDATED_TEXELS(sums, uvec4, sum_red)
GROUPED_UPDATED_TEXELS(sums, uvec4, sum_green)
GROUPED_UPDATED_TEXELS(sums, uvec4, sum_blue)
GROUPED_UPDATED_TEXELS(sums, uvec4, sum_second) // luminance, second half of the rounds only

layout(push_constant) uniform Push {
    vec3 luminance;      // luminance of each channel in the image, so after its white balance
    uint pixel_count;    // number of pixels
    float alpha;         // share of an iteration's photons that is kept, in (0, 1]
    float per_unit;      // 1 over the unit of the sums, m^2 sr/W
    float flux_scale;    // mean flux of a photon over pi and the unit of the sums
    uint half_of_rounds; // 0 or 1
    uint capacity;       // photons that a batch may record
    float rough_scale;   // flux_scale over the squared radius of the largest disc of rough points
    float kept;          // share of a pixel's sums of discs that stays: data_radius.glsl
    uint pad0;           // unused
};

// Reads the flux of a pixel and the count of its photons, and clears both.
vec3 take_flux(uint pixel, out uint count) {
    uint at = place_of_count(pixel);
    count = flux_counts.data[at];
    vec3 flux = vec3(0.0);
    if (count > 0u) {
        flux = to_floats(load_flux(pixel));
        store_flux(pixel, Flux(uvec3(0u), uvec3(0u)));
        flux_counts.data[at] = 0u;
    }
    return flux;
}

// Reads what the rough point of a pixel has gathered, and clears it.
vec3 take_rough_flux(uint pixel) {
    uint place = pixel_count + pixel;
    Flux flux = load_flux(place);
    if ((flux.low | flux.high) == uvec3(0u)) {
        return vec3(0.0);
    }
    store_flux(place, Flux(uvec3(0u), uvec3(0u)));
    return to_signed_floats(flux);
}

// Reads the number of a pixel's photons on the inner half of its disc, and clears it.
uint take_inner(uint pixel) {
    uint at = place_of_count(pixel) + 1u;
    uint inner = flux_counts.data[at];
    flux_counts.data[at] = 0u;
    return inner;
}

uvec4 term_of(float radiance) {
    if (HAS_SIGNED_FILTER) {
        return to_signed_term(radiance);
    }
    if (HAS_DISPERSION) {
        return to_signed_term(radiance);
    }
    return to_term(radiance);
}

void main() {
    uint pixel = invocation_index();
    if (pixel >= pixel_count || !is_complete(capacity)) {
        return;
    }
    uint count;
    vec3 flux = take_flux(pixel, count);
    vec3 radiance = per_unit * visible_radiances_at(pixel).rgb;
    if (count > 0u) {
        float radius2 = visible_radii2_at(pixel);
        radiance += visible_throughputs_at(pixel).rgb * flux * (flux_scale / radius2);
    }
    if (HAS_ROUGH_GATHER) {
        radiance += rough_scale * take_rough_flux(pixel);
    }
    if (any(isnan(radiance))) {
        atomicAdd(counters.value.non_finite, 1u);
        radiance = vec3(0.0);
    }
    if (!all(lessThan(abs(radiance), vec3(MAX_TERM)))) {
        atomicAdd(counters.value.saturated, 1u);
        vec3 largest = mix(vec3(LARGEST_TERM), vec3(-LARGEST_TERM), lessThan(radiance, vec3(0.0)));
        radiance = mix(largest, radiance, lessThan(abs(radiance), vec3(MAX_TERM)));
    }
    store_sum_red(pixel, add_exactly(sum_red_at(pixel), term_of(radiance.r)));
    store_sum_green(pixel, add_exactly(sum_green_at(pixel), term_of(radiance.g)));
    store_sum_blue(pixel, add_exactly(sum_blue_at(pixel), term_of(radiance.b)));

    if (half_of_rounds == 1u) {
        // The weights may add up to more than 1.
        float bounded = clamp(dot(radiance, luminance), -LARGEST_TERM, LARGEST_TERM);
        store_sum_second(pixel, add_exactly(sum_second_at(pixel), term_of(bounded)));
    }

    if (HAS_DATA_RADII) {
        DiscSums sums = disc_sums(pixel_states_at(pixel));
        add_disc(sums, count, take_inner(pixel), visible_radii2_at(pixel), kept);
        store_pixel_states(pixel, state_of(sums));
    } else if (count > 0u) {
        PixelState state = pixel_states_at(pixel);
        shrink_radius(state, count, alpha);
        store_pixel_states(pixel, state);
    }
}
