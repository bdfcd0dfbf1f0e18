//! Shards and their sums.

use goblet::render::aov::AOVS;
use goblet::render::checkpoint::Checkpoint;
use goblet::{Guidance, Integrator, Options, RadiusSchedule, Shard};

use super::{Case, advance, bits, energy, save, through_file};
use crate::support;
use crate::support::command::{Bench, Run};

/// Numbers of shards, and of iterations that none of them divides; the last leaves some
/// shards without any.
const CUTS: [(u32, u32); 3] = [(2, 11), (3, 11), (7, 5)];

fn cases() -> [Case; 3] {
    let global = Options { radius_schedule: RadiusSchedule::Global, ..Options::default() };
    let ppm = Options { integrator: Integrator::Ppm, photons_per_round: Some(2 * 500), ..Options::default() };
    let guided = Options { guidance: Guidance::On, ..global.clone() };
    [
        Case::new("sppm, global", global).with_automatic_radius(),
        Case::new("ppm, adaptive, dispersion", ppm).with_dispersion(),
        Case::new("sppm, global, guided", guided).with_automatic_radius(),
    ]
}

fn shards(case: &Case, count: u32, iterations: u32) -> Vec<Checkpoint> {
    let device = support::device();
    let render = |index| {
        let options = Options { shard: Shard { index, count }, ..case.options.clone() };
        let mut renderer = Case { options, scene: case.scene.clone(), ..*case }.renderer(&device);
        let share = renderer.sequence().share(iterations);
        advance(&mut renderer, share);
        save(&renderer)
    };
    (0..count).map(render).collect()
}

fn merge(checkpoints: &[&Checkpoint]) -> Checkpoint {
    let mut sum = checkpoints[0].clone();
    for checkpoint in &checkpoints[1..] {
        sum.merge(checkpoint).expect("the same render");
    }
    through_file(&sum)
}

/// Of all orders, these: as they are, backwards, and from the middle on.
fn orders(shards: &[Checkpoint]) -> [Vec<&Checkpoint>; 3] {
    let forwards: Vec<_> = shards.iter().collect();
    let mut backwards = forwards.clone();
    backwards.reverse();
    let mut turned = forwards.clone();
    turned.rotate_left(shards.len() / 2);
    [forwards, backwards, turned]
}

#[test]
fn shards_add_up_to_one_render() {
    let device = support::device();
    for case in cases() {
        for (count, iterations) in CUTS {
            let what = format!("{}, {count} shards", case.name);
            let mut whole = case.renderer(&device);
            advance(&mut whole, iterations);
            let expected = whole.estimate().expect("an estimate");
            assert!(energy(&expected.image()) > 0.0);

            let shards = shards(&case, count, iterations);
            for order in orders(&shards) {
                let sum = merge(&order);
                assert!(sum.estimate == expected, "{what}");
                assert_eq!((sum.tally, sum.missing()), (*whole.tally(), vec![]), "{what}");
                assert!(bits(&sum.estimate.image()) == bits(&expected.image()), "{what}");
                assert_eq!(sum.estimate.standard_error(), expected.standard_error(), "{what}");
            }
            let (some, others) = shards.split_at(count as usize / 2);
            let parts = [others, some].map(|part| merge(&part.iter().collect::<Vec<_>>()));
            assert!(merge(&parts.each_ref()).estimate == expected, "{what}, in two stages");
        }
    }
    support::assert_silent(&device);
}

const GLOBAL: [&str; 4] = ["--radius-schedule", "global", "--iterations", "7"];

/// A folder with the checkpoints 0, 1 and 2 of three shards.
fn three_shards() -> Bench {
    let bench = Bench::new();
    for index in 0..3 {
        let (shard, file) = (format!("{index}/3"), index.to_string());
        let run = bench.rendered(&[&GLOBAL[..], &["--shard", &shard, "--checkpoint", &file]].concat());
        // An image of a shard is not written unless one asks for it.
        let lines: Vec<&str> = run.stderr.lines().collect();
        let [compiled, summary, written] = lines[..] else { panic!("{run:?}") };
        assert!(run.stdout.is_empty() && compiled.starts_with("compiled "), "{run:?}");
        assert!(summary.contains(" iterations in ") && written == format!("wrote {file}"), "{run:?}");
    }
    assert!(!bench.path("default.exr").exists());
    bench
}

#[test]
fn merged_files_are_those_of_one_run() {
    let bench = three_shards();
    let output = ["--aov", "standard-error", "-o"];
    bench.rendered(&[&GLOBAL[..], &output, &["whole.exr"]].concat());
    let merge = |arguments: &[&str]| {
        let run = bench.run(&[&["merge"], arguments].concat());
        assert_eq!((run.code, run.stdout.as_str()), (0, ""), "{run:?}");
        run.stderr
    };
    let image = [&output[..], &["x.exr"]].concat();
    assert_eq!(merge(&[&["2", "0", "1"], &image[..]].concat()), "wrote x.exr\n");
    assert!(bench.bytes("x.exr") == bench.bytes("whole.exr"));

    let missing = merge(&["2", "0", "--checkpoint", "20"]);
    assert_eq!(
        missing,
        "warning: missing: shard 1 of 3, counted from 0 (--shard 1/3); without what is missing, the image has more noise\n\
         wrote 20\n"
    );
    assert_eq!(merge(&["2", "0", "--checkpoint", "20", "--quiet"]), "");
    bench.write("x.exr", "");
    merge(&[&["1", "20"], &image[..]].concat());
    assert!(bench.bytes("x.exr") == bench.bytes("whole.exr"));

    // Iterations are added by resuming each shard.
    for index in ["0", "1", "2"] {
        let (shard, more) = (format!("{index}/3"), [&GLOBAL[..3], &["10"]].concat());
        bench.rendered(&[&more[..], &["--shard", &shard, "--resume", index, "--checkpoint", index]].concat());
    }
    merge(&[&["0", "1", "2"], &image[..]].concat());
    bench.rendered(&[&GLOBAL[..3], &["10"], &output, &["whole.exr"]].concat());
    assert!(bench.bytes("x.exr") == bench.bytes("whole.exr"));
}

/// Resumed and merged, in images and in the error that is written with them.
#[test]
fn a_white_balance_is_that_of_one_run() {
    let bench = Bench::new();
    let output = ["--aov", "standard-error", "-o"];
    let render = |arguments: &[&str]| bench.rendered(&[&GLOBAL[..3], arguments].concat());
    render(&[&["7"], &output[..], &["plain.exr"]].concat());
    let (film, plain) = ("Film \"rgb\"", bench.text("scene.pbrt"));
    bench.write("scene.pbrt", plain.replace(film, &format!("{film} \"float whitebalance\" 4321.1")));
    render(&[&["7"], &output[..], &["whole.exr"]].concat());
    assert!(bench.bytes("whole.exr") != bench.bytes("plain.exr"));

    render(&["3", "--checkpoint", "part", "-o", "x.exr"]);
    render(&[&["7", "--resume", "part"], &output[..], &["x.exr"]].concat());
    assert!(bench.bytes("x.exr") == bench.bytes("whole.exr"), "resumed");

    for index in ["0", "1"] {
        render(&["7", "--shard", &format!("{index}/2"), "--checkpoint", index]);
    }
    let merged = bench.run(&[&["merge", "0", "1"], &output[..], &["x.exr"]].concat());
    assert!(merged.code == 0 && bench.bytes("x.exr") == bench.bytes("whole.exr"), "{merged:?}");

    bench.write("scene.pbrt", plain);
    render(&["7", "--shard", "1/2", "--checkpoint", "1"]);
    let words =
        "1: white balance: it was made with none, and the files before it with 4321.1 K; expected shards of one";
    bench.run(&["merge", "0", "1", "-o", "y.exr"]).assert_refused("plain", 2, &[words]);
}

/// All layers, in files that were resumed and that were merged in any order.
#[test]
fn layers_are_those_of_one_run() {
    let bench = Bench::new();
    let aovs: Vec<&str> = AOVS.iter().flat_map(|aov| ["--aov", aov.name]).collect();
    let render = |arguments: &[&str]| bench.rendered(&[&GLOBAL[..3], arguments, &aovs].concat());
    render(&["7", "-o", "whole.exr"]);
    render(&["3", "--checkpoint", "part", "-o", "x.exr"]);
    render(&["7", "--resume", "part", "-o", "x.exr"]);
    assert!(bench.bytes("x.exr") == bench.bytes("whole.exr"), "resumed");

    for index in ["0", "1", "2"] {
        render(&["7", "--shard", &format!("{index}/3"), "--checkpoint", index]);
    }
    for order in [["0", "1", "2"], ["2", "0", "1"], ["1", "2", "0"]] {
        let [first, second, third] = order;
        let pair = bench.run(&["merge", first, second, "--checkpoint", "pair"]);
        let all = bench.run(&[&["merge", "pair", third, "-o", "x.exr"], &aovs[..]].concat());
        assert!(pair.code == 0 && all.code == 0, "{pair:?} {all:?}");
        assert!(bench.bytes("x.exr") == bench.bytes("whole.exr"), "{order:?}");
    }

    bench.rendered(&[&GLOBAL[..3], &["7", "--shard", "1/3", "--checkpoint", "1", "--aov", "N"]].concat());
    let words =
        ["layers: it was made with N, and the files before it with Albedo, P, N, Ns, slope, direct, caustic, square"];
    bench.run(&["merge", "0", "1", "-o", "y.exr"]).assert_refused("other layers", 2, &words);
}

#[test]
fn what_does_not_belong_together_is_refused() {
    let bench = three_shards();
    let render = |arguments: &[&str]| bench.rendered(&[&GLOBAL[..], arguments].concat());
    render(&["--shard", "0/2", "--checkpoint", "half"]);
    render(&["--shard", "1/3", "--seed", "9", "--checkpoint", "seed"]);
    bench.write("text", "not a checkpoint");
    let merge = |arguments: &[&str]| bench.run(&[&["merge", "-o", "x.exr"], arguments].concat());
    let cases: &[(&[&str], i32, &[&str])] = &[
        (&["./0", "1", "0"], 2, &["0: shard 0/3 is in ./0 as well; expected each shard once"]),
        (
            &["0", "half"],
            2,
            &["half: it is one of 2 shards, and the files before it are of 3; expected all shards of one"],
        ),
        (
            &["0", "seed"],
            2,
            &["seed: seed: it was made with 9, and the files before it with 0; expected shards of one"],
        ),
        (&["0", "text"], 2, &["text: not a whole checkpoint of goblet"]),
        (&["0", "absent"], 2, &["absent: cannot read the checkpoint", "No such file"]),
        (&[], 2, &["<CHECKPOINT>"]),
        (&["0", "--checkpoint", "missing/x"], 1, &["missing/x: cannot write the checkpoint"]),
        (&["0", "-o", "missing/x.exr"], 1, &["missing/x.exr: cannot write the image"]),
    ];
    for (arguments, code, words) in cases {
        merge(arguments).assert_refused(&format!("{arguments:?}"), *code, words);
        assert!(!bench.path("x.exr").exists(), "{arguments:?}");
    }
    bench.run(&["merge", "0"]).assert_refused("no output", 2, &["--output"]);

    bench.run(&["merge", "0", "1", "--checkpoint", "01", "--quiet"]);
    let run = bench.render(&[&GLOBAL[..], &["--shard", "0/3", "--resume", "01", "--checkpoint", "y"]].concat());
    let words =
        "01: the checkpoint is of merged shards (0, 1 of 3), and this render is shard 0/3; expected the checkpoint of";
    run.assert_refused("merged", 2, &[words]);
}

#[test]
fn the_environment_of_an_array_job_gives_the_shard() {
    let bench = Bench::new();
    let render = |variables: &[(&str, &str)]| {
        let arguments = [&["render", "scene.pbrt"], &GLOBAL[..], &["--shard", "auto", "--checkpoint", "x"]].concat();
        Run::of(bench.command(&arguments).envs(variables.iter().copied()).output().unwrap())
    };
    let arrays: [&[(&str, &str)]; 4] = [
        &[("SLURM_ARRAY_TASK_ID", "1"), ("SLURM_ARRAY_TASK_COUNT", "3")],
        &[("SLURM_ARRAY_TASK_ID", "2"), ("SLURM_ARRAY_TASK_COUNT", "3"), ("SLURM_ARRAY_TASK_MIN", "1")],
        &[("JOB_COMPLETION_INDEX", "1"), ("JOB_COMPLETIONS", "3")],
        &[("AWS_BATCH_JOB_ARRAY_INDEX", "1"), ("AWS_BATCH_JOB_ARRAY_SIZE", "3")],
    ];
    for variables in arrays {
        let run = render(variables);
        assert_eq!(run.code, 0, "{variables:?}: {}", run.stderr);
        let checkpoint = Checkpoint::read(&bench.path("x")).unwrap();
        // Of iterations 0 to 6: 1 and 4.
        assert_eq!((checkpoint.shards, checkpoint.done), (3, [(1, 2)].into()), "{variables:?}");
    }
    let wrong: [(&[(&str, &str)], &str); 4] = [
        (&[], "not in an array job: expected one of SLURM_ARRAY_TASK_ID (Slurm)"),
        (&[("JOB_COMPLETION_INDEX", "1")], "JOB_COMPLETIONS is not"),
        (&[("AWS_BATCH_JOB_ARRAY_INDEX", "3"), ("AWS_BATCH_JOB_ARRAY_SIZE", "3")], "below the count"),
        (&[("SLURM_ARRAY_TASK_ID", ""), ("SLURM_ARRAY_TASK_COUNT", "3")], "expected a whole number"),
    ];
    for (variables, words) in wrong {
        render(variables).assert_refused(&format!("{variables:?}"), 2, &["--shard", words]);
    }
}

#[test]
fn radii_that_depend_on_photons_cannot_be_shared() {
    for schedule in ["adaptive", "data"] {
        let run = Bench::new().render(&["--radius-schedule", schedule, "--shard", "0/2", "--checkpoint", "x"]);
        run.assert_refused(schedule, 2, &["expected the global radius schedule or the integrator ppm"]);
    }
}
