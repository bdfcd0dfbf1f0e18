//! The values of the kernels' specialization constants in a render.

use goblet_host::DeviceInfo;

use super::device::device_features;
use super::error::RenderError;
use super::options::{Options, Resolved};
use super::passes::is_queue;
use crate::gpu_scene::camera::{View, pack_camera};
use crate::gpu_scene::pack::pack;
use crate::kernels::{DeviceFeatures, MaterialFeatures, PassFeatures, SceneFeatures, Specialization};
use crate::scene::Scene;

/// Returns what kernels are specialised to, from the parts that decide it. Those that follow paths may have a
/// queue besides.
pub(crate) fn specialization(
    scene: SceneFeatures,
    material: MaterialFeatures,
    view: &View,
    options: &Options,
    resolved: &Resolved,
    device: DeviceFeatures,
) -> Specialization {
    Specialization {
        scene,
        material,
        camera: view.features(),
        render: options.features(resolved),
        device,
        pass: PassFeatures { is_resumable: false, is_queue: false, gathers_caustics: false, sorts_rough: false },
    }
}

/// Returns what the kernels that render a scene on a device are specialised to, and the size of their
/// workgroups.
///
/// # Errors
/// The scene cannot be rendered, or an option is out of range.
pub fn specialized(
    scene: &Scene,
    options: &Options,
    device: &DeviceInfo,
) -> Result<(Specialization, u32), RenderError> {
    let packed = pack(scene, options.packing(scene))?;
    let resolved = options.resolve(scene, packed.space.radius / packed.space.scale)?;
    let view = pack_camera(&scene.camera, &scene.film, resolved.window.full, &packed.space.from_world());
    let size = resolved.workgroup_size;
    let device_features = device_features(device, size);
    let is_queue = is_queue(device.kind, &packed.features);
    let pass = PassFeatures { is_resumable: false, is_queue, gathers_caustics: false, sorts_rough: false };
    let all = specialization(packed.features, packed.material_features, &view, options, &resolved, device_features);
    Ok((Specialization { pass, ..all }, size))
}
