// Tables of coats whose thickness varies, or that scatter light: src/gpu_scene/pack/material.
#include "scene/constants.glsl"
#include "scene/materials.glsl"
#include "scene/scene.glsl"

// The place of a thickness among the entries of a table; linear between 0 and the second entry.
float place_in_coat_table(float thickness) {
    float scaled = thickness * float(1u << COAT_FINEST);
    float place = scaled < 1.0 ? scaled : 1.0 + float(COAT_STEPS) * log2(scaled);
    return clamp(place, 0.0, float(COAT_OCTAVES * COAT_STEPS + 1u));
}

// Share of the light from under a coat that the coat reflects back, by a table of pairs of neighbouring entries.
float sent_back_at(uint table, float thickness) {
    float place = place_in_coat_table(thickness);
    uint entry = min(uint(place), COAT_OCTAVES * COAT_STEPS);
    vec2 pair = uintBitsToFloat(texture_texels_at(table + entry).xy);
    return mix(pair.x, pair.y, place - float(entry));
}

// Place of an albedo among the entries of a table, which are finer towards 1.
float place_of_albedo(float albedo) {
    return (1.0 - sqrt(1.0 - albedo)) * float(COAT_ALBEDOS - 1u);
}

// Place of the mean cosine of scattering; it is at most 0.95 either way.
float place_of_phase(float g) {
    return clamp(0.5 + g * (0.5 / 0.95), 0.0, 1.0) * float(COAT_PHASES - 1u);
}

// An entry of the table of a scattering coat. sent_back and leaving are shares of the light of the base.
struct CoatResponse {
    vec3 from_base;  // radiance under the boundary over that of the base, at the cosines of scattering_coat
    float sent_back;
    vec3 scattered;  // radiance under the boundary of the light that the coat scatters back
    float leaving;
    float mean_scattered;
};

// Interpolates a table at a channel's place: by thickness, albedo, and mean cosine.
CoatResponse coat_response(uint table, uvec3 count, vec3 place) {
    CoatResponse sum = CoatResponse(vec3(0.0), 0.0, vec3(0.0), 0.0, 0.0);
    uvec3 low = min(uvec3(place), count - 1u);
    vec3 fraction = place - vec3(low);
    for (uint corner = 0u; corner < 8u; corner++) {
        uvec3 upper = uvec3(corner, corner >> 1u, corner >> 2u) & 1u;
        vec3 weights = mix(1.0 - fraction, fraction, equal(upper, uvec3(1u)));
        float weight = weights.x * weights.y * weights.z;
        if (weight > 0.0) {
            uvec3 at = min(low + upper, count - 1u);
            uint element = table + 3u * ((at.z * count.y + at.y) * count.x + at.x);
            vec4 below = uintBitsToFloat(texture_texels_at(element));
            vec4 above = uintBitsToFloat(texture_texels_at(element + 1u));
            sum.from_base += weight * below.xyz;
            sum.sent_back += weight * below.w;
            sum.scattered += weight * above.xyz;
            sum.leaving += weight * above.w;
            sum.mean_scattered += weight * uintBitsToFloat(texture_texels_at(element + 2u).x);
        }
    }
    return sum;
}

// Light that leaves a scattering coat over a base of this albedo, over the root of its mean, at the cosines of
// scattering_coat.
vec3 leaving_scattering_coat(CoatResponse coat, float eta, float albedo) {
    float from_base = albedo * coat.leaving / max(1.0 - albedo * coat.sent_back, 1.0e-6);
    float mean = coat.mean_scattered + from_base * coat.leaving * eta * eta;
    return (coat.scattered + from_base * coat.from_base) * inversesqrt(max(mean, 1.0e-20));
}

// Sets what scattering_coat needs, from the material's values at a point.
void look_up_scattering(inout Material material) {
    bool by_thickness = material.amount_texture != NONE;
    bool by_albedo = material.second_texture != NONE;
    bool by_phase = material.first != NONE;
    uvec3 count = uvec3(by_thickness ? COAT_OCTAVES * COAT_STEPS + 2u : 1u,
                        by_albedo ? COAT_ALBEDOS : 3u,
                        by_phase ? COAT_PHASES : 1u);
    vec3 place = vec3(by_thickness ? place_in_coat_table(material.coat_thickness) : 0.0, 0.0,
                      by_phase ? place_of_phase(material.amount) : 0.0);
    vec3 values[3];
    for (uint channel = 0u; channel < 3u; channel++) {
        place.y = by_albedo ? place_of_albedo(material.second[channel]) : float(channel);
        CoatResponse coat = coat_response(material.second_part, count, place);
        values[channel] = leaving_scattering_coat(coat, material.coat_eta, material.color[channel]);
    }
    material.eta = vec3(values[0].x, values[1].x, values[2].x);
    material.k = vec3(values[0].y, values[1].y, values[2].y);
    material.second = vec3(values[0].z, values[1].z, values[2].z);
}
