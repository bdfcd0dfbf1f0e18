//! What cannot be resumed.

use crate::support::command::{self, Bench};

/// Options that all runs have: the scene's own numbers as they are.
const OPTIONS: [&str; 4] = ["--iterations", "2", "-o", "x.exr"];

/// [`command::SCENE`] after one round, in `x.checkpoint`.
fn bench() -> Bench {
    let bench = Bench::new();
    bench.rendered(&["--quiet", "--iterations", "1", "--checkpoint", "x.checkpoint", "-o", "x.exr"]);
    std::fs::remove_file(bench.path("x.exr")).unwrap();
    bench
}

fn assert_refused(bench: &Bench, case: &str, arguments: &[&str], message: &str) {
    let run = bench.render(&[&OPTIONS[..], &["--resume", "x.checkpoint"], arguments].concat());
    run.assert_refused(case, 2, &[&format!("goblet: x.checkpoint: {message}")]);
    assert!(!bench.path("x.exr").exists(), "{case}");
}

#[test]
fn another_option_is_named() {
    let bench = bench();
    let cases: &[(&[&str], &str)] = &[
        (&["--alpha", "0.5"], "alpha: the checkpoint was made with 0.6666666666666666, and this render has 0.5"),
        (&["--seed", "7"], "seed: the checkpoint was made with 0, and this render has 7; expected --seed 0\n"),
        (&["--photons", "501"], "photons per iteration: the checkpoint was made with 500, and this render has 501"),
        (
            &["--radius", "0.25"],
            "radius: the checkpoint was made with 0.5, and this render has 0.25; expected --radius 0.5",
        ),
        (&["--max-depth", "5"], "maximum depth: the checkpoint was made with 6, and this render has 5"),
        (
            &["--integrator", "ppm"],
            "integrator: the checkpoint was made with sppm, and this render has ppm; expected --integrator sppm\n",
        ),
        (
            &["--radius-schedule", "global"],
            "radius schedule: the checkpoint was made with adaptive, and this render has global",
        ),
        (&["--direct", "photons"], "direct light: the checkpoint was made with nee, and this render has photons"),
        (&["--sampler", "pcg"], "sampler: the checkpoint was made with sobol, and this render has pcg"),
        (&["--revolution-solver", "newton"], "revolution solver: the checkpoint was made with certified"),
        (&["--aov", "N"], "layers: the checkpoint was made with none, and this render has N; expected no --aov\n"),
        (
            &["--alpha", "0.5", "--seed", "7"],
            "alpha: the checkpoint was made with 0.6666666666666666, and this render has 0.5; seed: the checkpoint was \
             made with 0, and this render has 7; expected --alpha 0.6666666666666666 --seed 0\n",
        ),
    ];
    for (arguments, message) in cases {
        assert_refused(&bench, &format!("{arguments:?}"), arguments, message);
    }
}

/// The camera and the usual number of photons follow from the size of the image.
#[test]
fn another_size_is_named_and_nothing_that_follows_from_it() {
    let bench = bench();
    let message = "the checkpoint is 16x12; this render is 12x16; expected --resolution 16x12\n";
    assert_refused(&bench, "the scene's photons", &["--resolution", "12x16"], message);
    bench.write("scene.pbrt", command::scene(" \"integer photonsperiteration\" 500", ""));
    bench.rendered(&["--quiet", "--iterations", "1", "--checkpoint", "x.checkpoint", "-o", "y.exr"]);
    assert_refused(&bench, "one photon per pixel", &["--resolution", "32x24"], &message.replace("12x16", "32x24"));
    let both = "photons per iteration: the checkpoint was made with 192, and this render has 7; the checkpoint is 16x12; \
                this render is 32x24; expected --photons 192 --resolution 16x12\n";
    assert_refused(&bench, "photons as well", &["--resolution", "32x24", "--photons", "7"], both);
    let rendered = [&OPTIONS[..], &["--resume", "x.checkpoint", "--resolution", "16x12", "--photons", "192"]].concat();
    bench.rendered(&rendered);
}

/// Nobody waits for kernels to be told that a checkpoint does not fit.
#[test]
fn a_checkpoint_is_compared_before_kernels_are_compiled() {
    let bench = bench();
    let arguments = [&OPTIONS[..], &["--resume", "x.checkpoint", "--seed", "7"]].concat();
    let refused = bench.render(&arguments);
    assert!(refused.code == 2 && !refused.stderr.contains("compiled"), "{refused:?}");
    // A trial chooses numbers after that, which the checkpoint has.
    let auto = ["--quiet", "--photons", "auto", "--eye-paths", "auto", "--iterations"];
    bench.rendered(&[&auto[..], &["1", "--checkpoint", "x.checkpoint", "-o", "y.exr"]].concat());
    bench.rendered(&[&auto[..], &["2", "--resume", "x.checkpoint", "-o", "y.exr"]].concat());
    let refused =
        bench.render(&[&auto[1..], &["2", "--resume", "x.checkpoint", "-o", "y.exr", "--seed", "7"]].concat());
    assert!(refused.code == 2 && !refused.stderr.contains("compiled"), "{refused:?}");
}

#[test]
fn another_exposure_or_white_balance_is_named() {
    let bench = bench();
    let film = |parameter: &str| command::scene("Film \"rgb\"", &format!("Film \"rgb\" {parameter}"));
    bench.write("scene.pbrt", film("\"float iso\" 200"));
    assert_refused(
        &bench,
        "iso",
        &[],
        "exposure: the checkpoint was made with 1, and this render has 2; expected the scene file",
    );
    bench.write("scene.pbrt", film("\"float whitebalance\" 5000"));
    let message = "white balance: the checkpoint was made with none, and this render has 5000 K";
    assert_refused(&bench, "a balance", &[], message);

    bench.rendered(&["--quiet", "--iterations", "1", "--checkpoint", "x.checkpoint", "-o", "y.exr"]);
    bench.write("scene.pbrt", film("\"float whitebalance\" 4000.5"));
    let message = "white balance: the checkpoint was made with 5000 K, and this render has 4000.5 K";
    assert_refused(&bench, "another balance", &[], message);
    bench.write("scene.pbrt", film("\"float whitebalance\" 0"));
    let message = "white balance: the checkpoint was made with 5000 K, and this render has none";
    assert_refused(&bench, "no balance", &[], message);
}

#[test]
fn another_shard_is_named() {
    let bench = Bench::new();
    let global = ["--radius-schedule", "global", "--checkpoint", "x.checkpoint", "--quiet"];
    bench.rendered(&[&OPTIONS[..2], &global, &["--shard", "1/2"]].concat());
    for shard in ["0/2", "1/3"] {
        let message =
            format!("the checkpoint is of shard 1/2, and this render is shard {shard}; expected --shard 1/2\n");
        assert_refused(&bench, shard, &[&global[..], &["--shard", shard]].concat(), &message);
    }
    let message = "the checkpoint is of shard 1/2, and this render is whole; expected --shard 1/2\n";
    assert_refused(&bench, "whole", &global, message);
}

#[test]
fn another_scene_is_named_by_its_part() {
    let bench = bench();
    let cases = [
        ("Material \"diffuse\"", "Material \"diffuse\" \"rgb reflectance\" [ .4 .5 .6 ]", "the materials"),
        ("\"rgb I\" [ 5 5 5 ]", "\"rgb I\" [ 5 5 6 ]", "the lights"),
        ("\"sphere\" \"float radius\" 0.5", "\"sphere\" \"float radius\" 0.4", "the shapes"),
        // So that all that is in units of the scene's size is other too.
        ("\"point3 P\" [ -2 -1 -2", "\"point3 P\" [ -9 -1 -2", "the shapes"),
        ("LookAt 0 0 -3", "LookAt 0 0.1 -3", "the camera, its crop window or its pixel filter"),
        ("Camera", "PixelFilter \"box\" Camera", "the camera, its crop window or its pixel filter"),
    ];
    for (from, to, part) in cases {
        bench.write("scene.pbrt", command::scene(from, to));
        let message = format!("{part} of the scene differ from what the checkpoint was made with");
        assert_refused(&bench, &format!("`{from}` as `{to}`"), &[], &message);
    }
    // Text that says the same is the same scene.
    bench.write("scene.pbrt", command::scene("WorldBegin", "# A comment.\nWorldBegin"));
    bench.rendered(&[&OPTIONS[..], &["--resume", "x.checkpoint"]].concat());
}

#[test]
fn other_media_are_named() {
    let bench = bench();
    // Around the camera alone.
    let within = |sigma: &str| {
        let medium = format!(
            "MakeNamedMedium \"m\" \"string type\" \"homogeneous\" \"rgb sigma_s\" [ 0 0 0 ] \"rgb sigma_a\" [ {sigma} ]\n\
             MediumInterface \"\" \"m\"\nLookAt"
        );
        command::scene("LookAt", &medium).replace("WorldBegin", "WorldBegin MediumInterface \"\" \"\"")
    };
    let message = "the media of the scene differ from what the checkpoint was made with";
    bench.write("scene.pbrt", within("1 2 3"));
    assert_refused(&bench, "a medium", &[], message);
    bench.rendered(&["--quiet", "--iterations", "1", "--checkpoint", "x.checkpoint", "-o", "y.exr"]);
    bench.write("scene.pbrt", within("1 2 3.5"));
    assert_refused(&bench, "another medium", &[], message);
    bench.write("scene.pbrt", command::SCENE);
    assert_refused(&bench, "no medium", &[], message);
    bench.write("scene.pbrt", within("1 2 3"));
    bench.rendered(&[&OPTIONS[..], &["--resume", "x.checkpoint"]].concat());
}

/// How the work is cut does not change the image, and so may change.
#[test]
fn what_does_not_change_the_image_may_differ() {
    let bench = bench();
    bench.rendered(&["--iterations", "2", "-o", "whole.exr"]);
    let arguments = ["--workgroup-size", "32", "--batch-size", "77", "--cell-scale", "2", "--resume", "x.checkpoint"];
    bench.rendered(&[&OPTIONS[..], &arguments].concat());
    assert!(bench.bytes("x.exr") == bench.bytes("whole.exr"));
}

#[test]
fn a_place_for_checkpoints_is_asked_for_before_the_render() {
    let bench = Bench::new();
    let run = bench.render(&["--checkpoint", "missing/x", "-o", "x.exr"]);
    run.assert_refused("missing folder", 1, &["goblet: missing/x: cannot write the checkpoint", "No such file"]);
    std::fs::create_dir(bench.path("folder")).unwrap();
    let run = bench.render(&["--checkpoint", "folder", "-o", "x.exr"]);
    run.assert_refused("folder", 1, &["goblet: folder: cannot write the checkpoint", "not a file"]);
    assert!(!bench.path("x.exr").exists());
    bench.render(&["--shard", "0/2"]).assert_refused("shard", 2, &["--checkpoint <FILE>"]);
    bench.render(&["--checkpoint-every", "1"]).assert_refused("every", 2, &["--checkpoint <FILE>"]);
}
