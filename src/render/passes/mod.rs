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
    /// drivers may leave compilation to the first dispatch.
    ///
    /// # Errors
    /// The driver refuses a kernel, or the device is out of memory.
    pub fn new(
        device: &Device,
        scene: GpuScene,
        (buffers, layers): (&Buffers, Option<LayerArrays>),
        sizes: &Sizes,
        lookup: LookupKind,
        specialization: &Specialization,
        workgroup_size: u32,
    ) -> goblet_host::Result<Self> {
        let is_queue = is_queue(device.info().kind, &specialization.scene);
        let kernels = Arc::new(PathKernels { scene, specialization: *specialization, workgroup_size, is_queue });
        // The kernels that follow paths take the longest to compile: both start at once.
        let eye = kernels.eye(device, buffers, false)?;
        let photon = kernels.photon(device, buffers, false)?;
        let caustics = layers.as_ref().and_then(LayerArrays::caustics);
        let rough = specialization.scene.has_rough_gather;
        let rough =
            rough.then(|| RoughGather::new(device, &kernels.scene, (buffers, sizes), specialization, workgroup_size));
        let passes = Self {
            rough: rough.transpose()?,
            radius: RadiusPass::new(device, buffers, specialization, workgroup_size)?,
            lookup: Lookup::new(device, (buffers, caustics), sizes, lookup, specialization, workgroup_size)?,
            update: UpdatePass::new(device, buffers, specialization, workgroup_size)?,
            photon: PhotonPass::new(photon.finish()?, Arc::clone(&kernels)),
            layers: layers.map(|arrays| LayerPasses::new(device, buffers, arrays, &kernels)).transpose()?,
            eye: EyePass::new(eye.finish()?, kernels),
        };
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
