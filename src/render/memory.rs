//! The device memory that a render needs, computed before anything is allocated.

use goblet_host::Device;

use crate::gpu_scene::pack::PackedScene;
use crate::image::layers::Groups;
use crate::render::buffers::{Buffers, Sizes};
use crate::render::error::RenderError;
use crate::render::layers::LayerArrays;
use crate::render::lookup::{Lookup, RoughGather};
use crate::render::options::LookupKind;

/// Device memory of a render, in bytes. A device rounds each array up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MemoryNeed {
    /// The arrays of the scene.
    pub scene: u64,
    /// The arrays that a render writes to: visible points, photons, sums, layers, and the index of photons or points.
    pub buffers: u64,
}

impl MemoryNeed {
    /// Returns the memory of a render with these sizes.
    pub fn new(scene: &PackedScene, sizes: &Sizes, lookup: LookupKind, layers: Groups) -> Self {
        let layers = LayerArrays::bytes(layers, sizes.pixels);
        let lookups = Lookup::bytes(lookup, sizes) + RoughGather::bytes(sizes);
        let buffers = (Buffers::bytes(sizes) + lookups).saturating_add(layers);
        Self { scene: scene.arrays.bytes(), buffers }
    }

    /// Returns the sum of both in bytes.
    pub fn total(&self) -> u64 {
        self.scene.saturating_add(self.buffers)
    }

    /// Checks that the render fits in the free memory of the device.
    ///
    /// # Errors
    /// The render does not fit; the error has both numbers.
    pub fn check(&self, device: &Device) -> Result<(), RenderError> {
        let available = device.memory().free_bytes;
        if self.total() <= available {
            return Ok(());
        }
        Err(RenderError::Memory { needed: self.total(), available, scene: self.scene })
    }
}
