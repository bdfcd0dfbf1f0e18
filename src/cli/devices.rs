//! The subcommand `goblet devices`: lists the Vulkan devices. docs/json.md lists the keys of the JSON.

use goblet_host::{ArrayKind, DeviceInfo, DeviceKind, Instance};
use serde::Serialize;

use super::{DevicesArgs, Failure, terminal};
use crate::base::names::Named;
use crate::kernels::{REQUIREMENTS, Specialization};
use crate::render::is_queue;
use crate::render::options::{DEFAULT_WORKGROUP_SIZE, LookupKind};

/// The version of the keys of the JSON and of their meaning. It is raised when one vanishes, or changes its type or
/// its meaning; keys are added without.
const SCHEMA_VERSION: u32 = 1;

#[derive(Serialize)]
struct List {
    schema_version: u32,
    devices: Vec<Device>,
}

/// A device: what it is, and what goblet uses on it and why.
#[derive(Serialize)]
struct Device {
    index: usize,
    name: String,
    kind: &'static str,
    driver: String,
    memory: Memory,
    /// The reason why it cannot render; `None` if it can.
    unfit: Option<String>,
    arrays: &'static str,
    arrays_reason: String,
    /// Lanes of a subgroup; `None` if each kernel finds how many.
    lanes: Option<u32>,
    /// The largest number of lanes.
    most_lanes: u32,
    /// Whether kernels are compiled for this number of lanes.
    lanes_are_required: bool,
    lookup: &'static str,
    has_ray_queue: bool,
    keeps_infinities: bool,
}

/// The memory of a device in bytes.
#[derive(Serialize)]
struct Memory {
    total: u64,
    free: u64,
}

/// Prints the devices: five lines for each, or JSON.
///
/// # Errors
/// There is no Vulkan loader or no device, or standard output cannot be written to.
pub fn run(args: DevicesArgs) -> Result<(), Failure> {
    let devices = Instance::new(false)?.devices(&REQUIREMENTS)?;
    if devices.is_empty() {
        return Err(goblet_host::Error::NoDevice.into());
    }
    let list = List { schema_version: SCHEMA_VERSION, devices: devices.into_iter().map(Device::from).collect() };
    if args.json {
        let json = serde_json::to_value(&list).map_err(|error| Failure::Info(error.to_string()))?;
        return terminal::print(&format!("{json:#}\n"));
    }
    terminal::print(&list.devices.iter().map(Device::text).collect::<String>())
}

impl From<DeviceInfo> for Device {
    fn from(info: DeviceInfo) -> Self {
        let lookup = if info.subgroups.has_shuffle { LookupKind::HashGrid } else { LookupKind::KdTree };
        Self {
            index: info.index,
            name: info.name,
            kind: match info.kind {
                DeviceKind::Discrete => "discrete GPU",
                DeviceKind::Integrated => "integrated GPU",
                DeviceKind::Virtual => "virtual GPU",
                DeviceKind::Cpu => "CPU",
                DeviceKind::Other => "other",
            },
            driver: info.driver,
            memory: Memory { total: info.memory.total_bytes, free: info.memory.free_bytes },
            unfit: info.unfit,
            arrays: match info.arrays {
                ArrayKind::Images => "images",
                ArrayKind::Buffers => "buffers",
            },
            arrays_reason: info.arrays_reason,
            lanes: info.subgroups.lanes(DEFAULT_WORKGROUP_SIZE),
            most_lanes: info.subgroups.size,
            lanes_are_required: info.subgroups.required.is_some(),
            lookup: lookup.name(),
            has_ray_queue: is_queue(info.kind, &Specialization::DECLARED.scene),
            keeps_infinities: info.keeps_infinities,
        }
    }
}

impl Device {
    fn text(&self) -> String {
        let Self { index, name, kind, driver, arrays, arrays_reason, .. } = self;
        let gib = self.memory.free as f64 / f64::from(1 << 30);
        let verdict = self.unfit.as_ref().map_or_else(|| "fits".to_owned(), |reason| format!("does not fit: {reason}"));
        let floats = if self.keeps_infinities { "kept, as goblet asks for" } else { "left to the driver" };
        let rays = if self.has_ray_queue {
            "rays from a queue: a CPU skips code that no lane needs"
        } else {
            "each lane follows its ray to the end"
        };
        format!(
            "{index}  {name}\n\
             \x20  {kind}; driver {driver}; {gib:.1} GiB free; {verdict}\n\
             \x20  arrays in {arrays}: {arrays_reason}\n\
             \x20  {}\n\
             \x20  {rays}; infinities and NaN are {floats}\n",
            self.lanes_text()
        )
    }

    /// Returns how many invocations run together, and what follows.
    fn lanes_text(&self) -> String {
        let lanes = match self.lanes {
            Some(lanes) if self.lanes_are_required => format!("subgroups of {lanes} lanes, as goblet requires"),
            Some(lanes) => format!("subgroups of {lanes} lanes"),
            None => format!("subgroups of at most {} lanes: each kernel finds how many", self.most_lanes),
        };
        let lookup = if self.lookup == LookupKind::HashGrid.name() {
            "hash grid"
        } else {
            "kd-tree, since subgroups have no shuffle"
        };
        format!("{lanes}; photons are found by {lookup}")
    }
}
