//! The table has every field of [`Options`], and the values derived from the table are consistent.

use super::*;
use crate::render::counts::Auto;
use crate::render::options::written::Refusal;
use crate::render::sequence::Shard;
use crate::{Contribution, RevolutionSolver, Submission};

/// Returns a value of the option that is not its default.
fn another(option: &RenderOption) -> String {
    match &option.kind {
        Kind::Whole { range: [least, _], .. } | Kind::WholeOrAuto { range: [least, _], .. } => (least + 3).to_string(),
        Kind::Number { range: [least, most], .. } => (0.5 * (least + most)).to_string(),
        Kind::Named { names, .. } => {
            let other = names.iter().find(|(name, _)| option.default_text() != *name);
            other.expect("two names").0.to_owned()
        }
        Kind::Form { .. } if option.name == "resolution" => "7x5".to_owned(),
        Kind::Form { .. } => "0.5".to_owned(),
    }
}

fn request(options: &[&str]) -> Result<Request, Refusal> {
    let given: Vec<_> = options.iter().map(|name| (find(name), another(find(name)))).collect();
    Request::from_values(&given.iter().map(|(option, text)| (*option, text.as_str())).collect::<Vec<_>>())
}

#[test]
fn names_are_unique_and_written_as_on_the_command_line() {
    for (i, option) in OPTIONS.iter().enumerate() {
        assert_eq!(OPTIONS.iter().position(|other| other.name == option.name), Some(i), "{}", option.name);
        assert!(option.name.chars().all(|letter| letter.is_ascii_lowercase() || letter == '-'), "{}", option.name);
        assert!(!option.help.is_empty() && !option.help.ends_with('.'), "{}", option.name);
        assert!(option.more.is_empty() || option.more.ends_with('.'), "{}", option.name);
        if let Needs::Value(other, _) | Needs::Absence(other) = option.needs {
            let other = OPTIONS.iter().position(|option| option.name == other);
            assert!(other.is_some_and(|other| other < i), "{} comes after what it needs", option.name);
        }
    }
}

#[test]
fn every_field_is_set_by_an_option() {
    let names: Vec<&str> = OPTIONS.iter().map(|option| option.name).filter(|name| *name != "rounds").collect();
    let in_pixels = Request::from_values(&[(find("radius"), "2px")]).unwrap().options;
    assert!(in_pixels.radius_in_pixels == Some(2.0) && in_pixels.radius.is_none());
    // A new field does not compile here until it is listed.
    let Options {
        resolution,
        photons,
        eye_paths,
        auto,
        radius,
        radius_in_pixels,
        alpha,
        max_depth,
        seed,
        integrator,
        photons_per_round,
        radius_schedule,
        direct,
        guidance,
        dispersion,
        contribution,
        layers,
        sampler,
        shard,
        lookup,
        cell_scale,
        workgroup_size,
        batch_size,
        responsive,
        submission,
        revolution_solver,
    } = request(&names).unwrap().options;
    let default = Options::default();
    assert!(resolution.is_some() && photons.is_some() && eye_paths.is_some() && radius.is_some());
    assert_eq!(auto, Auto::default());
    assert!(alpha.is_some() && max_depth.is_some() && seed.is_some() && photons_per_round.is_some());
    assert!(cell_scale.is_some() && workgroup_size.is_some() && batch_size.is_some());
    assert!(integrator != default.integrator && radius_schedule != default.radius_schedule);
    assert!(guidance != default.guidance && dispersion != default.dispersion);
    assert!(direct != default.direct && sampler != default.sampler && lookup != default.lookup);
    assert!(
        matches!(revolution_solver, RevolutionSolver::Newton { segments: 4, envelopes } if envelopes != Default::default())
    );
    // A radius is one or the other; the shard and layers are arguments of their own; the viewer sets the rest.
    assert_eq!((radius_in_pixels, shard, layers), (None, Shard::WHOLE, default.layers));
    assert_eq!((contribution, responsive, submission), (Contribution::All, false, Submission::Auto));
}

/// A checkpoint is continued only if all these values agree. The names must stay, because existing files
/// contain them.
#[test]
fn checkpoints_keep_what_changes_the_image() {
    let mut kept = Vec::new();
    for option in OPTIONS {
        match option.effect {
            Effect::Image(name, _) => kept.push(name),
            Effect::PartOf | Effect::End | Effect::Cost => {}
        }
    }
    assert_eq!(
        kept,
        [
            "photons per iteration",
            "eye paths per iteration",
            "radius",
            "alpha",
            "maximum depth",
            "seed",
            "resolution",
            "integrator",
            "iterations per round",
            "radius schedule",
            "direct light",
            "guide",
            "dispersion",
            "sampler",
            "revolution solver",
        ]
    );
}

#[test]
fn values_are_refused_with_what_was_expected() {
    let cases: &[(&str, &[&str], &str)] = &[
        ("iterations", &["0", "-1", "1.5", "4294967296"], "expected a whole number from 1 to 4294967295"),
        ("photons", &["0", "2147483649", "nan", "1e30"], "expected a whole number from 1 to 2147483648"),
        ("photons-per-round", &["0", "18446744073709551616"], "from 1 to 18446744073709551615"),
        ("alpha", &["0", "1.01", "nan", "1e-60"], "expected a number above 0 and at most 1"),
        ("cell-scale", &["0.2", "9", "x"], "expected a number from 0.25 to 8"),
        ("sampler", &["", "Sobol"], "expected pcg or sobol"),
        ("workgroup-size", &["33", "x"], "expected 32, 64 or 128"),
        ("radius", &["0", "65px", "px"], "expected a length above 0"),
    ];
    for (name, values, expected) in cases {
        for value in *values {
            let refusal = Request::from_values(&[(find(name), value)]).unwrap_err().to_string();
            let start = format!("invalid value '{value}' for --{name}: ");
            assert!(refusal.starts_with(&start) && refusal.contains(expected), "{refusal}");
        }
    }
    let photons = Request::from_values(&[(find("photons"), "5e8")]).unwrap().options.photons;
    assert_eq!(photons, Some(500_000_000));
}

#[test]
fn a_trial_chooses_numbers_that_are_auto() {
    let auto = |values: &[_]| Request::from_values(values).unwrap().options;
    let (photons, eye_paths) = (find("photons"), find("eye-paths"));
    assert_eq!(auto(&[(photons, "auto")]).auto, Auto { photons: true, eye_paths: false });
    let both = auto(&[(photons, "auto"), (eye_paths, "auto")]);
    assert_eq!((both.auto, both.photons, both.eye_paths), (Auto { photons: true, eye_paths: true }, None, None));
    let one = auto(&[(photons, "4096"), (eye_paths, "auto")]);
    assert_eq!((one.auto, one.photons), (Auto { photons: false, eye_paths: true }, Some(4096)));
}

#[test]
fn options_that_do_not_fit_each_other_are_refused() {
    for (options, words) in [
        (&["newton-segments"][..], "--newton-segments requires --revolution-solver newton"),
        (&["newton-envelopes"], "--newton-envelopes requires --revolution-solver newton"),
        (&["rounds", "iterations"], "--rounds cannot be used with --iterations"),
    ] {
        assert_eq!(request(options).unwrap_err().to_string(), words);
    }
}

#[test]
fn workgroup_sizes_have_names() {
    let Kind::Named { names, .. } = find("workgroup-size").kind else { panic!("no names") };
    let sizes: Vec<u32> = names.iter().map(|(name, _)| name.parse().unwrap()).collect();
    assert_eq!(sizes, Options::WORKGROUP_SIZES);
}

#[test]
fn defaults_are_written_as_they_are() {
    let texts = ["photons", "radius", "alpha", "photons-per-round", "sampler", "workgroup-size", "time"];
    let written = texts.map(|name| find(name).default_text());
    assert_eq!(
        written,
        ["the scene's, else one per pixel", "the scene's, else 3px", "0.6667", "16 iterations", "sobol", "64", ""]
    );
}
