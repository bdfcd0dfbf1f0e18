//! `goblet advise` against what then happens: settings are rendered, and the error measured
//! against the image of an independent renderer.

use std::sync::Arc;

use goblet::image::estimate::dark_square;
use goblet::image::film::{Image, luminance};
use goblet::scene::Scene;
use goblet::study::advise::{Choice, Length, expect};
use goblet::{DeviceOptions, Options, Renderer, open_device};
use goblet_host::Device;

use crate::support::command::{self, Bench};
use crate::support::{is_full, variants, work};

/// A prediction is right within this factor.
const FACTOR: f64 = 1.3;
/// Iterations of each render of a probe.
fn probe() -> u32 {
    work(8, 16)
}

const SCENES: [&str; 3] = ["cornell-caustic", "caustic-point", "revolution"];

fn file(scene: &str, extension: &str) -> String {
    format!("{}/tests/reference/{scene}.{extension}", env!("CARGO_MANIFEST_DIR"))
}

/// As the estimate is defined, with the reference in the place of what is not known.
fn relative_error(image: &Image, reference: &Image) -> f64 {
    let luminances = |image: &Image| -> Vec<f64> { image.pixels.iter().map(|it| luminance(*it).into()).collect() };
    let [x, r] = [image, reference].map(luminances);
    let floor = dark_square(r.iter().copied()).expect("light");
    let mut squares: Vec<f64> = x.iter().zip(&r).map(|(x, r)| (x - r).powi(2) / (r * r + floor)).collect();
    squares.sort_by(f64::total_cmp);
    squares.truncate(r.len() - r.len() / 1000);
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}

/// Renders settings of a scene, and compares what was expected of them with the truth. All lengths
/// are numbers of iterations: the clock has no part in it.
fn assert_is_as_expected(device: &Arc<Device>, name: &str, choice: Choice, iterations: u32) {
    let scene = Scene::load(file(name, "pbrt")).expect("a scene");
    // A pixel for four of the reference, which so has a quarter of its own noise.
    let base = Options { resolution: Some([64, 64]), ..Options::default() };
    let (options, expected) =
        expect(device, &scene, &base, choice, iterations, Length::Iterations(probe())).expect("a probe");
    let mut renderer = Renderer::new(Arc::clone(device), &scene, &options).expect("a renderer");
    for _ in 0..iterations {
        renderer.step().expect("an iteration");
    }
    let reference = variants::reference(file(name, "exr").as_ref(), 2);
    let truth = relative_error(&renderer.resolve().expect("an image"), &reference);
    let ratio = truth / expected.error;
    println!("| {name} | {choice:?} | {iterations} | {:.4} | {truth:.4} | {ratio:.2} |", expected.error);
    assert_eq!(expected.iterations, iterations);
    assert!(ratio < FACTOR && ratio > 1.0 / FACTOR, "{name}, {choice:?}: expected {expected:?}, is {truth}");
}

#[test]
fn errors_are_as_expected() {
    let device = Arc::new(open_device(&DeviceOptions::default()).expect("a device"));
    let choices = [
        (Choice::DEFAULT, 48),
        (Choice { eye_paths: 2, radius: 1.4, photons: 0.5 }, 96),
        (Choice { eye_paths: 8, radius: 0.7, photons: 2.0 }, 24),
    ];
    for (i, scene) in SCENES.iter().enumerate() {
        for (j, (choice, iterations)) in choices.into_iter().enumerate() {
            // In the quick form, each scene has another choice, and half the iterations.
            if is_full() {
                assert_is_as_expected(&device, scene, choice, iterations);
            } else if i == j {
                assert_is_as_expected(&device, scene, choice, iterations / 2);
            }
        }
    }
}

/// What is advised for an error or a time is a command that renders; for an error, with the
/// iterations that are expected.
#[test]
fn the_command_renders() {
    let bench = Bench::new();
    for goal in [["--error", "0.3"], ["--time", "0.5"]] {
        let run = bench.run(&[&["advise", "scene.pbrt", "--json", "--probe", "0.2"], &goal[..]].concat());
        assert_eq!(run.code, 0, "{run:?}");
        let advice: serde_json::Value = serde_json::from_str(&run.stdout).expect("JSON");
        let command = advice["command"].as_str().expect("a command");
        let options = ["--quiet", "-o", "image.exr", "--stats", "image.json"];
        let options: Vec<&str> = command.split_whitespace().skip(1).chain(options).collect();
        assert_eq!(options[..2], ["render", "scene.pbrt"]);
        let run = bench.run(&options);
        assert_eq!(run.code, 0, "{command}: {run:?}");
        assert!(goal[0] == "--time" || bench.json("image.json")["iterations"] == advice["expected"]["iterations"]);
    }
}

#[test]
fn advice_is_a_command_and_what_to_expect_of_it() {
    let bench = Bench::new();
    let run = bench.run(&["advise", "scene.pbrt", "--time", "2", "--probe", "0.2", "--resolution", "8x6", "--quiet"]);
    assert_eq!((run.code, run.stderr.as_str()), (0, ""), "{run:?}");
    for words in [
        "expect ",
        "relative error of noise and blur",
        "made of ",
        "default ",
        "auto       eye paths ",
        "goblet render scene.pbrt --resolution 8x6 ",
    ] {
        assert!(run.stdout.contains(words), "{words}: {}", run.stdout);
    }
    for (arguments, words) in [
        (&["advise", "scene.pbrt"][..], "--time"),
        (&["advise", "scene.pbrt", "--time", "1", "--error", "0.1"], "cannot be used with"),
        (&["advise", "scene.pbrt", "--error", "0"], "finite number above 0"),
        (&["advise", "nothing.pbrt", "--time", "1"], "nothing.pbrt"),
    ] {
        bench.run(arguments).assert_refused(&arguments.join(" "), 2, &[words]);
    }
}

/// Where all is black there is nothing to be wrong about.
#[test]
fn a_black_scene_is_no_reason_to_fail() {
    let bench = Bench::new();
    bench.write(
        "black.pbrt",
        command::scene("\"rgb I\" [ 5 5 5 ]", "\"rgb I\" [ 1e-20 0 0 ]").replace("Camera", "Rotate 180 0 1 0\nCamera"),
    );
    let run = bench.run(&["advise", "black.pbrt", "--time", "1", "--probe", "0.1", "--json"]);
    assert_eq!(run.code, 0, "{run:?}");
    let advice: serde_json::Value = serde_json::from_str(&run.stdout).expect("JSON");
    assert!(advice["expected"]["error"].as_f64().is_some(), "{advice}");
}
