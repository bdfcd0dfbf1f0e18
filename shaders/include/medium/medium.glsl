// Absorption, and which medium a ray is in.
//
// A path knows the medium that it is in. A surface between two different media tells which one is on each
// side, by its geometric normal, and so which one a ray that leaves it enters. On any other surface the ray
// stays in its medium.
#include "geometry/surface_point.glsl"
#include "medium/absorption.glsl"
#include "scene/constants.glsl"
#include "scene/features.glsl"
#include "scene/media.glsl"
#include "scene/scene.glsl"
#include "spectrum/wavelength.glsl"

// Share of a path's light that is left after a way through a medium, render units.
vec3 transmittance(uint index, float way, Hue hue) {
    Medium medium = media_at(index);
    if (HAS_DISPERSION) {
        if (has_wavelength(hue) && medium.spectrum != NONE) {
            // A path whose color is the mean of all wavelengths loses what RGB does.
            medium.absorption = mix(at_wavelength(medium.spectrum, hue).rgb, medium.absorption, hue.window);
        }
    }
    return absorb(medium.absorption, way);
}

// Sets the media on both sides of a surface that emits.
void set_media(inout Surface surface) {
    MediumInterface between = medium_interfaces_at(surface.material);
    surface.media = uvec2(between.outside, between.inside);
}

// Sets the media on both sides of a surface that a ray has met in a medium.
void set_media(inout Surface surface, uint medium) {
    set_media(surface);
    if (surface.media.x == surface.media.y) {
        surface.media = uvec2(medium);
    }
}

// Whether a surface only bounds media.
bool only_bounds_media(Surface surface) {
    return medium_interfaces_at(surface.material).passes != 0u;
}
