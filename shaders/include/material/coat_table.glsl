// Tables of coats whose thickness varies: src/gpu_scene/pack/coat.rs.
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
