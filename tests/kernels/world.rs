//! Scenes: by hand, or packed from scene text as the renderer does.

use std::ops::{Deref, DerefMut};

use crate::fixture::Fixture;
use crate::generated::{
    BVH_PLANES, COUNT_SHIFT, GpuScene, Material, NONE, Quadric, SPHERE, SceneArrays, SceneInfo, Triangle,
};
use crate::support;
use bytemuck::Zeroable;
use glam::{DAffine3, DMat3, DVec3};
use goblet::RevolutionSolver;
use goblet::gpu_scene::pack;
use goblet::scene::Scene;

/// Set 0 on the host.
#[derive(Clone)]
pub struct World {
    pub info: SceneInfo,
    pub arrays: SceneArrays,
}

impl Default for World {
    fn default() -> Self {
        Self::of(SceneArrays::default())
    }
}

impl Deref for World {
    type Target = SceneArrays;

    fn deref(&self) -> &SceneArrays {
        &self.arrays
    }
}

impl DerefMut for World {
    fn deref_mut(&mut self) -> &mut SceneArrays {
        &mut self.arrays
    }
}

impl World {
    /// Arrays with one material, that has no textures.
    pub fn of(arrays: SceneArrays) -> Self {
        let material = Material { color_texture: NONE, alpha_texture: NONE, ..Material::zeroed() };
        Self { info: SceneInfo::zeroed(), arrays: SceneArrays { materials: vec![material], ..arrays } }
    }

    /// Scene text, packed as for rendering; also what it was packed to.
    pub fn parse(text: &str) -> (Self, pack::PackedScene) {
        Self::parse_for(text, RevolutionSolver::default())
    }

    /// The same for a solver of bodies of revolution, or for another way to pack.
    pub fn parse_for(text: &str, packing: impl Into<pack::Packing>) -> (Self, pack::PackedScene) {
        let scene = Scene::parse(text, "test.pbrt", support::root()).expect("a scene");
        let packed = pack::pack(&scene, packing).expect("a packed scene");
        let world = Self { info: packed.info(8, 1), arrays: packed.arrays.clone() };
        (world, packed)
    }

    /// The same with boxes that every ray enters: it meets every primitive. Each node has a leaf and the next
    /// node.
    pub fn without_hierarchy(&self) -> Self {
        let is_leaf = |reference: &u32| *reference != NONE && reference >> COUNT_SHIFT > 0;
        let leaves: Vec<u32> = self.bvh_children.iter().flatten().copied().filter(is_leaf).collect();
        let last = leaves.len() as u32 - 1;
        let node = |i: u32| [leaves[i as usize], if i < last { i + 1 } else { NONE }, NONE, NONE];
        let planes = |i: u32| {
            // No ray enters a box that is inverted.
            let next = if i < last { 1e9 } else { -3e38 };
            (0..BVH_PLANES).map(move |plane| {
                let far = if plane < 3 { -1.0 } else { 1.0 };
                [far * 1e9, far * next, -far * 3e38, -far * 3e38]
            })
        };
        let arrays = SceneArrays {
            bvh_children: (0..=last).map(node).collect(),
            bvh_planes: (0..=last).flat_map(planes).collect(),
            ..self.arrays.clone()
        };
        Self { arrays, ..*self }
    }

    pub fn upload(&self, fixture: &Fixture) -> GpuScene {
        self.arrays.upload(fixture.device(), &self.info).expect("an upload")
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
