//! Tests of the values that the command line accepts.

use std::time::Duration;

use clap::CommandFactory;

use super::*;
use crate::gpu_scene::pack::{Envelopes, RevolutionSolver};

fn render(arguments: &[&str]) -> Result<RenderArgs, clap::Error> {
    let fixed = ["goblet", "render", "scene.pbrt"];
    match Cli::try_parse_from(fixed.iter().chain(arguments))?.command {
        Command::Render(args) => Ok(*args),
        other => panic!("{other:?}"),
    }
}

#[test]
fn the_definition_is_consistent() {
    Cli::command().debug_assert();
}

#[test]
fn all_options_of_render_arrive() {
    let args = render(&[
        "-o",
        "a.exr",
        "--output",
        "b.PNG",
        "--iterations",
        "64",
        "--time",
        "1.5",
        "--photons",
        "2e9",
        "--radius",
        "0.25",
        "--alpha",
        "1",
        "--max-depth",
        "8",
        "--seed",
        "4294967295",
        "--resolution",
        "640x480",
        "--device",
        "llvmpipe",
        "--stats",
        "s.json",
        "--validate",
        "--quiet",
        "--workgroup-size",
        "128",
        "--batch-size",
        "1024",
    ])
    .unwrap();
    assert_eq!(args.output, [PathBuf::from("a.exr"), PathBuf::from("b.PNG")]);
    let (options, limits) = (args.options(), &args.request.limits);
    assert_eq!((limits.time, limits.iterations), (Some(Duration::from_millis(1500)), Some(64)));
    assert_eq!(options.photons, Some(2_000_000_000));
    assert_eq!((options.radius, options.alpha), (Some(0.25), Some(1.0)));
    assert_eq!((options.max_depth, options.seed, options.resolution), (Some(8), Some(u32::MAX), Some([640, 480])));
    assert_eq!((options.workgroup_size, options.batch_size), (Some(128), Some(1024)));
    assert!(args.validate && args.quiet && args.stats.is_some() && args.device.is_some());
}

#[test]
fn a_radius_is_a_length_or_pixels() {
    for (text, expected) in [("2px", (None, Some(2.0))), ("0.5px", (None, Some(0.5))), ("2", (Some(2.0), None))] {
        let options = render(&["--radius", text]).unwrap().options();
        assert_eq!((options.radius, options.radius_in_pixels), expected);
    }
}

#[test]
fn values_that_cannot_be_rendered_are_usage_errors() {
    let cases: &[(&str, &[&str], &str)] = &[
        ("-o", &["a.jpg", "a", ""], ".exr or .png"),
        ("--iterations", &["0", "-1", "1.5", "4294967296"], "from 1 to 4294967295"),
        ("--time", &["0", "-1", "nan", "inf", "1e30", "1e-30", "x"], "seconds above 0"),
        ("--photons", &["0", "-5", "1.5", "1e30", "nan", "18446744073709551616"], "whole number from 1"),
        ("--radius", &["0", "-1", "nan", "inf", "1e30", "1e-30", "x", "px", "0px", "65px", "nanpx"], "length above 0"),
        ("--alpha", &["0", "-0.5", "1.01", "nan", "inf"], "above 0 and at most 1"),
        ("--max-depth", &["0", "-1"], "whole number from 1"),
        ("--seed", &["-1", "4294967296", "x"], "from 0 to 4294967295"),
        ("--resolution", &["0x0", "1x0", "65537x1", "640", "1x2x3", "-1x1"], ""),
        ("--workgroup-size", &["0", "33", "256"], "32, 64, 128"),
        ("--batch-size", &["0", "4294967296"], "whole number from 1"),
    ];
    for (option, values, expected) in cases {
        for value in *values {
            let error = render(&[option, value]).expect_err(value);
            assert_eq!(error.exit_code(), 2);
            let message = error.to_string();
            assert!(message.contains(expected), "{option} {value}: {message}");
            assert!(message.contains(option), "{option} {value}: {message}");
        }
    }
}

#[test]
fn a_solver_is_chosen_and_only_newtons_has_options() {
    let solver = |arguments: &[&str]| render(arguments).map(|args| args.options().revolution_solver);
    assert_eq!(solver(&[]).unwrap(), RevolutionSolver::Certified);
    assert_eq!(solver(&["--revolution-solver", "certified"]).unwrap(), RevolutionSolver::Certified);
    let newton = |segments, envelopes| RevolutionSolver::Newton { segments, envelopes };
    let chosen = ["--revolution-solver", "newton"];
    assert_eq!(solver(&chosen).unwrap(), newton(16, Envelopes::Both));
    for (name, which) in [("chord", Envelopes::Chord), ("tangent", Envelopes::Tangent), ("both", Envelopes::Both)] {
        let all = [&chosen[..], &["--newton-segments", "64", "--newton-envelopes", name]].concat();
        assert_eq!(solver(&all).unwrap(), newton(64, which));
    }
    let wrong: &[(&[&str], &str)] = &[
        (&["--newton-segments", "4"], "--newton-segments requires --revolution-solver newton"),
        (&["--newton-envelopes", "both"], "--newton-envelopes requires --revolution-solver newton"),
        (&["--revolution-solver", "certified", "--newton-segments", "4"], "requires --revolution-solver newton"),
        (&["--revolution-solver", "newton", "--newton-segments", "0"], "from 1 to 64"),
        (&["--revolution-solver", "newton", "--newton-segments", "-1"], "from 1 to 64"),
        (&["--revolution-solver", "newton", "--newton-segments", "65"], "from 1 to 64"),
        (&["--revolution-solver", "newton", "--newton-envelopes", "none"], "chord, tangent, both"),
        (&["--revolution-solver", "exact"], "certified, newton"),
    ];
    for (arguments, expected) in wrong {
        let error = solver(arguments).expect_err(expected);
        assert_eq!(error.exit_code(), 2);
        assert!(error.to_string().contains(expected), "{arguments:?}: {error}");
    }
}

#[test]
fn compare_takes_two_images_and_finite_limits() {
    let parse = |arguments: &[&str]| Cli::try_parse_from(["goblet", "compare"].iter().chain(arguments));
    assert!(parse(&["a.exr"]).is_err());
    assert!(parse(&["a.exr", "b.exr", "--max-relmse", "nan"]).is_err());
    assert!(parse(&["a.exr", "b.exr", "--max-energy", "-1"]).is_err());
    assert!(parse(&["a.exr", "b.exr", "--diff", "d.gif"]).is_err());
    let cli = parse(&["a.exr", "b.exr", "--max-relmse", "0.01", "--json"]).unwrap();
    let Command::Compare(args) = cli.command else {
        panic!("{cli:?}");
    };
    assert_eq!((args.max_relmse, args.max_energy, args.json), (Some(0.01), None, true));
}
