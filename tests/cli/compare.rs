//! `goblet compare`: its limits, its maps and its JSON.

use goblet::cli::compare::{Place, draw};
use goblet::image::difference::{Difference, DifferenceMap, Scale};
use goblet::image::file;
use goblet::image::film::{Image, picture};
use serde_json::Value;

use crate::support::command::Bench;
use crate::support::schema::Schema;

#[test]
fn compare_measures_and_keeps_the_gates() {
    let bench = Bench::new();
    for (name, size, value) in
        [("a.exr", 4, 1.0), ("b.exr", 4, 0.9), ("small.exr", 2, 1.0), ("nan.exr", 4, f32::NAN), ("a.png", 4, 1.0)]
    {
        let image = Image::from_pixels(size, size, vec![[value; 3]; (size * size) as usize]).unwrap();
        file::write(&bench.path(name), &image, &[]).unwrap();
    }
    // The relMSE is 0.01 / 0.82, the energy ratio 1 / 0.9.
    let cases: &[(&[&str], i32, &str)] = &[
        (&["a.exr", "b.exr"], 0, "mean energy ratio"),
        (&["a.exr", "a.png", "--max-relmse", "0", "--max-energy", "0"], 0, "passed"),
        (&["a.exr", "b.exr", "--max-relmse", "0.013", "--max-energy", "0.12"], 0, "passed"),
        (&["a.exr", "b.exr", "--max-relmse", "0.012"], 1, "FAILED: relMSE"),
        (&["a.exr", "b.exr", "--max-energy", "0.1"], 1, "FAILED: |energy ratio - 1|"),
        (&["nan.exr", "b.exr", "--max-energy", "1"], 1, "not finite"),
        (&["a.exr", "b.exr", "--json", "--max-energy", "0.1"], 1, "\"passed\": false"),
    ];
    for (arguments, code, words) in cases {
        let run = bench.run(&[&["compare"], *arguments].concat());
        assert_eq!((run.code, run.stderr.as_str()), (*code, ""), "{arguments:?}: {run:?}");
        assert!(run.stdout.contains(words), "{arguments:?}: {run:?}");
    }

    let run = bench.run(&["compare", "a.exr", "b.exr", "--json", "--diff", "diff.png"]);
    let json: Value = serde_json::from_str(&run.stdout).unwrap();
    assert!((json["energy_ratio"].as_f64().unwrap() - 1.0 / 0.9).abs() < 1e-6, "{json:#}");
    assert!((json["rmse"].as_f64().unwrap() - 0.1).abs() < 1e-6, "{json:#}");

    for (arguments, words) in [
        (["a.exr", "absent.exr"], "absent.exr: cannot read the image"),
        (["a.exr", "small.exr"], "4x4 and the reference 2x2: expected the same size; `goblet render --resolution 2x2`"),
        (["a.exr", "scene.pbrt"], "supported are .exr"),
        (["a.exr", "--max-relmse=-1"], "--max-relmse"),
    ] {
        let run = bench.run(&[&["compare"], &arguments[..]].concat());
        run.assert_refused(&format!("{arguments:?}"), 2, &[words]);
    }
}

/// Greys whose relative differences of luminance are -0.5, 0, 0.25 and 0.5, in columns: a reference of √0.99 makes
/// them differences of radiance.
fn columns(bench: &Bench) -> [Image; 2] {
    const DIFFERENCES: [f32; 4] = [-0.5, 0.0, 0.25, 0.5];
    let one = 0.99_f32.sqrt();
    let rows = |value: &dyn Fn(usize) -> f32| (0..16).map(|i| [value(i % 4); 3]).collect();
    let image = Image::from_pixels(4, 4, rows(&|column| one + DIFFERENCES[column])).unwrap();
    let reference = Image::from_pixels(4, 4, rows(&|_| one)).unwrap();
    for (name, image) in [("image.exr", &image), ("reference.exr", &reference)] {
        file::write(&bench.path(name), image, &[]).unwrap();
    }
    [image, reference]
}

/// A pixel of known difference has the colour that the scale has at its value.
#[test]
fn maps_have_the_colors_of_their_scale() {
    let bench = Bench::new();
    let [image, reference] = columns(&bench);
    let compare = |arguments: &[&str]| {
        let run = bench.run(&[&["compare", "image.exr", "reference.exr", "--diff", "map.png"], arguments].concat());
        assert!(run.code == 0 && run.stderr.is_empty() && run.stdout.contains("wrote map.png: "), "{run:?}");
        let map = bench.image("map.png");
        (map.width, picture(&map))
    };
    for (kind, name, values) in [
        (Difference::Signed, "signed", [-0.5, 0.0, 0.25, 0.5]),
        (Difference::Relative, "relative", [0.5, 0.0, 0.25, 0.5]),
        (Difference::Absolute, "absolute", [0.5, 0.0, 0.25, 0.5]),
    ] {
        for sides in [false, true] {
            let most = 0.75;
            let options = ["--diff-kind", name, "--diff-max", "0.75", "--side-by-side"];
            let (width, pixels) = compare(&options[..4 + usize::from(sides)]);
            let scale = Scale::new(kind, most);
            let map = DifferenceMap::new(kind, &image, &reference).unwrap().unwrap();
            let (expected, Place { first: [x, y], zoom }) = draw(&map, &scale, sides.then_some([&image, &reference]));
            assert_eq!((width, &pixels), (expected.width, &picture(&expected)), "{name}");
            for (column, value) in values.into_iter().enumerate() {
                let at = 3 * ((y + zoom / 2) * width + x + column as u32 * zoom + zoom / 2) as usize;
                // √0.99 and its sums are rounded to f32.
                let near = scale.color(value).iter().zip(&pixels[at..at + 3]).all(|(a, b)| a.abs_diff(*b) <= 1);
                assert!(near, "{name} {value}: {:?}, {:?}", scale.color(value), &pixels[at..at + 3]);
            }
        }
    }
    // White and nothing else where all is equal, but for texts, frames and the scale.
    file::write(&bench.path("image.exr"), &reference, &[]).unwrap();
    let (width, pixels) = compare(&["--diff-kind", "signed"]);
    let row = (pixels.len() / 3 / width as usize / 2) * width as usize;
    assert!(pixels[3 * (row + 15)..3 * (row + 195)].iter().all(|channel| *channel == 255));
}

/// An EXR has the values of the map.
#[test]
fn an_exr_has_the_values_of_the_map() {
    let bench = Bench::new();
    columns(&bench);
    let values = |kind: &str| {
        let run =
            bench.run(&["compare", "image.exr", "reference.exr", "--diff", "map.exr", "--diff-kind", kind, "--json"]);
        assert_eq!(run.code, 0, "{run:?}");
        let json: Value = serde_json::from_str(&run.stdout).unwrap();
        assert!(json["diff"]["kind"] == kind && json["diff"]["scale"].is_null(), "{json:#}");
        let pixels = bench.image("map.exr").pixels;
        assert!(pixels.iter().all(|pixel| pixel[0] == pixel[1] && pixel[0] == pixel[2]));
        let values: Vec<f64> = pixels.iter().map(|pixel| f64::from(pixel[0])).collect();
        (values, json)
    };
    let (relative, json) = values("relative");
    let mean_square = relative.iter().map(|value| value * value).sum::<f64>() / 16.0;
    assert!((mean_square - json["relmse"].as_f64().unwrap()).abs() < 1e-6, "{json:#}");
    let (flip, json) = values("flip");
    let mean = flip.iter().sum::<f64>() / 16.0;
    assert!(mean > 0.05 && (mean - json["flip"]["mean"].as_f64().unwrap()).abs() < 1e-6, "{mean}: {json:#}");
}

#[test]
fn the_json_is_as_documented() {
    let bench = Bench::new();
    columns(&bench);
    let mut schema = Schema::default();
    let arguments = ["compare", "image.exr", "reference.exr", "--json"];
    let mut add = |more: &[&str], code: i32| {
        let run = bench.run(&[&arguments[..], more].concat());
        assert_eq!(run.code, code, "{run:?}");
        let json: Value = serde_json::from_str(&run.stdout).unwrap();
        schema.add(&json);
        json
    };
    add(&["--max-energy", "1", "--max-relmse", "1"], 0);
    add(&["--diff", "map.exr"], 0);
    let exposed = add(&["--exposure", "-2.5"], 0);
    let json = add(&["--diff", "map.png", "--max-relmse", "0"], 1);
    schema.assert_is(include_str!("schemas/compare-1.txt"), "compare-1.txt");
    schema.assert_documented("goblet compare --json");
    assert_eq!(exposed["flip"]["exposure_stops"], -2.5);
    assert!(exposed["flip"]["mean"].as_f64() < json["flip"]["mean"].as_f64(), "{exposed:#}");

    // A snapshot of what does not depend on roundings.
    assert_eq!(json["schema_version"], 1);
    assert_eq!(
        json["diff"],
        serde_json::json!({ "file": "map.png", "kind": "relative", "unit": "1", "scale": [0.0, 0.5] })
    );
    assert_eq!(json["gates"], serde_json::json!({ "max_relmse": 0.0, "max_energy": null }));
    assert_eq!((&json["flip"]["variant"], &json["flip"]["exposure_stops"]), (&"LDR".into(), &0.0.into()));
    assert_eq!((&json["passed"], json["failures"].as_array().unwrap().len()), (&false.into(), 1));
    let text = bench.run(&["compare", "image.exr", "reference.exr"]).stdout;
    assert!(text.contains("LDR, exposure 0 stops, 67 pixels a degree"), "{text}");
}

#[test]
fn options_of_a_map_need_a_map() {
    let bench = Bench::new();
    columns(&bench);
    for (arguments, words) in [
        (&["--side-by-side"][..], "--diff"),
        (&["--diff-max", "1"], "--diff"),
        (&["--diff-kind", "signed"], "--diff"),
        (&["--diff", "map.exr", "--side-by-side"], "--side-by-side: expected a --diff that ends in .png"),
        (&["--diff", "map.exr", "--diff-max", "1"], "--diff-max: expected a --diff that ends in .png"),
        (&["--diff", "map.png", "--diff-max", "0"], "above 0"),
        (&["--diff", "map.png", "--diff-kind", "heat"], "relative, signed, absolute, flip"),
    ] {
        let run = bench.run(&[&["compare", "image.exr", "reference.exr"], arguments].concat());
        run.assert_refused(&format!("{arguments:?}"), 2, &[words]);
        assert!(!bench.path("map.png").exists() && !bench.path("map.exr").exists());
    }
}
