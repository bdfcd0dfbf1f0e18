//! AOVs: the layers of an EXR beside its colours.

use goblet::render::aov::{AOVS, Aov};

use crate::support::command::Bench;

/// The values of a channel of an EXR.
pub fn channel(bench: &Bench, file: &str, name: &str) -> Vec<f32> {
    let image = exr::prelude::read_all_flat_layers_from_file(bench.path(file)).unwrap();
    let mut channels = image.layer_data.iter().flat_map(|layer| &layer.channel_data.list);
    let channel = channels.find(|channel| channel.name == *name);
    channel.unwrap_or_else(|| panic!("{file} has no channel {name}")).sample_data.values_as_f32().collect()
}

#[test]
fn every_aov_is_a_layer_of_the_exr_and_those_of_the_sums_survive_a_checkpoint() {
    let bench = Bench::new();
    let names = |is_offered: fn(&Aov) -> bool| {
        AOVS.iter().filter(move |aov| is_offered(aov)).flat_map(|aov| ["--aov", aov.name])
    };
    let all: Vec<&str> = names(|_| true).collect();
    let checkpoint = ["--radius-schedule", "global", "--shard", "0/1", "--checkpoint", "0.checkpoint"];
    bench.rendered(&[&["--iterations", "2", "-o", "x.exr"], &all[..], &checkpoint].concat());
    let merged: Vec<&str> = names(Aov::is_of_estimate).collect();
    let run = bench.run(&[&["merge", "0.checkpoint", "-o", "m.exr"], &merged[..]].concat());
    assert_eq!(run.code, 0, "{run:?}");
    for aov in &AOVS {
        let is_known = |name: &&str| channel(&bench, "x.exr", name).iter().any(|v| v.is_finite() && *v != 0.0);
        assert!(aov.channels.iter().any(is_known), "{aov:?}");
        for name in aov.channels {
            let values = channel(&bench, "x.exr", name);
            assert_eq!(values.len(), 16 * 12, "{name}");
            if aov.is_of_estimate() {
                assert_eq!(channel(&bench, "m.exr", name), values, "{name}");
            }
        }
        if !aov.is_of_estimate() {
            let run = bench.run(&["merge", "0.checkpoint", "-o", "n.exr", "--aov", aov.name]);
            run.assert_refused(aov.name, 2, &["standard-error"]);
        }
    }
    let normals = ["X", "Y", "Z"].map(|axis| channel(&bench, "x.exr", &format!("normal.{axis}")));
    let depths = channel(&bench, "x.exr", "depth.Z");
    for (pixel, depth) in depths.iter().enumerate() {
        let length = normals.iter().map(|plane| plane[pixel].powi(2)).sum::<f32>();
        assert!((length - if *depth > 0.0 { 1.0 } else { 0.0 }).abs() < 1e-5, "pixel {pixel}: {length} at {depth}");
    }
}

#[test]
fn what_an_aov_does_not_know_has_one_value() {
    let bench = Bench::new();
    // An iteration of one half tells no error.
    bench.rendered(&["--iterations", "1", "-o", "x.exr", "--aov", "standard-error", "--checkpoint", "c"]);
    assert!(channel(&bench, "x.exr", "standardError.Y").iter().all(|value| *value == f32::INFINITY));
    // Without an iteration of its own, a run knows of no visible point.
    bench.rendered(&["--iterations", "1", "-o", "y.exr", "--aov", "depth", "--aov", "radius", "--resume", "c"]);
    for name in ["depth.Z", "radius.Y"] {
        assert!(channel(&bench, "y.exr", name).iter().all(|value| *value == 0.0), "{name}");
    }
}
