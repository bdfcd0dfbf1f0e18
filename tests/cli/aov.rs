//! AOVs: the layers of an EXR beside its colours.

use goblet::render::aov::AOVS;

use crate::support::command::{self, Bench};

/// The values of a channel of an EXR.
pub fn channel(bench: &Bench, file: &str, name: &str) -> Vec<f32> {
    let image = exr::prelude::read_all_flat_layers_from_file(bench.path(file)).unwrap();
    let mut channels = image.layer_data.iter().flat_map(|layer| &layer.channel_data.list);
    let channel = channels.find(|channel| channel.name == *name);
    channel.unwrap_or_else(|| panic!("{file} has no channel {name}")).sample_data.values_as_f32().collect()
}

/// The names of all channels of an EXR.
fn channels(bench: &Bench, file: &str) -> Vec<String> {
    let image = exr::prelude::read_all_flat_layers_from_file(bench.path(file)).unwrap();
    let channels = image.layer_data.iter().flat_map(|layer| &layer.channel_data.list);
    channels.map(|channel| channel.name.to_string()).collect()
}

fn every_aov() -> Vec<&'static str> {
    AOVS.iter().flat_map(|aov| ["--aov", aov.name]).collect()
}

#[test]
fn every_aov_is_a_layer_of_the_exr_and_survives_a_checkpoint() {
    let bench = Bench::new();
    let all = every_aov();
    let checkpoint = ["--radius-schedule", "global", "--shard", "0/1", "--checkpoint", "0.checkpoint"];
    bench.rendered(&[&["--iterations", "4", "-o", "x.exr"], &all[..], &checkpoint].concat());
    let run = bench.run(&[&["merge", "0.checkpoint", "-o", "m.exr"], &all[..]].concat());
    assert_eq!(run.code, 0, "{run:?}");
    assert!(bench.bytes("x.exr") == bench.bytes("m.exr"));
    for aov in &AOVS {
        let is_known = |name: &&str| channel(&bench, "x.exr", name).iter().any(|v| v.is_finite() && *v != 0.0);
        assert!(aov.channels.iter().any(is_known), "{aov:?}");
        for name in aov.channels {
            let values = channel(&bench, "x.exr", name);
            assert_eq!(values.len(), 16 * 12, "{name}");
            assert!(values.iter().all(|value| value.is_finite()), "{name}");
        }
    }
    let normals = ["X", "Y", "Z"].map(|axis| channel(&bench, "x.exr", &format!("N.{axis}")));
    for (pixel, depth) in channel(&bench, "x.exr", "Z").iter().enumerate() {
        let length = normals.iter().map(|plane| plane[pixel].powi(2)).sum::<f32>();
        assert!((length - if *depth > 0.0 { 1.0 } else { 0.0 }).abs() < 1e-5, "pixel {pixel}: {length} at {depth}");
    }
}

#[test]
fn old_names_and_small_letters_are_understood() {
    let bench = Bench::new();
    let names = ["--aov", "normal", "--aov", "DEPTH", "--aov", "photon-density", "--aov", "albedo", "--aov", "N"];
    bench.rendered(&[&["--iterations", "1", "-o", "x.exr"], &names[..]].concat());
    let mut expected = vec!["B", "G", "R", "Z", "density.Y", "N.X", "N.Y", "N.Z", "Albedo.R", "Albedo.G", "Albedo.B"];
    let mut found = channels(&bench, "x.exr");
    expected.sort_unstable();
    found.sort_unstable();
    assert_eq!(found, expected);
    bench.render(&["--aov", "beauty"]).assert_refused("a wrong name", 2, &["beauty", "RelativeVariance"]);
}

/// The layers of pbrt, as the film asks for them; `--aov` adds to them.
#[test]
fn a_gbuffer_film_writes_its_layers() {
    let bench = Bench::new();
    bench.write("scene.pbrt", command::scene("Film \"rgb\"", "Film \"gbuffer\""));
    let global = ["--radius-schedule", "global", "--iterations", "3"];
    bench.rendered(&[&global[..], &["--aov", "direct", "-o", "x.exr"]].concat());
    for aov in &AOVS {
        let is_there = |name: &&str| channels(&bench, "x.exr").iter().any(|channel| channel == name);
        assert_eq!(aov.channels.iter().all(is_there), aov.is_of_gbuffer || aov.name == "direct", "{aov:?}");
    }
    bench.rendered(&[&global[..], &["-o", "film.exr"]].concat());
    for index in ["0", "1"] {
        bench.rendered(&[&global[..], &["--shard", &format!("{index}/2"), "--checkpoint", index]].concat());
    }
    let run = bench.run(&["merge", "1", "0", "-o", "merged.exr"]);
    assert!(run.code == 0 && bench.bytes("merged.exr") == bench.bytes("film.exr"), "{run:?}");

    // Another coordinate system gives other positions, and is another render.
    let world = "Film \"gbuffer\" \"string coordinatesystem\" \"world\"";
    bench.write("scene.pbrt", command::scene("Film \"rgb\"", world));
    bench.rendered(&[&global[..], &["-o", "world.exr"]].concat());
    assert!(channel(&bench, "world.exr", "P.Z") != channel(&bench, "film.exr", "P.Z"));
    assert!(channel(&bench, "world.exr", "R") == channel(&bench, "film.exr", "R"));
    let run = bench.render(&[&global[..], &["--shard", "0/2", "--checkpoint", "0", "--resume", "0"]].concat());
    let words =
        "layers' coordinate system: the checkpoint was made with camera, and this render has world; expected the scene";
    run.assert_refused("another system", 2, &[words]);
    bench
        .write("scene.pbrt", command::scene("Film \"rgb\"", "Film \"gbuffer\" \"string coordinatesystem\" \"screen\""));
    bench.render(&[]).assert_refused("a wrong system", 2, &["scene.pbrt:1:16", "\"camera\" or \"world\""]);
}

#[test]
fn what_an_aov_does_not_know_has_one_value() {
    let bench = Bench::new();
    // An iteration of one half tells no error.
    bench.rendered(&["--iterations", "1", "-o", "x.exr", "--aov", "standard-error", "--checkpoint", "c"]);
    assert!(channel(&bench, "x.exr", "standardError.Y").iter().all(|value| *value == f32::INFINITY));
    // A checkpoint has the sums that were asked for.
    let run = bench.run(&["merge", "c", "-o", "y.exr", "--aov", "caustic"]);
    run.assert_refused("merge", 2, &["the layer caustic was not summed", "expected a render with --aov caustic"]);
    let run = bench.render(&["--iterations", "2", "-o", "y.exr", "--aov", "Z", "--resume", "c"]);
    let words = "layers: the checkpoint was made with none, and this render has Albedo, P";
    run.assert_refused("resume", 2, &[words]);
    assert!(!bench.path("y.exr").exists());
}
