//! `goblet advise` against what then happens: its command is run, and the error measured
//! against the image of an independent renderer.

#[path = "support/command.rs"]
mod command;
#[path = "support/variants.rs"]
mod variants;

use command::Bench;
use goblet::estimate::dark_square;
use goblet::film::{Image, luminance};

/// A prediction is right within this factor.
const FACTOR: f64 = 1.5;
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

/// Advice for a scene, and what becomes of the command it gives: expected and true error.
fn follow(scene: &str, arguments: &[&str]) -> [f64; 2] {
    let bench = Bench::new();
    let scene_file = file(scene, "pbrt");
    // A pixel for four of the reference, which so has a quarter of its own noise.
    let fixed = ["advise", &scene_file, "--json", "--probe", "2", "--resolution", "64x64"];
    let run = bench.run(&[&fixed, arguments].concat());
    assert_eq!(run.code, 0, "{run:?}");
    let advice: serde_json::Value = serde_json::from_str(&run.stdout).expect("JSON");
    let command = advice["command"].as_str().expect("a command");
    let options: Vec<&str> = command.split_whitespace().skip(1).chain(["--quiet", "-o", "image.exr"]).collect();
    assert_eq!(options[..2], ["render", &scene_file]);
    let run = bench.run(&options);
    assert_eq!(run.code, 0, "{command}: {run:?}");
    let reference = variants::reference(file(scene, "exr").as_ref(), 2);
    let truth = relative_error(&bench.image("image.exr"), &reference);
    let expected = advice["expected"]["error"].as_f64().expect("an error");
    let options = command.split_once(".pbrt").map_or("", |(_, options)| options);
    println!("| {scene} | {options} | {expected:.4} | {truth:.4} | {:.2} |", truth / expected);
    [expected, truth]
}

fn assert_near([expected, truth]: [f64; 2], what: &str) {
    let ratio = truth / expected;
    assert!(ratio < FACTOR && ratio > 1.0 / FACTOR, "{what}: expected {expected}, is {truth}");
}

#[test]
fn errors_and_times_are_as_expected() {
    for scene in SCENES {
        for time in ["1.5", "3", "6"] {
            assert_near(follow(scene, &["--time", time]), &format!("{scene} for {time} s"));
        }
    }
    // However long that takes here; not at the same time, which it would change.
    assert_near(follow("caustic-point", &["--error", "0.06"]), "caustic-point to 0.06");
}

#[test]
fn advice_is_a_command_and_what_to_expect_of_it() {
    let bench = Bench::new();
    let run = bench.run(&["advise", "scene.pbrt", "--time", "2", "--probe", "0.2", "--resolution", "8x6"]);
    assert_eq!((run.code, run.stderr.as_str()), (0, ""), "{run:?}");
    for words in [
        "expect ",
        "relative error of noise and blur",
        "made of ",
        "default ",
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
