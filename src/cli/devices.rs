//! The subcommand `goblet devices`: lists the Vulkan devices.

use goblet_host::{ArrayKind, DeviceKind, Instance};

use super::{Failure, terminal};
use crate::kernels::REQUIREMENTS;

/// Prints three lines per device.
///
/// # Errors
/// There is no Vulkan loader or no device, or standard output cannot be written to.
pub fn run() -> Result<(), Failure> {
    let devices = Instance::new(false)?.devices(&REQUIREMENTS)?;
    if devices.is_empty() {
        return Err(goblet_host::Error::NoDevice.into());
    }
    let mut text = String::new();
    for device in devices {
        let kind = match device.kind {
            DeviceKind::Discrete => "discrete GPU",
            DeviceKind::Integrated => "integrated GPU",
            DeviceKind::Virtual => "virtual GPU",
            DeviceKind::Cpu => "CPU",
            DeviceKind::Other => "other",
        };
        let gib = device.memory.free_bytes as f64 / f64::from(1 << 30);
        let arrays = match device.arrays {
            ArrayKind::Images => "images",
            ArrayKind::Buffers => "buffers",
        };
        let verdict = device.unfit.map_or_else(|| "fits".to_owned(), |reason| format!("does not fit: {reason}"));
        text += &format!("{}  {}\n", device.index, device.name);
        text += &format!("   {kind}; driver {}; {gib:.1} GiB free; {verdict}\n", device.driver);
        text += &format!("   arrays in {arrays}: {}\n", device.arrays_reason);
    }
    terminal::print(&text)
}
