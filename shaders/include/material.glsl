// What a surface is made of at a point.

// A number in [0, 1) that differs from point to point.
float chance_at(vec3 position) {
    uvec3 bits = pcg3d(floatBitsToUint(position));
    return to_unit(bits.x ^ bits.y);
}

// GGX's alpha from a texture's value.
float alpha_of(float roughness, bool remapped) {
    return max(remapped ? sqrt(max(roughness, 0.0)) : roughness, 1.0e-3);
}

// Whether photons are recorded where a surface is of a material, whichever lobe they take.
bool receives_photons(Material material) {
    if (HAS_LAYERS) {
        return (material.flags & HAS_LAMBERTIAN) != 0u;
    }
    return !is_specular(material);
}

Material material_at(Surface surface) {
    Material material = materials_at(surface.material);
    if (HAS_MIXES) {
        uint flags = material.flags & HAS_LAMBERTIAN;
        float u = chance_at(surface.position);
        while (material.kind == MIX) {
            material = materials_at(takes(1.0 - material.amount, u) ? material.first : material.second_part);
        }
        material.flags |= flags;
    }
    return material;
}
