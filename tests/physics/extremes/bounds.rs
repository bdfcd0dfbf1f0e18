//! No kernel writes past the end of an array, or lets what is there into the image: arrays have
//! guard zones after them, and hold a pattern before anything is written.

use std::sync::{Arc, LazyLock, Mutex, MutexGuard};

use goblet::kernels::REQUIREMENTS;
use goblet::scene::Scene;
use goblet::{LookupKind, Options, Renderer, Tally};
use goblet_host::{Device, Instance};

use crate::support::{assert_silent, device, is_full, root};

/// As a float, no number; and a plausible index, radius or count.
const PATTERNS: [u32; 2] = [0xffff_ffff, 0x3c3c_3c3c];

/// A device whose guard zones take one pattern after the other. The tests here share it, so that it compiles
/// a kernel once; each waits for it.
struct Guarded(MutexGuard<'static, Arc<Device>>);

impl Guarded {
    fn new() -> Self {
        static DEVICE: LazyLock<Mutex<Arc<Device>>> = LazyLock::new(|| {
            let device = Instance::new(true).expect("Vulkan").open(None, &REQUIREMENTS, None).expect("a device");
            Mutex::new(Arc::new(device))
        });
        Self(DEVICE.lock().unwrap_or_else(std::sync::PoisonError::into_inner))
    }

    /// Renders with guard zones of each pattern, to the same image. In the long form, a device without guard
    /// zones has to come to that image, too.
    fn assert_in_bounds(&mut self, what: &str, scene: &Scene, options: &Options) {
        let [first, second] = PATTERNS.map(|pattern| {
            Arc::get_mut(&mut self.0).expect("no renderer is left").guard(pattern).expect("guard zones");
            let found = outcome(&self.0, scene, options);
            assert_eq!(self.0.broken_guards(), Vec::<String>::new(), "{what}");
            assert_silent(&self.0);
            found
        });
        assert!(first.0 == second.0, "{what}: what is past an array's end, or was in it, is in the image");
        assert_eq!(first.1, second.1, "{what}");
        if is_full() {
            assert!(outcome(&device(), scene, options) == first, "{what}: guard zones change the image");
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
    let (mut device, scene) = (Guarded::new(), glass_ball());
    let [grid, tree] = [LookupKind::HashGrid, LookupKind::KdTree];
    // The quick form has each size with one way to look points up, and each way with every kind of size.
    for (resolution, workgroup_size, responsive, quick) in [
        ([1, 1], 32, false, grid),
        ([37, 53], 128, true, tree),
        ([100, 100], 64, false, tree),
        ([100, 100], 128, false, grid),
        ([1000, 8], 128, false, tree),
        ([3, 1001], 64, true, grid),
    ] {
        for lookup in [grid, tree].into_iter().filter(|lookup| is_full() || *lookup == quick) {
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
            device.assert_in_bounds(&what, &scene, &options);
        }
    }
}

/// Discs that find more photons than an invocation tests in one dispatch: it leaves a place to go on from.
#[test]
fn no_pass_leaves_its_arrays_where_it_goes_on_from_places() {
    let (mut device, scene) = (Guarded::new(), glass_ball());
    for (lookup, quick) in [(LookupKind::HashGrid, 32), (LookupKind::KdTree, 128)] {
        for workgroup_size in [32, 128].into_iter().filter(|size| is_full() || *size == quick) {
            let options = Options {
                resolution: Some([19, 11]),
                photons: Some(50_000),
                radius: Some(3.0),
                workgroup_size: Some(workgroup_size),
                lookup,
                ..Options::default()
            };
            let what = format!("wide discs by {workgroup_size}, {lookup:?}");
            device.assert_in_bounds(&what, &scene, &options);
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
    Guarded::new().assert_in_bounds("long paths", &super::paths::furnace_scene(), &options);
}

/// Every array of a scene.
#[test]
fn no_pass_leaves_its_arrays_whatever_is_in_the_scene() {
    let mut device = Guarded::new();
    for name in ["layers", "lights", "revolution", "rough", "shapes", "textures"] {
        let scene = Scene::load(root().join(format!("tests/reference/{name}.pbrt"))).expect("a scene");
        let options = Options { resolution: Some([29, 23]), photons: Some(1021), ..Options::default() };
        device.assert_in_bounds(name, &scene, &options);
    }
}
