// The wavelength of a path, and what depends on it.
//
// A wavelength is a number in [0, 1), uniform over paths: the share of paths with a shorter one. It is in one of
// BANDS bands of the same width. src/scene/spectrum/wavelength.rs says which wavelengths in nm a band has; kernels
// need only what a table says of the band.
//
// The color of a path is that of its wavelength: linear RGB, whose mean over all wavelengths is white. Single
// wavelengths lie outside of sRGB, so colors have negative channels, and sums of flux and radiance keep them. Where
// paths of neighbouring wavelengths end at places that the image does not tell apart, the color is the mean over those
// wavelengths: less noise of color, and none where glass does not split light visibly (spread.glsl).
#include "scene/materials.glsl"
#include "scene/scene.glsl"

// The wavelength of a path, and half the width of the wavelengths that its color is a mean of, in (0, 1].
struct Hue {
    float wavelength; // negative: the path has none, it carries all of them
    float window;
};

Hue no_hue() {
    return Hue(-1.0, 1.0);
}

bool has_wavelength(Hue hue) {
    return hue.wavelength >= 0.0;
}

// The place of a wavelength among the bands.
float place_of(Hue hue) {
    return min(hue.wavelength * float(BANDS), float(BANDS) - 1.0e-3);
}

// The element of a table of texture_texels that has one for each band.
vec4 at_wavelength(uint table, Hue hue) {
    return uintBitsToFloat(texture_texels_at(table + uint(place_of(hue))));
}

// Integral of the color from 0 to x in [-1, 2], over a table of these integrals at the ends of bands. Beyond 0 and 1
// wavelengths are mirrored, so that the mean over all wavelengths stays what it is, however wide the window.
vec3 integral_of_color(uint table, float x) {
    float mirrored = x > 1.0 ? 2.0 - x : abs(x);
    float place = min(mirrored * float(BANDS), float(BANDS));
    uint band = min(uint(place), BANDS - 1u);
    vec3 low = uintBitsToFloat(texture_texels_at(table + band).xyz);
    vec3 high = uintBitsToFloat(texture_texels_at(table + band + 1u).xyz);
    vec3 integral = mix(low, high, place - float(band));
    vec3 whole = uintBitsToFloat(texture_texels_at(table + BANDS).xyz);
    return x > 1.0 ? 2.0 * whole - integral : x < 0.0 ? -integral : integral;
}

// The color of a path, by a table of integrals: scene.colors, or those of a light.
vec3 color_of(uint table, Hue hue) {
    if (!has_wavelength(hue)) {
        return vec3(1.0);
    }
    float half_width = clamp(hue.window, 0.5 / float(BANDS), 1.0);
    vec3 sum = integral_of_color(table, hue.wavelength + half_width) - integral_of_color(table, hue.wavelength - half_width);
    return sum / (2.0 * half_width);
}
