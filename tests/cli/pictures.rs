//! How bright PNGs are, and what EXRs say of their render.

use std::collections::BTreeMap;

use exr::meta::MetaData;
use exr::meta::attribute::AttributeValue;

use crate::support::command::{self, Bench};

/// The attributes of an EXR that are not of the format, by name.
fn attributes(bench: &Bench, file: &str) -> BTreeMap<String, AttributeValue> {
    let headers = MetaData::read_from_file(bench.path(file), true).unwrap().headers;
    let own = &headers[0].own_attributes;
    let mut all: BTreeMap<_, _> = own.other.iter().map(|(name, value)| (name.to_string(), value.clone())).collect();
    let matrices = [("worldToCamera", own.world_to_camera), ("worldToNDC", own.world_to_normalized_device)];
    all.extend(matrices.into_iter().filter_map(|(name, it)| Some((name.to_owned(), AttributeValue::Matrix4x4(it?)))));
    all
}

/// The mean of all bytes of a PNG, as numbers from 0 to 1 after the sRGB curve is undone.
fn brightness(bench: &Bench, file: &str) -> f64 {
    let pixels = bench.image(file).pixels;
    pixels.iter().flatten().map(|channel| f64::from(*channel)).sum::<f64>() / (3 * pixels.len()) as f64
}

#[test]
fn a_stop_doubles_a_png_and_leaves_the_exr() {
    let bench = Bench::new();
    bench.write("scene.pbrt", command::scene(command::LIGHT, &command::LIGHT.replace("5 5 5", "1 1 1")));
    let options = ["--iterations", "2", "--checkpoint", "x.checkpoint", "-o", "x.exr", "-o", "x.png"];
    bench.rendered(&options);
    let checkpoint = bench.bytes("x.checkpoint");
    bench.rendered(&[&options[..2], &["-o", "y.exr", "-o", "y.png", "--exposure", "1"]].concat());
    assert!(bench.bytes("x.exr") == bench.bytes("y.exr"));
    let ratio = brightness(&bench, "y.png") / brightness(&bench, "x.png");
    assert!((1.9..2.1).contains(&ratio), "{ratio}");
    // A merge of the checkpoint shows the same, and a checkpoint has no exposure.
    bench.write("z.checkpoint", checkpoint);
    let run = bench.run(&["merge", "z.checkpoint", "-o", "z.png", "--exposure", "1"]);
    assert!(run.code == 0 && bench.bytes("z.png") == bench.bytes("y.png"), "{run:?}");
}

#[test]
fn auto_shows_the_same_however_bright_the_light_is() {
    let bench = Bench::new();
    let render = |light: &str, png: &str| {
        bench.write("scene.pbrt", command::scene(command::LIGHT, &command::LIGHT.replace("5 5 5", light)));
        bench.rendered(&["--iterations", "2", "-o", png, "--exposure", "auto"])
    };
    for (light, png, sign) in [("0.001 0.001 0.001", "dim.png", '+'), ("900 900 900", "bright.png", '-')] {
        let run = render(light, png);
        assert!(run.stderr.contains(&format!("wrote {png}, exposure {sign}")), "{run:?}");
    }
    let [dim, bright] = ["dim.png", "bright.png"].map(|png| brightness(&bench, png));
    assert!((dim / bright - 1.0).abs() < 0.02, "{dim} {bright}");
    assert!((0.1..0.5).contains(&dim), "{dim}");
}

#[test]
fn a_picture_that_is_mostly_white_is_reported() {
    let bench = Bench::new();
    let dazzling = command::LIGHT.replace("5 5 5", "1e6 1e6 1e6");
    bench.write("scene.pbrt", command::scene(command::LIGHT, &dazzling));
    let white = "of the pixels are white";
    let run = bench.rendered(&["--iterations", "1", "-o", "x.png"]);
    assert!(run.stderr.contains("x.png: ") && run.stderr.contains(white) && run.stderr.contains("--exposure auto"));
    for quiet in [&["-o", "x.png", "--exposure", "auto"][..], &["-o", "x.exr"], &["-o", "x.png", "--quiet"]] {
        let run = bench.rendered(&[&["--iterations", "1"], quiet].concat());
        assert!(!run.stderr.contains(white), "{quiet:?}: {run:?}");
    }
}

#[test]
fn an_exposure_is_a_number_of_stops_or_auto() {
    let bench = Bench::new();
    for wrong in ["bright", "1e9", "nan", ""] {
        let run = bench.render(&["--exposure", wrong]);
        run.assert_refused(wrong, 2, &["--exposure", "expected a number of stops from -100 to 100, or auto"]);
    }
    bench.rendered(&["--iterations", "1", "-o", "x.png", "--exposure", "-2.5"]);
}

#[test]
fn an_exr_says_how_it_was_made() {
    let bench = Bench::new();
    let options = ["--iterations", "3", "--seed", "7", "--radius-schedule", "global", "--eye-paths", "2"];
    bench.rendered(&[&options[..], &["-o", "x.exr"]].concat());
    let found = attributes(&bench, "x.exr");
    let int = |name: &str| match found[name] {
        AttributeValue::I32(number) => number,
        ref other => panic!("{name} is {other:?}"),
    };
    assert_eq!([int("goblet.iterations"), int("goblet.photons"), int("samplesPerPixel")], [3, 1500, 6]);
    assert_eq!([int("goblet.option.seed"), int("goblet.option.photons"), int("goblet.option.max-depth")], [7, 500, 6]);
    assert_eq!(found["goblet.option.radius-schedule"], AttributeValue::Text("global".into()));
    assert_eq!(found["goblet.scene"], AttributeValue::Text("scene.pbrt".into()));
    assert!(matches!(found["goblet.radius"], AttributeValue::F64(radius) if (radius - 0.5).abs() < 1e-6));
    assert!(matches!(found["goblet.relativeError"], AttributeValue::F64(error) if error > 0.0));
    // LookAt from (0, 0, -3) along z: the camera's depth is z + 3.
    let camera = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 3.0, 0.0, 0.0, 0.0, 1.0];
    assert_eq!(found["worldToCamera"], AttributeValue::Matrix4x4(camera));
    assert!(matches!(found["worldToNDC"], AttributeValue::Matrix4x4(_)));
    assert!(!found.contains_key("renderTimeSeconds"));
    // Shards, merged, say the same.
    for index in ["0/2", "1/2"] {
        bench.rendered(&[&options[..], &["--shard", index, "--checkpoint", &index[..1]]].concat());
    }
    let run = bench.run(&["merge", "1", "0", "-o", "merged.exr"]);
    assert!(run.code == 0 && bench.bytes("merged.exr") == bench.bytes("x.exr"), "{run:?}");
}

#[test]
fn times_are_recorded_where_they_are_asked_for() {
    let bench = Bench::new();
    bench.rendered(&["--iterations", "1", "-o", "x.exr", "--record-times"]);
    let found = attributes(&bench, "x.exr");
    let seconds = |name: &str| match found[name] {
        AttributeValue::F32(seconds) => seconds,
        ref other => panic!("{name} is {other:?}"),
    };
    let [render, total] = ["renderTimeSeconds", "goblet.totalSeconds"].map(seconds);
    assert!(0.0 < render && render < total, "{render} {total}");
}
