//! How much of a device's memory a scene takes.

use super::PackedScene;

impl PackedScene {
    /// Bytes of its arrays.
    pub fn bytes(&self) -> u64 {
        let Self {
            space: _,
            bvh_pairs,
            primitives,
            triangles,
            triangle_normals,
            triangle_uvs,
            texture_nodes,
            texture_texels,
            quadrics,
            revolutions,
            revolution_pieces,
            revolution_segments,
            newton_starts,
            instances,
            materials,
            lights,
            sky_count: _,
            light_images,
            light_texels,
            emission_table,
            direct_table,
            infinite: _,
            mean_power: _,
            specialization: _,
            contacts: _,
        } = self;
        let sizes = [
            size_of_val(&bvh_pairs[..]),
            size_of_val(&primitives[..]),
            size_of_val(&triangles[..]),
            size_of_val(&triangle_normals[..]),
            size_of_val(&triangle_uvs[..]),
            size_of_val(&texture_nodes[..]),
            size_of_val(&texture_texels[..]),
            size_of_val(&quadrics[..]),
            size_of_val(&revolutions[..]),
            size_of_val(&revolution_pieces[..]),
            size_of_val(&revolution_segments[..]),
            size_of_val(&newton_starts[..]),
            size_of_val(&instances[..]),
            size_of_val(&materials[..]),
            size_of_val(&lights[..]),
            size_of_val(&light_images[..]),
            size_of_val(&light_texels[..]),
            size_of_val(&emission_table[..]),
            size_of_val(&direct_table[..]),
        ];
        sizes.iter().map(|size| *size as u64).sum()
    }
}
