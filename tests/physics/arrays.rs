//! The arrays that kernels load from are in images or in buffers, whichever the device loads from faster. No bit
//! of an image depends on it.

use std::sync::Arc;

use goblet::image::layers::{Group, Groups, Layers};
use goblet::scene::Scene;
use goblet::{ArrayKind, DeviceError, DeviceOptions, LookupKind, Options, Renderer, Tally, open_device};
use goblet_host::Device;

use crate::support::{assert_silent, device, device_options, is_full, root};

/// What two iterations come to: the image's bits, its layers, and what happened.
fn outcome(device: &Arc<Device>, scene: &Scene, options: &Options) -> (Vec<[u32; 3]>, Layers, Tally) {
    let mut renderer = Renderer::new(Arc::clone(device), scene, options).expect("a renderer");
    for _ in 0..2 {
        renderer.step().expect("an iteration");
    }
    let estimate = renderer.estimate().expect("an estimate");
    assert_silent(device);
    let bits = estimate.image().pixels.iter().map(|pixel| pixel.map(f32::to_bits)).collect();
    (bits, estimate.layers, *renderer.tally())
}

/// Scenes without a hierarchy and with several, with bodies of revolution, instances and textures. The buffers have guard
/// zones after each array: what is there is no number, and must not get into the image.
#[test]
fn arrays_in_buffers_give_the_same_bits_as_in_images() {
    let options = DeviceOptions { arrays: Some(ArrayKind::Buffers), ..device_options() };
    let mut in_buffers = open_device(&options).expect("a device");
    assert_eq!(in_buffers.info().arrays, ArrayKind::Buffers);
    in_buffers.guard(u32::MAX).expect("guard zones");
    let (in_buffers, usual) = (Arc::new(in_buffers), device());
    let quick = ["cornell-caustic", "revolution", "shapes", "textures"];
    let others = ["layers", "lights", "rough", "spectra"];
    for name in quick.into_iter().chain(others.into_iter().filter(|_| is_full())) {
        let lookup = if name == "shapes" { LookupKind::KdTree } else { LookupKind::HashGrid };
        let scene = Scene::load(root().join(format!("tests/reference/{name}.pbrt"))).expect("a scene");
        for layers in [Groups::default(), Groups::of(&Group::ALL)] {
            let size = Options { resolution: Some([29, 23]), photons: Some(1021), ..Options::default() };
            let options = Options { lookup, layers, responsive: true, ..size };
            let found = outcome(&in_buffers, &scene, &options);
            assert_eq!(in_buffers.broken_guards(), Vec::<String>::new(), "{name}");
            let expected = outcome(&usual, &scene, &options);
            assert!(found == expected, "{name}, {lookup:?}, {layers:?}: the kind of arrays changes the image");
        }
    }
}

/// Images that no tile, subgroup or workgroup divides, and workgroups of each size: no pass writes past the end of an
/// array.
#[test]
fn images_of_odd_sizes_stay_in_their_arrays() {
    let scene = Scene::load(root().join("tests/reference/cornell-caustic.pbrt")).expect("a scene");
    for arrays in [ArrayKind::Images, ArrayKind::Buffers] {
        let options = DeviceOptions { arrays: Some(arrays), ..device_options() };
        let mut device = match open_device(&options) {
            // It binds too few images.
            Err(DeviceError::Unfit { .. }) if arrays == ArrayKind::Images => continue,
            opened => opened.expect("a device"),
        };
        device.guard(u32::MAX).expect("guard zones");
        let device = Arc::new(device);
        for (resolution, workgroup_size) in [([1, 1], 32), ([7, 3], 128), ([1000, 1000], 64), ([1001, 333], 32)] {
            let options = Options {
                resolution: Some(resolution),
                photons: Some(1021),
                eye_paths: Some(1),
                workgroup_size: Some(workgroup_size),
                // Of the small ones.
                layers: if resolution[0] < 10 { Groups::of(&Group::ALL) } else { Groups::default() },
                ..Options::default()
            };
            outcome(&device, &scene, &options);
            assert_eq!(device.broken_guards(), Vec::<String>::new(), "{arrays:?}, {resolution:?}");
        }
    }
}
