// tone_map: makes the pixels of a window from an image of linear radiance.
//
// Invocations: one per pixel of the window.
// Reads: shown. Writes: pixels.
// Units: shown is linear RGB, W/(m^2 sr), times `exposure`; pixels have 8 bits per channel.
//
// Colours outside of the gamut of sRGB have negative channels. They are interpolated as they are, and then mapped to the
// gamut.
//
// The image is interpolated, unless it is shown at one pixel of the window per pixel, or `nearest` says that its pixels
// are shown as squares.
#version 460
#include "kernel/invocation.glsl"
#include "scene/constants.glsl"

// How a window shows radiance.
export const uint CURVE_LINEAR = 0u; // as it is
export const uint CURVE_SRGB = 1u;   // as a PNG has it
export const uint CURVE_ACES = 2u;   // by the ACES curve
export const uint CURVE_AGX = 3u;    // by the AgX curve

TEXELS(vec4, shown) // linear RGB; w is unused
UPDATED_BUFFER(uint, pixels)

layout(push_constant) uniform Push {
    vec3 luminance; // of red, green and blue
    float exposure; // factor of the radiance
    uvec2 window;   // size, pixels
    uvec2 image;    // size, pixels
    vec2 origin;    // upper left corner of the image, in pixels of the window
    vec2 per_pixel; // pixels of the image per pixel of the window
    uint curve;     // one of CURVE_*
    uint bgra;      // 1 if blue is the lowest byte of a pixel, 0 if red is
    uint nearest;   // 1 if each pixel of the image is a square of one colour, 0 if pixels are interpolated
    uint pad0;      // unused
};

// sRGB color of the window around the image.
const vec3 BACKGROUND = vec3(0.02);
// Larger values count as this one, so that sums and differences of two are finite.
const float LARGEST = 1.0e38;

// A pixel of the image, as finite numbers that can be averaged: a channel that is NaN becomes 0, as in a PNG.
vec3 pixel_at(ivec2 at) {
    vec3 v = shown_at(uint(at.y) * image.x + uint(at.x)).rgb;
    vec3 above = mix(vec3(0.0), v, greaterThan(v, vec3(0.0)));
    vec3 below = mix(vec3(0.0), v, lessThan(v, vec3(0.0)));
    return min(above, vec3(LARGEST)) + max(below, vec3(-LARGEST));
}

// Bilinear interpolation between the centres of pixels.
vec3 sample_image(vec2 at) {
    vec2 base = floor(at);
    vec2 t = at - base;
    ivec2 last = ivec2(image) - 1;
    ivec2 low = clamp(ivec2(base), ivec2(0), last);
    ivec2 high = clamp(ivec2(base) + 1, ivec2(0), last);
    vec3 upper = mix(pixel_at(low), pixel_at(ivec2(high.x, low.y)), t.x);
    vec3 lower = mix(pixel_at(ivec2(low.x, high.y)), pixel_at(high), t.x);
    return mix(upper, lower, t.y);
}

// A color without negative channels, of the same luminance: into_gamut of src/image/film.rs, which says why. It is the
// mean of two colors on the border of the gamut: of a desaturated one, and of one whose negative channels are cut off.
// The factor of the radiance does not matter, so that it is not applied yet: it could make a channel infinite.
vec3 into_gamut(vec3 v) {
    float least = min(min(v.r, v.g), v.b);
    if (least >= 0.0) {
        return v;
    }
    float bright = dot(v, luminance);
    if (bright <= 0.0) {
        return vec3(0.0);
    }
    vec3 cut = max(v, vec3(0.0));
    return 0.5 * bright * ((v - least) / (bright - least) + cut / dot(cut, luminance));
}

// The sRGB transfer function, IEC 61966-2-1.
vec3 encode_srgb(vec3 v) {
    return mix(1.055 * pow(v, vec3(1.0 / 2.4)) - 0.055, 12.92 * v, lessThanEqual(v, vec3(0.0031308)));
}

// Narkowicz 2016, "ACES filmic tone mapping curve": a fit of the reference transforms' luminance.
vec3 aces_like(vec3 v) {
    v = min(v, vec3(1.0e4));
    return v * (2.51 * v + 0.03) / (v * (2.43 * v + 0.59) + 0.14);
}

// AgX (Sobotka 2022) as Wrensch 2023 approximates it: logarithms of inset primaries, and a polynomial
// for the sigmoid. The result is encoded for the screen.
vec3 agx(vec3 v) {
    const mat3 inset = mat3(0.842479062253094, 0.0423282422610123, 0.0423756549057051,
                            0.0784335999999992, 0.878468636469772, 0.0784336,
                            0.0792237451477643, 0.0791661274605434, 0.879142973793104);
    const mat3 outset = mat3(1.19687900512017, -0.0528968517574562, -0.0529716355144438,
                             -0.0980208811401368, 1.15190312990417, -0.0980434501171241,
                             -0.0990297440797205, -0.0989611768448433, 1.15107367264116);
    const float least = -12.47393; // stops
    const float most = 4.026069;
    vec3 stops = clamp(log2(max(inset * min(v, vec3(1.0e4)), vec3(1.0e-10))), least, most);
    vec3 x = (stops - least) / (most - least);
    vec3 y = ((((((15.5 * x - 40.14) * x + 31.96) * x - 6.868) * x + 0.4298) * x + 0.1191) * x - 0.00232);
    return outset * y;
}

vec3 tone_map(vec3 v) {
    if (curve == CURVE_ACES) {
        v = aces_like(v);
    }
    if (curve == CURVE_AGX) {
        return agx(v);
    }
    v = min(v, vec3(1.0));
    return curve == CURVE_LINEAR ? v : encode_srgb(v);
}

void main() {
    uint pixel = invocation_index();
    if (pixel >= window.x * window.y) {
        return;
    }
    vec2 at = (vec2(pixel % window.x, pixel / window.x) + 0.5 - origin) * per_pixel;
    bool inside = all(greaterThanEqual(at, vec2(0.0))) && all(lessThan(at, vec2(image)));
    // At whole numbers, the interpolation takes one pixel alone.
    vec2 place = nearest != 0u ? floor(at) : at - 0.5;
    vec3 color = inside ? tone_map(into_gamut(sample_image(place)) * exposure) : BACKGROUND;
    uvec3 bytes = uvec3(clamp(color, 0.0, 1.0) * 255.0 + 0.5);
    bytes = bgra != 0u ? bytes.bgr : bytes;
    pixels.data[pixel] = bytes.r | bytes.g << 8u | bytes.b << 16u | 0xff000000u;
}
