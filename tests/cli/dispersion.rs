//! Dispersion as an option, and in files.

use crate::support::command::{Bench, scene};

const GLASS: &str = "Material \"dielectric\"";

/// A bench whose ball splits light.
fn bench() -> Bench {
    let bench = Bench::new();
    bench.write("scene.pbrt", scene(GLASS, &format!("{GLASS} \"spectrum eta\" \"glass-F11\"")));
    bench
}

#[test]
fn no_dispersion_is_short_for_off() {
    let bench = bench();
    let render = |words: &[&str], file: &str| {
        bench.rendered(&[&["--iterations", "2", "--quiet", "-o", file], words].concat());
        bench.bytes(file)
    };
    let default = render(&[], "default.exr");
    assert!(render(&["--dispersion", "on"], "on.exr") == default);
    let off = render(&["--dispersion", "off"], "off.exr");
    assert!(off != default && render(&["--no-dispersion"], "no.exr") == off);

    let both = bench.render(&["--no-dispersion", "--dispersion", "on", "-o", "x.exr"]);
    both.assert_refused("both", 2, &["'--no-dispersion' cannot be used with '--dispersion", "Usage"]);
    let other = bench.render(&["--dispersion", "prism", "-o", "x.exr"]);
    other.assert_refused("another word", 2, &["prism", "on, off"]);
    assert!(!bench.path("x.exr").exists());
}

/// Colours outside of sRGB have negative channels, in all that is read back. The lamp is in the ball, so that all light has
/// crossed the glass.
#[test]
fn negative_channels_go_through_checkpoints_and_merges() {
    let bench = bench();
    bench.write("scene.pbrt", bench.text("scene.pbrt").replace("[ 0 1.5 -1 ]", "[ 0 .4 0 ]"));
    let few = ["--radius-schedule", "global", "--radius", "0.05", "--photons", "20000", "--iterations", "3"];
    let global = ["--radius-schedule", "global", "--radius", "0.05", "--photons", "20000", "--iterations", "6"];
    bench.rendered(&[&global[..], &["-o", "whole.exr"]].concat());
    let negative = bench.image("whole.exr").pixels.iter().flatten().filter(|value| **value < 0.0).count();
    assert!(negative > 0, "no channel is below 0");

    for index in ["0", "1"] {
        bench.rendered(&[&global[..], &["--shard", &format!("{index}/2"), "--checkpoint", index]].concat());
    }
    let merged = bench.run(&["merge", "1", "0", "-o", "merged.exr"]);
    assert_eq!(merged.code, 0, "{merged:?}");
    assert!(bench.bytes("merged.exr") == bench.bytes("whole.exr"));

    bench.rendered(&[&few[..], &["--checkpoint", "x", "-o", "x.exr"]].concat());
    bench.rendered(&[&global[..], &["--resume", "x", "-o", "x.exr"]].concat());
    assert!(bench.bytes("x.exr") == bench.bytes("whole.exr"));

    // A checkpoint is of a render with dispersion, or of one without.
    let other = bench.render(&[&global[..], &["--resume", "x", "--no-dispersion", "-o", "y.exr"]].concat());
    other.assert_refused("another render", 2, &["dispersion"]);
}
