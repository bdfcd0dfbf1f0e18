//! Errors of the Vulkan layer.

use std::io;

use ash::vk;

/// The result of every fallible call of this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// A failure of the Vulkan layer.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// There is no Vulkan loader on this machine.
    #[error(
        "no Vulkan loader found ({0}); without a GPU, install lavapipe: \
         apt-get install --no-install-recommends libvulkan1 mesa-vulkan-drivers"
    )]
    NoLoader(String),
    /// The loader finds no device at all.
    #[error(
        "no Vulkan device found; without a GPU, install lavapipe: \
         apt-get install --no-install-recommends libvulkan1 mesa-vulkan-drivers"
    )]
    NoDevice,
    /// Validation was asked for, but the layer is not installed.
    #[error("the Vulkan validation layer is not installed: apt-get install vulkan-validationlayers")]
    NoValidationLayer,
    /// No device has the index or name that was asked for.
    #[error("no device matches \"{wanted}\"; there are: {available}")]
    NoSuchDevice {
        /// The index or name.
        wanted: String,
        /// The devices that exist.
        available: String,
    },
    /// The device lacks something that goblet needs.
    #[error("{device} cannot run goblet: {reason}")]
    Unfit {
        /// The device's name.
        device: String,
        /// The feature or limit that it lacks.
        reason: String,
    },
    /// A buffer is larger than one binding of the device can be.
    #[error(
        "the array {buffer} needs {} MiB, but this device binds at most {} MiB at once: expected a smaller image or \
         fewer photons per iteration",
        mebibytes(*bytes), limit >> 20
    )]
    BufferTooLarge {
        /// The buffer's name.
        buffer: String,
        /// Bytes that the buffer needs.
        bytes: u64,
        /// `maxStorageBufferRange`.
        limit: u64,
    },
    /// The device has not enough memory.
    #[error(
        "out of device memory: the array {buffer} needs {} MiB besides the {} MiB that are held; {} MiB were free when \
         the device was opened: expected a smaller image or fewer photons per iteration",
        mebibytes(*bytes), mebibytes(*held), free >> 20
    )]
    OutOfMemory {
        /// The buffer's name.
        buffer: String,
        /// Bytes that the buffer needs.
        bytes: u64,
        /// Bytes that other buffers hold.
        held: u64,
        /// Bytes that were free when the device was opened: [`crate::DeviceMemory::free_bytes`].
        free: u64,
    },
    /// The device does not show images in this kind of window.
    #[error("{0} cannot show images in a window; goblet render needs none")]
    NoPresentation(String),
    /// The interface could not be drawn.
    #[error("cannot draw the interface: {0}")]
    Interface(String),
    /// The device stopped running commands.
    #[error("the device was lost while it ran the pass {pass}")]
    DeviceLost {
        /// The kernel that was running.
        pass: String,
    },
    /// The system refuses to start a thread.
    #[error("cannot start a thread: {0}")]
    Thread(io::Error),
    /// Any other failed call.
    #[error("{call} failed: {result}")]
    Vulkan {
        /// The Vulkan function, or what it was called for.
        call: &'static str,
        /// The result of the call.
        result: vk::Result,
    },
}

/// Converts bytes to mebibytes, rounded up.
fn mebibytes(bytes: u64) -> u64 {
    bytes.div_ceil(1 << 20)
}

/// Adds the name of the call to a Vulkan error.
pub(crate) trait Context<T> {
    fn context(self, call: &'static str) -> Result<T>;
}

impl<T> Context<T> for ash::prelude::VkResult<T> {
    fn context(self, call: &'static str) -> Result<T> {
        self.map_err(|result| Error::Vulkan { call, result })
    }
}
