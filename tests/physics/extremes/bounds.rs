//! No kernel writes past the end of an array, or lets what is there into the image: arrays have
//! guard zones after them, and hold a pattern before anything is written.

use std::sync::Arc;

use goblet::kernels::REQUIREMENTS;
use goblet::scene::Scene;
use goblet::{LookupKind, Options, Renderer, Tally};
use goblet_host::{Device, Instance};

use crate::support::{assert_silent, device, root, work};

/// As a float, no number; and a plausible index, radius or count.
const PATTERNS: [u32; 2] = [0xffff_ffff, 0x3c3c_3c3c];

/// A device as users have it, and guarded ones.
struct Devices {
    plain: Arc<Device>,
    guarded: Vec<Arc<Device>>,
}

impl Devices {
    fn new() -> Self {
        let guarded = |pattern| {
            let mut device = Instance::new(true).expect("Vulkan").open(None, &REQUIREMENTS).expect("a device");
            device.guard(pattern).expect("guard zones");
            Arc::new(device)
        };
        Self { plain: device(), guarded: PATTERNS.map(guarded).into() }
    }

    /// Renders without and with guard zones: in the quick form with one pattern, which cases take in
    /// turn by their number.
    fn assert_in_bounds(&self, case: usize, what: &str, scene: &Scene, options: &Options) {
        let expected = outcome(&self.plain, scene, options);
        let one = &self.guarded[case % self.guarded.len()..][..1];
        for device in work(one, &self.guarded) {
            let found = outcome(device, scene, options);
            assert_eq!(device.broken_guards(), Vec::<String>::new(), "{what}");
            assert!(found.0 == expected.0, "{what}: what is past an array's end, or was in it, is in the image");
            assert_eq!(found.1, expected.1, "{what}");
            assert_silent(device);
        }
    }
}

/// What two iterations come to: the image's bits, and what happened.
fn outcome(device: &Arc<Device>, scene: &Scene, options: &Options) -> (Vec<[u32; 3]>, Tally) {
    let mut renderer = Renderer::new(Arc::clone(device), scene, options).expect("a renderer");
    for _ in 0..2 {
        renderer.step().expect("an iteration");
    }
    let image = renderer.resolve().expect("an image");
    (image.pixels.iter().map(|pixel| pixel.map(f32::to_bits)).collect(), *renderer.tally())
}

fn glass_ball() -> Scene {
    Scene::parse(crate::support::command::SCENE, "scene.pbrt", root()).expect("a scene")
}

/// Sizes that fill neither tiles nor workgroups, in one dispatch or in many.
#[test]
fn no_pass_leaves_its_arrays_whatever_the_size() {
    let (devices, scene) = (Devices::new(), glass_ball());
    for (i, (resolution, workgroup_size, responsive)) in [
        ([1, 1], 32, false),
        ([37, 53], 128, true),
        ([100, 100], 64, false),
        ([100, 100], 128, false),
        ([1000, 8], 128, false),
        ([3, 1001], 64, true),
    ]
    .into_iter()
    .enumerate()
    {
        for lookup in [LookupKind::HashGrid, LookupKind::KdTree] {
            let options = Options {
                resolution: Some(resolution),
                photons: Some(1021),
                batch_size: responsive.then_some(509),
                workgroup_size: Some(workgroup_size),
                lookup,
                responsive,
                ..Options::default()
            };
            let what = format!("{resolution:?} by {workgroup_size}, {lookup:?}, responsive: {responsive}");
            devices.assert_in_bounds(i, &what, &scene, &options);
        }
    }
}

/// Discs that find so many photons that invocations leave places to go on from.
#[test]
fn no_pass_leaves_its_arrays_where_it_goes_on_from_places() {
    let (devices, scene) = (Devices::new(), glass_ball());
    for lookup in [LookupKind::HashGrid, LookupKind::KdTree] {
        for workgroup_size in [32, 128] {
            let options = Options {
                resolution: Some([19, 11]),
                photons: Some(50_000),
                radius: Some(3.0),
                workgroup_size: Some(workgroup_size),
                lookup,
                ..Options::default()
            };
            let what = format!("wide discs by {workgroup_size}, {lookup:?}");
            devices.assert_in_bounds(workgroup_size as usize / 32, &what, &scene, &options);
        }
    }
}

/// Eye and photon paths that go on in another dispatch.
#[test]
fn no_pass_leaves_its_arrays_where_paths_are_long() {
    let options = Options {
        resolution: Some([11, 7]),
        photons: Some(77),
        eye_paths: Some(1),
        max_depth: Some(256),
        ..Options::default()
    };
    Devices::new().assert_in_bounds(0, "long paths", &super::paths::furnace_scene(), &options);
}

/// Every array of a scene.
#[test]
fn no_pass_leaves_its_arrays_whatever_is_in_the_scene() {
    let devices = Devices::new();
    for (i, name) in ["layers", "lights", "revolution", "rough", "shapes", "textures"].into_iter().enumerate() {
        let scene = Scene::load(root().join(format!("tests/reference/{name}.pbrt"))).expect("a scene");
        let options = Options { resolution: Some([29, 23]), photons: Some(1021), ..Options::default() };
        devices.assert_in_bounds(i, name, &scene, &options);
    }
}
