// Dispersion: glass whose index of refraction depends on the wavelength.
//
// A path begins without a wavelength, for all of them together. Where it is refracted into one of several directions, it
// takes a wavelength and keeps it. What changes no direction takes no wavelength: reflections, panes and coats.
#include "material/bsdf.glsl"
#include "material/fresnel.glsl"
#include "math/random.glsl"
#include "scene/features.glsl"
#include "scene/materials.glsl"
#include "scene/scene.glsl"
#include "spectrum/wavelength.glsl"

// Index of refraction at a wavelength. The table has the indices at both ends of each band, behind the channels' means.
float index_at(Material material, Hue hue) {
    vec4 ends = at_wavelength(material.indices + 1u, hue);
    return mix(ends.x, ends.y, fract(place_of(hue)));
}

// Mean index of refraction that each channel sees.
vec3 channel_indices(Material material) {
    return uintBitsToFloat(texture_texels_at(material.indices).xyz);
}

// Derivative by the wavelength of the index that a path enters over the one it leaves. `eta` is that ratio.
float slope_of_index(Material material, float eta) {
    if ((material.flags & DISPERSIVE) == 0u || material.kind != DIELECTRIC) {
        return 0.0;
    }
    float slope = uintBitsToFloat(texture_texels_at(material.indices).w);
    return eta == material.eta.x ? slope : -slope * eta * eta;
}

// Gives a material the index that a path with a wavelength meets.
void set_index(inout Material material, Hue hue) {
    if ((material.flags & DISPERSIVE) != 0u && has_wavelength(hue)) {
        float eta = index_at(material, hue);
        if (material.coat_eta > 0.0) {
            material.coat_eta = eta;
        } else {
            material.eta = vec3(eta);
        }
    }
}

// Fresnel reflectance of a boundary for each channel.
vec3 fresnel_channels(float cos_i, vec3 eta) {
    float cos_t;
    return vec3(fresnel_dielectric(cos_i, eta.r, cos_t), fresnel_dielectric(cos_i, eta.g, cos_t),
                fresnel_dielectric(cos_i, eta.b, cos_t));
}

// Factor of a pane for a path without a wavelength: each channel has its own reflectance.
vec3 color_of_pane(Material material, float cos_o, float u_lobe) {
    float cos_t;
    float mean = fresnel_dielectric(cos_o, material.eta.x, cos_t);
    mean = 2.0 * mean / (1.0 + mean);
    vec3 reflectance = fresnel_channels(cos_o, channel_indices(material));
    reflectance = 2.0 * reflectance / (1.0 + reflectance);
    return u_lobe < mean ? reflectance / mean : (1.0 - reflectance) / (1.0 - mean);
}

// Prepares a path without a wavelength for a lobe that it has met, before the lobe is sampled: returns a factor of
// its weight. Where the path needs a wavelength, it takes one, and the material has the index for it. `u_lobe`
// chooses between reflection and refraction.
vec3 take_wavelength(inout Material material, inout Hue hue, inout float u_lobe, float cos_o, bool outside, Random random) {
    if ((material.flags & DISPERSIVE) == 0u || has_wavelength(hue)) {
        return vec3(1.0);
    }
    cos_o = min(cos_o, 1.0);
    if (HAS_THIN) {
        if (material.kind == THIN_DIELECTRIC) {
            return color_of_pane(material, cos_o, u_lobe);
        }
    }
    if (material.kind != DIELECTRIC) {
        return vec3(1.0);
    }
    // Into the denser medium there is no total reflection, whatever the wavelength.
    bool reflects_alike = outside == (material.eta.x > 1.0) && !is_rough(material);
    float cos_t;
    float mean = fresnel_dielectric(cos_o, relative_eta(material, outside), cos_t);
    vec3 channels = channel_indices(material);
    vec3 reflectance = fresnel_channels(cos_o, outside ? channels : 1.0 / channels);
    if (reflects_alike && u_lobe < mean) {
        return reflectance / mean;
    }
    hue.wavelength = random_wavelength(random);
    set_index(material, hue);
    if (!reflects_alike) {
        return vec3(1.0);
    }
    // Of each channel what is not reflected, so that none gains or loses light.
    u_lobe = 0.99999994;
    return (1.0 - reflectance) / (1.0 - mean);
}
