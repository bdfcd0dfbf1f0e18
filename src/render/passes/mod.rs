//! The passes of an iteration, compiled for a scene and bound to its buffers. Each pass has a file with the
//! name of its kernel. The passes that build and read an index are in `lookup`.

mod eye;
mod layers;
mod path;
mod photon;
mod radius;
mod update;

use std::sync::Arc;
use std::time::Duration;

use eye::EyePass;
use goblet_host::{Device, DeviceKind};
pub use layers::LayerPasses;
use path::PathKernels;
pub use photon::PhotonPass;
use radius::RadiusPass;
use update::UpdatePass;

use crate::kernels::{GpuScene, SceneFeatures, Specialization};
use crate::render::activity::{Kernels, Observer};
use crate::render::buffers::{Buffers, Sizes};
use crate::render::layers::LayerArrays;
use crate::render::lookup::{Lookup, RoughGather};
use crate::render::options::LookupKind;

/// Returns whether the lanes of a subgroup work together on a queue of rays, where paths are followed. A CPU
/// jumps over code that no lane needs; where all lanes test the same primitives, none waits.
pub fn is_queue(kind: DeviceKind, scene: &SceneFeatures) -> bool {
    kind == DeviceKind::Cpu && !scene.is_flat
}

/// The passes of an iteration.
pub struct Passes {
    /// Eye paths to visible points.
    pub eye: EyePass,
    /// Radii of visible points.
    pub radius: RadiusPass,
    /// Photon paths to records.
    pub photon: PhotonPass,
    /// The index that photons and visible points are brought together by, and the gather pass.
    pub lookup: Lookup,
    /// The photons on rough surfaces and what gathers them; `None` where none is recorded.
    pub rough: Option<RoughGather>,
    /// The iteration's image into the mean.
    pub update: UpdatePass,
    /// The iteration's layers into theirs; `None` if none is asked for.
    pub layers: Option<LayerPasses>,
}

impl Passes {
    /// Compiles the passes for a scene and runs each once without an invocation that works, since
    /// drivers may leave compilation to the first dispatch. `observer` is told how many kernels are compiled.
    ///
    /// # Errors
    /// The driver refuses a kernel, or the device is out of memory.
    pub fn new(
        device: &Device,
        scene: GpuScene,
        (buffers, layers): (&Buffers, Option<LayerArrays>),
        sizes: &Sizes,
        lookup: LookupKind,
        (specialization, workgroup_size): (&Specialization, u32),
        observer: &Observer,
    ) -> goblet_host::Result<Self> {
        let is_queue = is_queue(device.info().kind, &specialization.scene);
        let kernels = Arc::new(PathKernels { scene, specialization: *specialization, workgroup_size, is_queue });
        // The kernels that follow paths take the longest to compile: both start at once.
        let eye = kernels.eye(device, buffers, false)?;
        let photon = kernels.photon(device, buffers, false)?;
        let caustics = layers.as_ref().and_then(LayerArrays::caustics);
        let rough = specialization.scene.has_rough_gather;
        let of_rough = if rough { RoughGather::KERNELS } else { 0 };
        let of_lookup = Lookup::kernels(lookup, caustics.is_some());
        let of_layers = layers.as_ref().map_or(0, LayerPasses::kernels);
        // Four are those of eye paths, radii, photons and the update.
        let mut kernels_done = Kernels::new(observer, 4 + of_rough + of_lookup + of_layers);
        let mut compiled = |count| kernels_done.compiled(count);
        let rough =
            rough.then(|| RoughGather::new(device, &kernels.scene, (buffers, sizes), specialization, workgroup_size));
        let rough = rough.transpose()?;
        compiled(of_rough);
        let radius = RadiusPass::new(device, buffers, specialization, workgroup_size)?;
        compiled(1);
        let lookup = Lookup::new(device, (buffers, caustics), sizes, lookup, specialization, workgroup_size)?;
        compiled(of_lookup);
        let update = UpdatePass::new(device, buffers, specialization, workgroup_size)?;
        compiled(1);
        let photon = PhotonPass::new(photon.finish()?, Arc::clone(&kernels));
        compiled(1);
        let layers = layers.map(|arrays| LayerPasses::new(device, buffers, arrays, &kernels)).transpose()?;
        compiled(of_layers);
        let passes = Self { rough, radius, lookup, update, photon, layers, eye: EyePass::new(eye.finish()?, kernels) };
        compiled(1);
        passes.warm_up(device)?;
        Ok(passes)
    }

    /// Time that the host, rather than the device, has spent on indices of visible points.
    pub fn index_host_time(&self) -> Duration {
        self.lookup.host_time()
    }

    fn warm_up(&self, device: &Device) -> goblet_host::Result<()> {
        let mut frame = device.frame()?;
        self.eye.warm_up(&mut frame);
        self.radius.warm_up(&mut frame);
        self.lookup.warm_up(&mut frame);
        if let Some(rough) = &self.rough {
            rough.warm_up(&mut frame);
        }
        self.photon.warm_up(&mut frame);
        self.update.warm_up(&mut frame);
        if let Some(layers) = &self.layers {
            layers.warm_up(&mut frame);
        }
        frame.run()
    }
}
