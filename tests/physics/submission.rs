//! An iteration in one submission, as on a GPU, is the one in pieces, bit by bit; and it is one submission.

use std::sync::Arc;

use goblet::scene::Scene;
use goblet::{Integrator, Options, RadiusSchedule, Renderer, Shard, Submission, Tally, open_device};
use goblet_host::Device;

use crate::support::{assert_silent, device_options, root, work};

const ITERATIONS: usize = 4;

/// What some iterations come to.
#[derive(PartialEq)]
struct Outcome {
    bits: Vec<[u32; 3]>,
    tally: Tally,
    relative_error: Option<f64>,
}

/// The outcome, and the number of submissions of each iteration.
fn render(device: &Arc<Device>, scene: &Scene, options: &Options) -> (Outcome, Vec<u64>) {
    let mut renderer = Renderer::new(Arc::clone(device), scene, options).expect("a renderer");
    let mut submissions = Vec::new();
    for _ in 0..ITERATIONS {
        let before = device.submissions();
        renderer.step().expect("an iteration");
        submissions.push(device.submissions() - before);
    }
    let image = renderer.resolve().expect("an image");
    let bits = image.pixels.iter().map(|pixel| pixel.map(f32::to_bits)).collect();
    let relative_error = renderer.relative_error().expect("an estimate");
    (Outcome { bits, tally: *renderer.tally(), relative_error }, submissions)
}

/// Renders in pieces and in one submission on a device of its own, and returns the submissions of both.
fn compare(name: &str, scene: &Scene, options: Options) -> [Vec<u64>; 2] {
    let device = Arc::new(open_device(&device_options()).expect("a device"));
    let [pieces, whole] = [Submission::Pieces, Submission::Whole]
        .map(|submission| render(&device, scene, &Options { submission, ..options.clone() }));
    assert!(pieces.0 == whole.0, "{name}: {:?} in pieces, {:?} in one submission", pieces.0.tally, whole.0.tally);
    assert_silent(&device);
    println!("{name}: {:?} submissions in pieces, {:?} in one", pieces.1, whole.1);
    [pieces.1, whole.1]
}

fn load(name: &str) -> Scene {
    Scene::load(root().join(format!("tests/reference/{name}.pbrt"))).expect("a scene")
}

fn small() -> Options {
    Options { resolution: Some([29, 23]), photons: Some(1021), ..Options::default() }
}

/// The first iteration measures visible points, which takes the host.
#[test]
fn an_iteration_is_one_submission_with_the_same_bits() {
    let others = work(&[][..], &["layers", "lights", "rough", "shapes", "spectra", "textures"]);
    for name in ["cornell-caustic", "revolution"].iter().chain(others) {
        let [pieces, whole] = compare(name, &load(name), small());
        assert!(pieces.iter().all(|count| *count >= 6), "{name}: {pieces:?}");
        assert_eq!(whole[1..], [1; ITERATIONS - 1], "{name}");
    }
}

/// Visible points of several iterations, radii of each pixel, and a part of the iterations.
#[test]
fn rounds_schedules_and_shards_in_one_submission_have_the_same_bits() {
    let (ppm, global) = (Integrator::Ppm, RadiusSchedule::Global);
    let shard = Shard { index: 1, count: 3 };
    for (name, options) in [
        ("rounds", Options { integrator: ppm, photons_per_round: Some(2042), ..small() }),
        ("global", Options { radius_schedule: global, ..small() }),
        ("data", Options { radius_schedule: RadiusSchedule::Data, ..small() }),
        ("data rounds", Options { integrator: ppm, radius_schedule: RadiusSchedule::Data, ..small() }),
        ("global rounds", Options { integrator: ppm, radius_schedule: global, ..small() }),
        ("a shard", Options { shard, radius_schedule: global, ..small() }),
        ("a shard with a radius", Options { shard, integrator: ppm, radius: Some(0.1), ..small() }),
        ("responsive", Options { responsive: true, ..small() }),
    ] {
        let [_, whole] = compare(name, &load("cornell-caustic"), options);
        assert_eq!(whole.last(), Some(&1), "{name}: {whole:?}");
    }
}

/// More records than there is room for: the iteration is run again in batches, and nothing is lost.
#[test]
fn too_many_records_for_one_submission_lose_nothing() {
    let options = Options { photons: Some(1_300_000), ..small() };
    let [_, whole] = compare("too many records", &load("cornell-caustic"), options);
    assert!(whole[1] > 1, "{whole:?}");
}

/// More photons on a disc than a driver lets one dispatch gather.
#[test]
fn what_one_dispatch_cannot_gather_is_gathered_in_pieces() {
    let options = Options { photons: Some(1 << 17), radius: Some(3.0), resolution: Some([8, 8]), ..Options::default() };
    let [_, whole] = compare("a wide radius", &load("cornell-caustic"), options);
    assert!(whole[1] > 6, "{whole:?}");
}
