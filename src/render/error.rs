//! Why a render fails.

use crate::base::room::NoRoom;
use crate::gpu_scene::pack::PackError;

/// Why a renderer cannot be made or cannot go on.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// The scene cannot be rendered.
    #[error(transparent)]
    Scene(#[from] PackError),
    /// An option is out of range for this scene.
    #[error("{0}")]
    Option(String),
    /// The driver ended a kernel before it was done.
    #[error("the driver limits the loops of a kernel, and the {pass} pass of this scene needs more: expected {remedy}")]
    Interrupted {
        /// The pass.
        pass: &'static str,
        /// What would help.
        remedy: &'static str,
    },
    /// The caller of [`Renderer::step_unless`] did not want the iteration any more.
    #[error("the iteration was given up")]
    GivenUp,
    /// The render does not fit in the device's memory.
    #[error(
        "the render needs {} MiB of device memory, of which the scene takes {} MiB, and the device has {} MiB: \
         expected a smaller image, fewer photons per iteration or a smaller scene",
        mebibytes(*needed), mebibytes(*scene), available >> 20
    )]
    Memory {
        /// Bytes of scene and render.
        needed: u64,
        /// Bytes that the device has free.
        available: u64,
        /// Bytes of the scene.
        scene: u64,
    },
    /// The device failed or is not enough.
    #[error(transparent)]
    Device(#[from] goblet_host::Error),
    /// The host's memory is not enough.
    #[error(transparent)]
    Host(#[from] NoRoom),
}

/// Mebibytes, rounded up.
fn mebibytes(bytes: u64) -> u64 {
    bytes.div_ceil(1 << 20)
}
