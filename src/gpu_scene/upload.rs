//! A packed scene in device memory.

use goblet_host::{Buffer, Device, Texels};

use crate::gpu_scene::pack::{PackedScene, sphere_of_reach};
use crate::kernels::{
    AliasEntry, BvhPair, Instance, Light, LightImage, LightTexel, Material, NewtonStart, Quadric, Revolution,
    RevolutionPiece, RevolutionSegment, SceneBindings, SceneInfo, TextureNode, Triangle, TriangleNormals, TriangleUvs,
};

/// The scene's arrays, in the order of `shaders/include/scene/scene.glsl`.
pub struct GpuScene {
    scene_info: Texels<SceneInfo>,
    bvh_pairs: Texels<BvhPair>,
    primitives: Texels<u32>,
    triangles: Texels<Triangle>,
    triangle_normals: Texels<TriangleNormals>,
    quadrics: Texels<Quadric>,
    revolutions: Texels<Revolution>,
    revolution_pieces: Texels<RevolutionPiece>,
    instances: Texels<Instance>,
    revolution_segments: Buffer<RevolutionSegment>,
    newton_starts: Buffer<NewtonStart>,
    materials: Texels<Material>,
    texture_nodes: Texels<TextureNode>,
    texture_texels: Texels<[u32; 4]>,
    triangle_uvs: Texels<TriangleUvs>,
    lights: Texels<Light>,
    light_images: Texels<LightImage>,
    light_texels: Texels<LightTexel>,
    emission_table: Texels<AliasEntry>,
    direct_table: Texels<AliasEntry>,
}

impl GpuScene {
    /// Copies a scene to the device.
    ///
    /// # Errors
    /// Out of device memory, or an array is larger than the device can bind.
    pub fn new(device: &Device, scene: &PackedScene, max_depth: u32, seed: u32) -> goblet_host::Result<Self> {
        let (lights_center, lights_reach2) = sphere_of_reach(&scene.lights);
        let info = SceneInfo {
            center: [0.0; 3],
            // Wide enough that rounding leaves nothing outside.
            radius: (scene.space.radius * 1.0001) as f32,
            infinite: scene.infinite.as_vec3().to_array(),
            mean_power: scene.mean_power as f32,
            emission_count: scene.emission_table.len() as u32,
            direct_count: scene.direct_table.len() as u32,
            max_depth,
            seed,
            lights_center,
            lights_reach2,
            contact_lower: scene.contacts.lower,
            contact_error: scene.contacts.error,
            contact_upper: scene.contacts.upper,
            half_extent: scene.space.half_extent.as_vec3().to_array(),
            sky_count: scene.sky_count,
            pad: 0,
        };
        Ok(Self {
            scene_info: device.upload_texels("scene_info", &[info])?,
            bvh_pairs: device.upload_texels("bvh_pairs", &scene.bvh_pairs)?,
            primitives: device.upload_texels("primitives", &scene.primitives)?,
            triangles: device.upload_texels("triangles", &scene.triangles)?,
            triangle_normals: device.upload_texels("triangle_normals", &scene.triangle_normals)?,
            quadrics: device.upload_texels("quadrics", &scene.quadrics)?,
            revolutions: device.upload_texels("revolutions", &scene.revolutions)?,
            revolution_pieces: device.upload_texels("revolution_pieces", &scene.revolution_pieces)?,
            instances: device.upload_texels("instances", &scene.instances)?,
            revolution_segments: device.upload("revolution_segments", &scene.revolution_segments)?,
            newton_starts: device.upload("newton_starts", &scene.newton_starts)?,
            materials: device.upload_texels("materials", &scene.materials)?,
            texture_nodes: device.upload_texels("texture_nodes", &scene.texture_nodes)?,
            texture_texels: device.upload_texels("texture_texels", &scene.texture_texels)?,
            triangle_uvs: device.upload_texels("triangle_uvs", &scene.triangle_uvs)?,
            lights: device.upload_texels("lights", &scene.lights)?,
            light_images: device.upload_texels("light_images", &scene.light_images)?,
            light_texels: device.upload_texels("light_texels", &scene.light_texels)?,
            emission_table: device.upload_texels("emission_table", &scene.emission_table)?,
            direct_table: device.upload_texels("direct_table", &scene.direct_table)?,
        })
    }

    /// The arrays as kernels bind them.
    pub fn bindings(&self) -> SceneBindings<'_> {
        SceneBindings {
            scene_info: &self.scene_info,
            bvh_pairs: &self.bvh_pairs,
            primitives: &self.primitives,
            triangles: &self.triangles,
            triangle_normals: &self.triangle_normals,
            quadrics: &self.quadrics,
            revolutions: &self.revolutions,
            revolution_pieces: &self.revolution_pieces,
            instances: &self.instances,
            revolution_segments: &self.revolution_segments,
            newton_starts: &self.newton_starts,
            materials: &self.materials,
            texture_nodes: &self.texture_nodes,
            texture_texels: &self.texture_texels,
            triangle_uvs: &self.triangle_uvs,
            lights: &self.lights,
            light_images: &self.light_images,
            light_texels: &self.light_texels,
            emission_table: &self.emission_table,
            direct_table: &self.direct_table,
        }
    }
}
