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
    float slope;      // relative change of the path's weight per unit of wavelength: dispersion.glsl
    float widest;     // largest window: other wavelengths are not refracted where this one is, or the reverse
};

Hue no_hue() {
    return Hue(-1.0, 1.0, 0.0, 1.0);
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

// Integrals of a color from 0 to x: of the color, and of the color times the place of the wavelength in a curve.
struct ColorIntegrals {
    vec3 color;
    vec3 moment;
};

// Integrals from 0 to x in [-1, 2], over a table of these integrals at the ends of bands: those of the color, with the place
// in a curve, then those of its moment. Beyond 0 and 1 wavelengths are mirrored, so that the mean over all wavelengths
// stays what it is, however wide the window.
ColorIntegrals integrals_of_color(uint table, float x) {
    float mirrored = x > 1.0 ? 2.0 - x : abs(x);
    float place = min(mirrored * float(BANDS), float(BANDS));
    uint band = min(uint(place), BANDS - 1u);
    float t = place - float(band);
    vec4 low = uintBitsToFloat(texture_texels_at(table + band));
    vec4 high = uintBitsToFloat(texture_texels_at(table + band + 1u));
    uint moments = table + BANDS + 1u;
    vec3 moment = uintBitsToFloat(texture_texels_at(moments + band).xyz);
    moment += (high.rgb - low.rgb) * (t * mix(low.w, high.w, 0.5 * t));
    ColorIntegrals sum = ColorIntegrals(mix(low.rgb, high.rgb, t), moment);
    if (x > 1.0) {
        vec3 whole = uintBitsToFloat(texture_texels_at(table + BANDS).xyz);
        vec3 whole_moment = uintBitsToFloat(texture_texels_at(moments + BANDS).xyz);
        return ColorIntegrals(2.0 * whole - sum.color, 2.0 * whole_moment - sum.moment);
    }
    return x < 0.0 ? ColorIntegrals(-sum.color, -sum.moment) : sum;
}

// The color of a path, by a table of integrals: scene.colors, or those of a light. Neighbouring wavelengths count by the
// weights that their paths have, so that what boundaries take of them stays taken. Indices of glasses are nearly straight
// lines over the place in the curve, and so are the weights.
vec3 color_of(uint table, Hue hue) {
    if (!has_wavelength(hue)) {
        return vec3(1.0);
    }
    float half_width = clamp(min(hue.window, hue.widest), 0.5 / float(BANDS), 1.0);
    ColorIntegrals high = integrals_of_color(table, hue.wavelength + half_width);
    ColorIntegrals low = integrals_of_color(table, hue.wavelength - half_width);
    vec3 sum = high.color - low.color;
    uint band = uint(place_of(hue));
    float here = mix(uintBitsToFloat(texture_texels_at(table + band).w), uintBitsToFloat(texture_texels_at(table + band + 1u).w),
                     fract(place_of(hue)));
    vec3 moment = high.moment - low.moment - here * sum;
    return (sum + hue.slope * moment) / (2.0 * half_width);
}
