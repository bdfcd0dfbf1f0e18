//! Errors of renders.

use crate::base::host_memory::OutOfHostMemory;
use crate::gpu_scene::pack::PackError;

/// The reason why a renderer cannot be made or cannot continue.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// The scene cannot be rendered.
    #[error(transparent)]
    Scene(#[from] PackError),
    /// An option is out of range for this scene.
    #[error("{0}")]
    Option(String),
    /// The driver ended a kernel before the kernel was finished.
    #[error("the driver limits the loops of a kernel, and the {pass} pass of this scene needs more: expected {remedy}")]
    Interrupted {
        /// The pass of the kernel.
        pass: &'static str,
        /// A change that would avoid the error.
        remedy: &'static str,
    },
    /// The caller of [`Renderer::step_unless`] gave the iteration up.
    #[error("the iteration was given up")]
    GivenUp,
    /// The render does not fit in the device's memory.
    #[error(
        "the render needs {} MiB of device memory, of which the scene takes {} MiB, and the device has {} MiB: \
         expected a smaller image, fewer photons per iteration or a smaller scene",
        mebibytes(*needed), mebibytes(*scene), available >> 20
    )]
    Memory {
        /// Bytes of the scene and the render.
        needed: u64,
        /// Bytes that are free on the device.
        available: u64,
        /// Bytes of the scene.
        scene: u64,
    },
    /// The device failed, or lacks memory or a feature.
    #[error(transparent)]
    Device(#[from] goblet_host::Error),
    /// The host does not have enough memory.
    #[error(transparent)]
    Host(#[from] OutOfHostMemory),
}

/// Converts bytes to mebibytes, rounded up.
fn mebibytes(bytes: u64) -> u64 {
    bytes.div_ceil(1 << 20)
}
