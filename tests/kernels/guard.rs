//! Guard zones notice a kernel that writes past the ends of its arrays, whatever these are in.

use bytemuck::Pod;
use goblet::{ArrayKind, Device, DeviceError, DeviceOptions, open_device};
use goblet_host::{Buffer, Extent, Texels};

use crate::generated::{PixelState, Specialization, Update, UpdatePush};
use crate::support::device_options;

const SUMS: [&str; 4] = ["sum_red", "sum_green", "sum_blue", "sum_second"];

/// Runs the update of two pixels on arrays of one, and returns what the guard zones tell.
fn broken_by_update(device: &Device) -> Vec<String> {
    fn texels<T: Pod>(device: &Device, name: &'static str) -> Texels<T> {
        device.texels(name, 1).expect("texels")
    }
    let words = |name, length| -> Buffer<u32> { device.buffer(name, length).expect("a buffer") };
    let mut group = device.group("sums", &SUMS.map(|name| Extent::of::<[u32; 4]>(name, 1))).expect("a group");
    let sums: [Texels<[u32; 4]>; 4] = SUMS.map(|_| group.take());
    let counters = device.buffer("counters", 1).expect("a buffer");
    let kernel = Update {
        visible_radii2: &texels(device, "visible_radii2"),
        visible_throughputs: &texels(device, "visible_throughputs"),
        visible_radiances: &texels(device, "visible_radiances"),
        pixel_states: &texels::<PixelState>(device, "pixel_states"),
        sum_red: &sums[0],
        sum_green: &sums[1],
        sum_blue: &sums[2],
        sum_second: &sums[3],
        counters: &counters,
        flux_red: &words("flux_red", 2),
        flux_green: &words("flux_green", 2),
        flux_blue: &words("flux_blue", 2),
        flux_counts: &words("flux_counts", 1),
    };
    let pass = device.pass(&kernel, &Specialization::DECLARED, 64).expect("a pass");
    let push = UpdatePush {
        luminance: [0.2, 0.7, 0.1],
        pixel_count: 2,
        alpha: 0.5,
        per_unit: 1.0,
        flux_scale: 0.01,
        half_of_rounds: 1,
        capacity: 0,
        rough_scale: 0.0,
        kept: 1.0,
        pad0: 0,
    };
    let mut frame = device.frame().expect("a frame");
    frame.clear(&counters);
    frame.dispatch(&pass, push, 2);
    frame.run().expect("a run");
    device.broken_guards()
}

#[test]
fn a_write_past_the_end_of_an_array_is_noticed() {
    for arrays in [ArrayKind::Images, ArrayKind::Buffers] {
        let options = DeviceOptions { arrays: Some(arrays), ..device_options() };
        let mut device = match open_device(&options) {
            // It binds too few images.
            Err(DeviceError::Unfit { .. }) if arrays == ArrayKind::Images => continue,
            opened => opened.expect("a device"),
        };
        // As a float, a small number.
        device.guard(0x3c3c_3c3c).expect("guard zones");
        let broken = broken_by_update(&device);
        for name in SUMS.into_iter().chain(["pixel_states", "flux_red", "flux_counts"]) {
            let end = format!(" bytes after the end of {name}");
            let is_told = broken.iter().any(|told| told.starts_with("update: wrote ") && told.ends_with(&end));
            assert!(is_told, "{arrays:?}: {name} is not in {broken:#?}");
        }
    }
}
