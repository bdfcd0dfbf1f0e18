// The material at a point of a surface.
#include "geometry/surface_point.glsl"
#include "material/bsdf.glsl"
#include "material/coat_table.glsl"
#include "material/layers.glsl"
#include "material/texture.glsl"
#include "math/random.glsl"
#include "scene/constants.glsl"
#include "scene/features.glsl"
#include "scene/materials.glsl"
#include "scene/scene.glsl"

// Hashes a point to a number in [0, 1).
float hash_to_unit(vec3 position) {
    uvec3 bits = pcg3d(floatBitsToUint(position));
    return to_unit(bits.x ^ bits.y);
}

// GGX alpha from the value of a texture. If `remapped`, the value is alpha's square.
float alpha_of(float roughness, bool remapped) {
    return max(remapped ? sqrt(max(roughness, 0.0)) : roughness, 1.0e-3);
}

// Whether photons are recorded on a material: some lobe of it is Lambertian.
bool receives_photons(Material material) {
    if (HAS_LAYERS) {
        return (material.flags & HAS_LAMBERTIAN) != 0u;
    }
    return !is_specular(material);
}

// GGX alpha along the tangent and across. A texture that gives both is read once.
vec2 textured_alpha(uint u_texture, uint v_texture, vec2 alpha, bool remapped, Surface surface) {
    if (u_texture != NONE) {
        alpha.x = alpha_of(textured(u_texture, vec3(0.0), surface).x, remapped);
        alpha.y = v_texture == u_texture ? alpha.x : alpha.y;
    }
    if (HAS_ANISOTROPIC && v_texture != NONE && v_texture != u_texture) {
        alpha.y = alpha_of(textured(v_texture, vec3(0.0), surface).x, remapped);
    }
    return alpha;
}

void apply_textures(inout Material material, Surface surface) {
    material.color = color_at(material, surface);
    if (HAS_CONDUCTORS && (material.flags & BY_REFLECTANCE) != 0u) {
        // The k that has this reflectance at normal incidence, for eta = 1 over the index outside.
        vec3 reflectance = min(material.color, vec3(0.9999));
        float outside = material.coat_eta > 0.0 ? material.coat_eta : 1.0;
        material.eta = vec3(1.0 / outside);
        material.k = 2.0 * sqrt(reflectance / (1.0 - reflectance)) / outside;
    }
    bool is_transmission = HAS_DIFFUSE_TRANSMISSION && material.kind == DIFFUSE_TRANSMISSION;
    bool is_scattering_coat = HAS_SCATTERING_COATS && (material.flags & SCATTERING_COAT) != 0u;
    if (is_transmission || is_scattering_coat) {
        material.second = clamp(textured(material.second_texture, material.second, surface), 0.0, 1.0);
    }
    if (is_transmission) {
        material.color *= material.color_texture != NONE ? material.amount : 1.0;
        material.second *= material.second_texture != NONE ? material.amount : 1.0;
    }
    if (HAS_TEXTURED_COATS) {
        if (material.coat_eta > 0.0 && material.amount_texture != NONE) {
            float thickness = max(textured(material.amount_texture, vec3(0.0), surface).x, 0.0);
            bool scatters = (material.flags & SCATTERING_COAT) != 0u;
            material.coat_thickness = min(scatters ? thickness : thickness * material.amount, 1.0e30);
            if (!scatters) {
                material.coat_sent_back = sent_back_at(material.second_part, material.coat_thickness);
            }
        }
    }
    if (is_scattering_coat) {
        material.amount = textured(material.first, vec3(material.amount), surface).x;
    }
    if (HAS_ROUGH) {
        vec2 alpha = textured_alpha(material.alpha_u_texture, material.alpha_v_texture, alpha_of(material),
                                    (material.flags & REMAPPED) != 0u, surface);
        material.alpha_u = alpha.x;
        material.alpha_v = alpha.y;
        if (HAS_COATS) {
            alpha = textured_alpha(material.coat_u_texture, material.coat_v_texture,
                                   vec2(material.coat_alpha_u, material.coat_alpha_v),
                                   (material.flags & REMAPPED_COAT) != 0u, surface);
            material.coat_alpha_u = alpha.x;
            material.coat_alpha_v = alpha.y;
        }
    }
}

float mix_amount(Material material, Surface surface) {
    return clamp(textured(material.amount_texture, vec3(material.amount), surface).x, 0.0, 1.0);
}

// Of a mix, one of its materials by chance. `receiving`: one that receives photons, if there is one.
Material one_of_mix(Material material, Surface surface, bool receiving) {
    uint flags = material.flags & (HAS_LAMBERTIAN | HAS_FACETS);
    float u = hash_to_unit(surface.position);
    while (material.kind == MIX) {
        Material first = materials_at(material.first);
        Material second = materials_at(material.second_part);
        bool is_first = draw_bernoulli(1.0 - mix_amount(material, surface), u);
        if (receiving) {
            is_first = (is_first || !receives_photons(second)) && receives_photons(first);
        }
        material = is_first ? first : second;
    }
    material.flags |= flags;
    return material;
}

Material textured_material(Material material, Surface surface) {
    if (HAS_TEXTURES) {
        apply_textures(material, surface);
    }
    if (HAS_SCATTERING_COATS) {
        if ((material.flags & SCATTERING_COAT) != 0u) {
            look_up_scattering(material);
        }
    }
    return material;
}

Material material_at(Surface surface) {
    Material material = materials_at(surface.material);
    if (HAS_MIXES) {
        material = one_of_mix(material, surface, false);
    }
    return textured_material(material, surface);
}

// The material that decides how much of a photon's light gets through a coat to what receives it. Of a mix, whose
// visible points all gather the photon, it is one that receives photons, wherever the photon itself met another.
Material receiving_material_at(Material material, Surface surface) {
    if (HAS_MIXES) {
        if (HAS_COATS) {
            return textured_material(one_of_mix(materials_at(surface.material), surface, true), surface);
        }
    }
    return material;
}
