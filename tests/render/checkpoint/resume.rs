//! Stopped and resumed.

use goblet::{DirectLight, Guidance, Integrator, Options, RadiusSchedule};

use super::{Case, advance, bits, energy, save};
use crate::support;
use crate::support::command::Bench;

const ITERATIONS: u32 = 13;
/// In the middle of a round of [`ROUND`] iterations, and at the end of one.
const STOPS: [u32; 2] = [3, 10];
const ROUND: u64 = 5;

fn cases() -> Vec<Case> {
    let sppm = Options::default();
    let ppm = Options { integrator: Integrator::Ppm, photons_per_round: Some(500 * ROUND), ..Options::default() };
    let global = |options: &Options| Options { radius_schedule: RadiusSchedule::Global, ..options.clone() };
    let data = |options: &Options| Options { radius_schedule: RadiusSchedule::Data, ..options.clone() };
    vec![
        Case::new("ppm, data", data(&ppm)),
        Case::new("sppm, data, dispersion", data(&sppm)).with_automatic_radius().with_dispersion(),
        Case::new("ppm, global", global(&ppm)),
        Case::new("sppm, global", global(&sppm)),
        Case::new("ppm, adaptive, dispersion", ppm.clone()).with_dispersion(),
        Case::new("sppm, adaptive, automatic radius", sppm.clone()).with_automatic_radius(),
        Case::new("guided", Options { guidance: Guidance::On, ..ppm.clone() }).with_automatic_radius(),
        Case::new("ppm, adaptive, automatic radius", ppm).with_automatic_radius(),
        Case::new("light by photons", Options { direct: DirectLight::Photons, ..sppm }),
    ]
}

/// Sums, states of pixels, first radius and counts too.
#[test]
fn a_stop_does_not_change_a_bit() {
    let device = support::device();
    for case in cases() {
        let mut whole = case.renderer(&device);
        advance(&mut whole, STOPS[0]);
        let mut checkpoint = save(&whole);
        for stop in [STOPS[1], ITERATIONS] {
            let mut resumed = case.renderer(&device);
            resumed.resume(&checkpoint).expect("the same render");
            advance(&mut resumed, stop);
            advance(&mut whole, stop);
            checkpoint = save(&resumed);
            assert!(checkpoint == save(&whole), "{}, {stop} iterations", case.name);
            let [image, expected] = [&resumed, &whole].map(|renderer| renderer.resolve().expect("an image"));
            assert!(bits(&image) == bits(&expected) && energy(&image) > 0.0, "{}, {stop} iterations", case.name);
        }
    }
    support::assert_silent(&device);
}

/// Whatever the device was busy with before.
#[test]
fn a_renderer_can_go_back() {
    let device = support::device();
    let ppm = Options { integrator: Integrator::Ppm, photons_per_round: Some(500 * ROUND), ..Options::default() };
    let case = Case::new("ppm", ppm);
    let mut renderer = case.renderer(&device);
    advance(&mut renderer, 3);
    let early = save(&renderer);
    advance(&mut renderer, 8);
    let late = save(&renderer);
    renderer.resume(&early).expect("the same render");
    advance(&mut renderer, 8);
    assert!(save(&renderer) == late);
}

/// Also with more iterations than were asked for at first, and with further channels.
#[test]
fn a_stop_does_not_change_a_byte_of_the_file() {
    let bench = Bench::new();
    let output = ["--aov", "standard-error", "-o"];
    bench.rendered(&[&["--iterations", "9"], &output[..], &["whole.exr"]].concat());
    bench.rendered(&["--iterations", "2", "--checkpoint", "x.checkpoint", "-o", "x.exr"]);
    for iterations in ["5", "9"] {
        let go_on = ["--iterations", iterations, "--resume", "x.checkpoint", "--checkpoint", "x.checkpoint"];
        bench.rendered(&[&go_on[..], &output, &["x.exr"]].concat());
    }
    assert!(bench.bytes("x.exr") == bench.bytes("whole.exr"));

    // Nothing is left to do; and fewer iterations cannot be had.
    for iterations in ["9", "3"] {
        let arguments = ["--iterations", iterations, "--resume", "x.checkpoint"];
        bench.rendered(&[&arguments[..], &output, &["again.exr"]].concat());
        assert!(bench.bytes("again.exr") == bench.bytes("whole.exr"), "{iterations}");
    }
}

/// It always stops at the same iteration, and is not rendered further.
#[test]
fn a_target_error_is_reached_once() {
    let bench = Bench::new();
    let target = ["--target-error", "0.05", "--iterations", "1000", "--quiet"];
    bench.rendered(&[&target[..], &["-o", "whole.exr", "--stats", "whole.json"]].concat());
    let stats = bench.json("whole.json");
    let (iterations, error) = (stats["iterations"].as_u64().unwrap(), stats["relative_error"].as_f64().unwrap());
    assert!((9..1000).contains(&iterations) && error <= 0.05, "{iterations} iterations, an error of {error}");

    bench.rendered(&["--iterations", "8", "--checkpoint", "x.checkpoint", "-o", "x.exr"]);
    for _ in 0..2 {
        let go_on = ["--resume", "x.checkpoint", "--checkpoint", "x.checkpoint", "-o", "x.exr"];
        bench.rendered(&[&target[..], &go_on].concat());
        assert!(bench.bytes("x.exr") == bench.bytes("whole.exr"));
    }
}
