//! Lanes: subgroup_lanes.

use goblet::render::device_features;

use crate::fixture::Fixture;
use crate::generated::{CountLanes, Specialization};

/// Invocations of a workgroup of the kernel.
const WORKGROUP_SIZE: u32 = 64;

/// What kernels take for the number of lanes is what runs together, whether the device tells it or each
/// invocation finds it.
#[test]
fn kernels_know_how_many_lanes_run_together() {
    let fixture = Fixture::new();
    let told_by_device =
        Specialization { device: device_features(fixture.device().info(), WORKGROUP_SIZE), ..Specialization::DECLARED };
    for specialization in [Specialization::DECLARED, told_by_device] {
        let (counted, told) = (fixture.output::<u32>(1024), fixture.output::<u32>(1024));
        fixture.run_specialized(&CountLanes { counted: &counted, told: &told }, &specialization, 1024);
        let counted = fixture.read(&counted);
        assert!(counted.iter().all(|lanes| *lanes >= 1 && *lanes <= WORKGROUP_SIZE), "{counted:?}");
        assert_eq!(counted, fixture.read(&told), "{:?}", specialization.device);
    }
}
