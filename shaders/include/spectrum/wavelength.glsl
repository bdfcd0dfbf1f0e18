// The wavelength of a path, and what depends on it.
//
// A wavelength is a number in [0, 1), uniform over paths: the share of paths with a shorter one. It is in one of
// BANDS bands of the same width. src/scene/spectrum/wavelength.rs says which wavelengths in nm a band has; kernels
// need only what a table says of the band.
#include "scene/materials.glsl"
#include "scene/scene.glsl"

// The wavelength of a path that has none: it carries all of them.
const float NO_WAVELENGTH = -1.0;

bool has_wavelength(float wavelength) {
    return wavelength >= 0.0;
}

uint band_of(float wavelength) {
    return min(uint(wavelength * float(BANDS)), BANDS - 1u);
}

// The element of a table of texture_texels for a wavelength.
vec4 at_wavelength(uint table, float wavelength) {
    return uintBitsToFloat(texture_texels_at(table + band_of(wavelength)));
}
