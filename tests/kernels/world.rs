//! Scenes: by hand, or packed from scene text as the renderer does.

use std::path::Path;

use bytemuck::{Pod, Zeroable, cast_slice};
use goblet::RevolutionSolver;
use goblet::gpu_scene::pack;
use goblet::scene::Scene;
use goblet_host::{Buffer, Texels};

use crate::bench::Bench;
use crate::generated::{
    AliasEntry, BvhPair, COUNT_SHIFT, Instance, Light, LightImage, LightTexel, MAX_LEAF_COUNT, Material, NONE,
    NewtonStart, Quadric, Revolution, RevolutionPiece, RevolutionSegment, SPHERE, SceneBindings, SceneInfo,
    TextureNode, Triangle, TriangleNormals, TriangleUvs,
};
use glam::{DAffine3, DMat3, DVec3};

/// Set 0 on the host.
#[derive(Clone)]
pub struct World {
    pub info: SceneInfo,
    pub bvh_pairs: Vec<BvhPair>,
    pub primitives: Vec<u32>,
    pub triangles: Vec<Triangle>,
    pub triangle_normals: Vec<TriangleNormals>,
    pub quadrics: Vec<Quadric>,
    pub revolutions: Vec<Revolution>,
    pub revolution_pieces: Vec<RevolutionPiece>,
    pub instances: Vec<Instance>,
    pub revolution_segments: Vec<RevolutionSegment>,
    pub newton_starts: Vec<NewtonStart>,
    pub materials: Vec<Material>,
    pub texture_nodes: Vec<TextureNode>,
    pub texture_texels: Vec<[u32; 4]>,
    pub triangle_uvs: Vec<TriangleUvs>,
    pub lights: Vec<Light>,
    pub light_images: Vec<LightImage>,
    pub light_texels: Vec<LightTexel>,
    pub emission_table: Vec<AliasEntry>,
    pub direct_table: Vec<AliasEntry>,
}

impl Default for World {
    fn default() -> Self {
        Self {
            info: SceneInfo::zeroed(),
            bvh_pairs: Vec::new(),
            primitives: Vec::new(),
            triangles: Vec::new(),
            triangle_normals: Vec::new(),
            quadrics: Vec::new(),
            revolutions: Vec::new(),
            revolution_pieces: Vec::new(),
            instances: Vec::new(),
            revolution_segments: Vec::new(),
            newton_starts: Vec::new(),
            materials: vec![Material { color_texture: NONE, alpha_texture: NONE, ..Material::zeroed() }],
            texture_nodes: Vec::new(),
            texture_texels: Vec::new(),
            triangle_uvs: Vec::new(),
            lights: Vec::new(),
            light_images: Vec::new(),
            light_texels: Vec::new(),
            emission_table: Vec::new(),
            direct_table: Vec::new(),
        }
    }
}

/// An array of the library's structs as this test's twins of the same GLSL structs.
fn twins<A: Pod, B: Pod>(data: &[A]) -> Vec<B> {
    cast_slice(data).to_vec()
}

impl World {
    /// Scene text, packed as for rendering; also what it was packed to.
    pub fn parse(text: &str) -> (Self, pack::PackedScene) {
        Self::parse_for(text, RevolutionSolver::default())
    }

    /// The same for a solver of bodies of revolution.
    pub fn parse_for(text: &str, solver: RevolutionSolver) -> (Self, pack::PackedScene) {
        let scene = Scene::parse(text, "test.pbrt", Path::new(env!("CARGO_MANIFEST_DIR"))).expect("a scene");
        let packed = pack::pack(&scene, solver).expect("a packed scene");
        let (lights_center, lights_reach2) = pack::sphere_of_reach(&packed.lights);
        let world = Self {
            info: SceneInfo {
                center: [0.0; 3],
                radius: packed.space.radius as f32,
                half_extent: packed.space.half_extent.as_vec3().to_array(),
                infinite: packed.infinite.as_vec3().to_array(),
                mean_power: packed.mean_power as f32,
                emission_count: packed.emission_table.len() as u32,
                direct_count: packed.direct_table.len() as u32,
                max_depth: 8,
                seed: 1,
                lights_center,
                lights_reach2,
                contact_lower: packed.contacts.lower,
                contact_error: packed.contacts.error,
                contact_upper: packed.contacts.upper,
                sky_count: packed.sky_count,
                pad: 0,
            },
            bvh_pairs: twins(&packed.bvh_pairs),
            primitives: packed.primitives.clone(),
            triangles: twins(&packed.triangles),
            triangle_normals: twins(&packed.triangle_normals),
            quadrics: twins(&packed.quadrics),
            revolutions: twins(&packed.revolutions),
            revolution_pieces: twins(&packed.revolution_pieces),
            instances: twins(&packed.instances),
            revolution_segments: twins(&packed.revolution_segments),
            newton_starts: twins(&packed.newton_starts),
            materials: twins(&packed.materials),
            texture_nodes: twins(&packed.texture_nodes),
            texture_texels: packed.texture_texels.clone(),
            triangle_uvs: twins(&packed.triangle_uvs),
            lights: twins(&packed.lights),
            light_images: twins(&packed.light_images),
            light_texels: twins(&packed.light_texels),
            emission_table: twins(&packed.emission_table),
            direct_table: twins(&packed.direct_table),
        };
        (world, packed)
    }

    /// The same with boxes that every ray enters: it meets every primitive. Each pair has
    /// a leaf on the left and the next pair on the right.
    pub fn without_hierarchy(&self) -> Self {
        let leaf = |i: u32| {
            let first = i * MAX_LEAF_COUNT;
            let left = (self.primitives.len() as u32).saturating_sub(first).min(MAX_LEAF_COUNT);
            left << COUNT_SHIFT | first
        };
        let last = (self.primitives.len() as u32).div_ceil(MAX_LEAF_COUNT) - 1;
        let lower = |reference: u32| [-1e9, -1e9, -1e9, f32::from_bits(reference)];
        let pair = |i: u32| BvhPair {
            left_lower: lower(leaf(i)),
            left_upper: [1e9, 1e9, 1e9, 0.0],
            // The last pair has its leaf twice.
            right_lower: lower(if i < last { i + 1 } else { leaf(i) }),
            right_upper: [1e9, 1e9, 1e9, 0.0],
        };
        Self { bvh_pairs: (0..=last).map(pair).collect(), ..self.clone() }
    }

    pub fn upload(&self, bench: &Bench) -> GpuWorld {
        GpuWorld {
            scene_info: bench.upload_texels(&[self.info]),
            bvh_pairs: bench.upload_texels(&self.bvh_pairs),
            primitives: bench.upload_texels(&self.primitives),
            triangles: bench.upload_texels(&self.triangles),
            triangle_normals: bench.upload_texels(&self.triangle_normals),
            quadrics: bench.upload_texels(&self.quadrics),
            revolutions: bench.upload_texels(&self.revolutions),
            revolution_pieces: bench.upload_texels(&self.revolution_pieces),
            instances: bench.upload_texels(&self.instances),
            revolution_segments: bench.upload(&self.revolution_segments),
            newton_starts: bench.upload(&self.newton_starts),
            materials: bench.upload_texels(&self.materials),
            texture_nodes: bench.upload_texels(&self.texture_nodes),
            texture_texels: bench.upload_texels(&self.texture_texels),
            triangle_uvs: bench.upload_texels(&self.triangle_uvs),
            lights: bench.upload_texels(&self.lights),
            light_images: bench.upload_texels(&self.light_images),
            light_texels: bench.upload_texels(&self.light_texels),
            emission_table: bench.upload_texels(&self.emission_table),
            direct_table: bench.upload_texels(&self.direct_table),
        }
    }
}

/// Set 0 on the device.
pub struct GpuWorld {
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

impl GpuWorld {
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

/// A transform of the kernels, by its rows.
pub fn affine(rows: [[f32; 4]; 3]) -> DAffine3 {
    let column = |i: usize| DVec3::from(rows.map(|row| f64::from(row[i])));
    DAffine3 { matrix3: DMat3::from_cols(column(0), column(1), column(2)), translation: column(3) }
}

/// A triangle that does not emit and has no shading normals.
pub fn triangle([p0, p1, p2]: [[f32; 3]; 3]) -> Triangle {
    Triangle { p0, material: 0, p1, light: NONE, p2, normals: NONE }
}

/// A whole sphere or disk with this transform from its unit object space.
pub fn quadric(render_from_object: &DAffine3) -> Quadric {
    Quadric {
        object_from_render: pack::rows(&render_from_object.inverse()),
        render_from_object: pack::rows(render_from_object),
        material: 0,
        light: NONE,
        flipped: 0,
        z_min: -1.0,
        z_max: 1.0,
        phi_max: std::f32::consts::TAU,
        inner_radius: 0.0,
        determinant: render_from_object.matrix3.determinant().abs() as f32,
        kind: SPHERE,
        size: pack::longest_row(render_from_object),
        ..Quadric::zeroed()
    }
}
