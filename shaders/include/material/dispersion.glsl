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
#include "spectrum/spread.glsl"
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

// Goes on from wo to wi at a material. eta: index of the medium that the path enters over the one it leaves, 1 if it stays.
void bend_spread(inout Spread spread, Material material, vec3 wo, vec3 wi, float eta) {
    float middle = eta;
    float slope = 0.0;
    if ((material.flags & DISPERSIVE) != 0u && material.kind == DIELECTRIC && eta != 1.0) {
        Hue hue = no_hue();
        hue.wavelength = 0.5;
        float index = index_at(material, hue);
        slope = uintBitsToFloat(texture_texels_at(material.indices).w);
        bool enters = eta == material.eta.x;
        middle = enters ? index : 1.0 / index;
        slope = enters ? slope : -slope / (index * index);
    }
    bend_spread(spread, wo, wi, eta, middle, slope);
}

// The step by wavelength of a finite difference, and the largest relative change of a weight that counts.
const float HUE_STEP = 0.0625;
const float MOST_SLOPE = 4.0;

// Compares the chance by which a path has been scattered at a dielectric with those of neighbouring wavelengths: they differ,
// and are 0 where one of the wavelengths is reflected in total. `spread` is that of the path before; n is the normal.
void compare_chances(inout Hue hue, Material material, Spread spread, vec3 wo, Scatter scattered, vec3 n) {
    if ((material.flags & DISPERSIVE) == 0u || material.kind != DIELECTRIC || !has_wavelength(hue)) {
        return;
    }
    float eta = relative_eta(material, dot(wo, n) > 0.0);
    vec3 m = normalize(wo + scattered.eta * scattered.wi);
    float cos_i = dot(wo, m);
    float change = -dot(spread.direction, m) * sign(cos_i);
    cos_i = min(abs(cos_i), 1.0);
    float cos_next = clamp(cos_i + HUE_STEP * change, 0.0, 1.0);
    float eta_next = eta + HUE_STEP * slope_of_index(material, eta);
    float sin2 = (1.0 - cos_i * cos_i) / (eta * eta);
    float sin2_next = (1.0 - cos_next * cos_next) / (eta_next * eta_next);
    if (eta < 1.0) {
        float to_critical = HUE_STEP * (1.0 - sin2) / (sin2_next - sin2);
        if (hue.wavelength + to_critical > -1.0 && hue.wavelength + to_critical < 2.0) {
            hue.widest = 0.0;
        }
    }
    if (sin2 < 1.0) {
        float cos_t;
        float here = fresnel_dielectric(cos_i, eta, cos_t);
        float next = fresnel_dielectric(cos_next, eta_next, cos_t);
        bool is_reflected = scattered.eta == 1.0;
        float ratio = (is_reflected ? next : 1.0 - next) / max(is_reflected ? here : 1.0 - here, 1.0e-6);
        hue.slope += clamp((ratio - 1.0) / HUE_STEP, -MOST_SLOPE, MOST_SLOPE);
    }
}

// Adds to the slope of a path's weight that of the transmittance of the coat over a base.
void compare_transmittances(inout Hue hue, Material base, float cos_i) {
    if (HAS_COATS) {
        if ((base.flags & DISPERSIVE) != 0u && base.coat_eta > 0.0 && has_wavelength(hue)) {
            float here = transmittance_to_base(base, cos_i);
            base.coat_eta += HUE_STEP * uintBitsToFloat(texture_texels_at(base.indices).w);
            float ratio = transmittance_to_base(base, cos_i) / max(here, 1.0e-6);
            hue.slope += clamp((ratio - 1.0) / HUE_STEP, -MOST_SLOPE, MOST_SLOPE);
        }
    }
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
vec3 take_wavelength(inout Material material, inout Hue hue, inout float u_lobe, vec3 wo, vec3 n, Random random) {
    if ((material.flags & DISPERSIVE) == 0u || has_wavelength(hue)) {
        return vec3(1.0);
    }
    bool outside = dot(wo, n) > 0.0;
    float cos_o = min(abs(dot(wo, n)), 1.0);
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
    if (reflects_alike && u_lobe < mean) {
        vec3 channels = channel_indices(material);
        return fresnel_channels(cos_o, outside ? channels : 1.0 / channels) / mean;
    }
    hue.wavelength = random_wavelength(random);
    set_index(material, hue);
    if (!reflects_alike) {
        return vec3(1.0);
    }
    u_lobe = 0.99999994; // refraction
    float reflectance = fresnel_dielectric(cos_o, relative_eta(material, outside), cos_t);
    return vec3((1.0 - reflectance) / (1.0 - mean));
}
