//! A scene on the device, and what its kernels are specialised to.

use goblet::gpu_scene::camera::{View, pack_camera};
use goblet::gpu_scene::pack::{RenderSpace, pack};
use goblet::kernels::{GpuScene, PassFeatures, Specialization, Triangle};
use goblet::scene::{Camera, Film, Scene};
use goblet::{Device, RevolutionSolver};

use crate::{Result, scenes};

const SEED: u32 = 1;

pub struct Prepared {
    pub name: String,
    /// The number of triangles that a ray may meet.
    pub triangles: usize,
    pub gpu: GpuScene,
    /// That of a pass that follows paths.
    pub specialization: Specialization,
    pub space: RenderSpace,
    pub has_lights: bool,
    /// All surfaces, if each is a triangle and there are neither instances nor holes by alpha.
    pub mesh: Option<Vec<Triangle>>,
    camera: Camera,
    film: Film,
}

impl Prepared {
    pub fn new(device: &Device, name: String, scene: &Scene) -> Result<Self> {
        eprintln!("{name}");
        let packed = pack(scene, RevolutionSolver::default())?;
        let gpu = packed.arrays.upload(device, &packed.info(scene.integrator.max_depth, SEED))?;
        let arrays = packed.arrays;
        let is_mesh = arrays.quadrics.is_empty() && arrays.revolutions.is_empty() && arrays.instances.is_empty();
        let mut prepared = Self {
            name,
            triangles: scenes::triangles(scene),
            gpu,
            specialization: Specialization {
                scene: packed.features,
                material: packed.material_features,
                device: goblet::render::device_features(device.info(), crate::sets::WORKGROUP_SIZE),
                pass: PassFeatures {
                    is_resumable: false,
                    is_queue: goblet::render::is_queue(device.info().kind, &packed.features),
                    gathers_caustics: false,
                    sorts_rough: false,
                },
                ..Specialization::DECLARED
            },
            space: packed.space,
            has_lights: packed.mean_power > 0.0,
            mesh: (is_mesh && !packed.features.has_alpha).then_some(arrays.triangles),
            camera: scene.camera,
            // The whole image, whatever part of it the scene wants.
            film: Film { window: [0.0, 1.0, 0.0, 1.0], ..scene.film.clone() },
        };
        prepared.specialization.camera = prepared.view(1).features();
        Ok(prepared)
    }

    /// The camera with an image of `side` x `side` pixels.
    pub fn view(&self, side: u32) -> View {
        pack_camera(&self.camera, &self.film, [side; 2], &self.space.from_world())
    }
}
