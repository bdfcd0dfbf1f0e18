//! The subcommand `goblet devices`: lists the Vulkan devices.

use goblet_host::{ArrayKind, DeviceInfo, DeviceKind, Instance};

use super::{Failure, terminal};
use crate::kernels::{REQUIREMENTS, Specialization};
use crate::render::is_queue;
use crate::render::options::DEFAULT_WORKGROUP_SIZE;

/// Prints five lines per device: what it is, and what goblet uses on it and why.
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
        let verdict =
            device.unfit.as_ref().map_or_else(|| "fits".to_owned(), |reason| format!("does not fit: {reason}"));
        text += &format!("{}  {}\n", device.index, device.name);
        text += &format!("   {kind}; driver {}; {gib:.1} GiB free; {verdict}\n", device.driver);
        let floats = if device.keeps_infinities { "kept, as goblet asks for" } else { "left to the driver" };
        text += &format!("   arrays in {arrays}: {}\n   {}\n", device.arrays_reason, lanes(&device));
        text += &format!("   {}; infinities and NaN are {floats}\n", rays(&device));
    }
    terminal::print(&text)
}

/// How many invocations run together, and what follows.
fn lanes(device: &DeviceInfo) -> String {
    let subgroups = &device.subgroups;
    let lanes = match (subgroups.lanes(DEFAULT_WORKGROUP_SIZE), subgroups.required) {
        (Some(lanes), Some(_)) => format!("subgroups of {lanes} lanes, as goblet requires"),
        (Some(lanes), None) => format!("subgroups of {lanes} lanes"),
        (None, _) => format!("subgroups of at most {} lanes: each kernel finds how many", subgroups.size),
    };
    let lookup = if subgroups.has_shuffle { "hash grid" } else { "kd-tree, since subgroups have no shuffle" };
    format!("{lanes}; photons are found by {lookup}")
}

/// How rays are followed where a scene has a hierarchy.
fn rays(device: &DeviceInfo) -> &'static str {
    if is_queue(device.kind, &Specialization::DECLARED.scene) {
        "rays from a queue: a CPU skips code that no lane needs"
    } else {
        "each lane follows its ray to the end"
    }
}
