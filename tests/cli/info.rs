//! `goblet info`: what it says of scenes that can be rendered and of others.

use goblet::image::file;
use goblet::image::film::Image;
use goblet::image::layers::{Group, Groups};
use goblet::{DeviceOptions, Options, Renderer, open_device};
use serde_json::Value;

use crate::support::command::{self, Bench, LIGHT, scene};
use crate::support::schema::Schema;

fn info(bench: &Bench, code: i32) -> Value {
    let run = bench.run(&["info", "scene.pbrt", "--json"]);
    assert_eq!(run.code, code, "{run:?}");
    serde_json::from_str(&run.stdout).unwrap()
}

#[test]
fn a_scene_is_described() {
    let bench = Bench::new();
    let info = info(&bench, 0);
    assert_eq!(info["scene"]["spheres"], 1);
    assert_eq!(info["scene"]["point_lights"], 1);
    assert_eq!(info["film"]["resolution"], serde_json::json!([16, 12]));
    assert_eq!(info["integrator"]["photons_per_iteration"], 500);
    assert_eq!(info["specialization"]["has_dielectrics"], true);
    assert!(info["specialization"].get("has_conductors").is_none());
    let power = info["light_power"]["point"].as_f64().unwrap();
    assert!((power / (4.0 * std::f64::consts::PI * 5.0) - 1.0).abs() < 1e-6, "{power}");
    assert_eq!(info["unsupported"], serde_json::json!([]));
    let text = bench.run(&["info", "scene.pbrt"]);
    assert!(text.code == 0 && text.stdout.contains("\n  spheres: 1\n"), "{text:?}");
}

/// Photons are gathered on rough surfaces where only they bring light: here through glass onto metal.
#[test]
fn what_rough_surfaces_gather_is_a_feature() {
    let bench = Bench::new();
    let gathers = |text: String| {
        bench.write("scene.pbrt", text);
        let info = info(&bench, 0);
        assert_eq!(info["warnings"], serde_json::json!([]));
        info["specialization"].get("has_rough_gather").is_some()
    };
    let with_metal = scene("Material \"diffuse\"", "Material \"conductor\" \"float roughness\" .3");
    assert!(gathers(with_metal.clone()));
    assert!(!gathers(command::SCENE.to_owned()), "there is no rough surface");
    let sky = "LightSource \"infinite\"";
    assert!(!gathers(with_metal.replace(LIGHT, sky)), "rays meet the light");
}

/// One line for each parameter of a type, with the place of the first.
#[test]
fn parameters_that_change_nothing_are_listed() {
    let bench = Bench::new();
    let more = "Material \"coateddiffuse\" \"integer maxdepth\" 5 Material \"coateddiffuse\" \"integer maxdepth\" 6";
    let text = scene(LIGHT, &format!("{LIGHT}\n{more}")).replace("\"sppm\"", "\"sppm\" \"float rrthreshold\" 1");
    bench.write("scene.pbrt", text);
    let expected = [
        "scene.pbrt:5:19: \"float rrthreshold\" of Integrator \"sppm\"",
        "scene.pbrt:8:26: \"integer maxdepth\" of Material \"coateddiffuse\"",
    ];
    assert_eq!(info(&bench, 0)["ignored"], serde_json::json!(expected));
    let run = bench.run(&["info", "scene.pbrt"]);
    assert!(run.stdout.contains(&format!("\nignored: {}\n", expected[0])), "{run:?}");
}

#[test]
fn everything_unsupported_is_listed() {
    let bench = Bench::new();
    let more = "Shape \"curve\" MakeNamedMedium \"fog\" \"string type\" \"cloud\" MediumInterface \"fog\" \"\"
        Material \"hair\" Shape \"sphere\" Material \"diffuse\"";
    bench.write("scene.pbrt", scene(LIGHT, &format!("{LIGHT}\n{more}")).replace("\"perspective\"", "\"realistic\""));
    let info = info(&bench, 2);
    let unsupported: Vec<&str> =
        info["unsupported"].as_array().unwrap().iter().map(|error| error.as_str().unwrap()).collect();
    for (line, what) in [(3, "realistic"), (8, "curve"), (8, "MakeNamedMedium"), (9, "hair")] {
        let found = unsupported.iter().any(|it| it.starts_with(&format!("scene.pbrt:{line}:")) && it.contains(what));
        assert!(found, "{what}: {unsupported:#?}");
    }
    assert_eq!(info["scene"]["spheres"], 2);
    // What is simply wrong is so here too, beside what is not supported.
    bench.write("scene.pbrt", scene(LIGHT, "Shape \"curve\" Shape \"cube\""));
    let run = bench.run(&["info", "scene.pbrt"]);
    assert_eq!(run.code, 2);
    let lines =
        ["unsupported: scene.pbrt:7:7: ", "error: scene.pbrt:7:21: unknown Shape \"cube\"", "cannot be rendered"];
    assert!(lines.iter().all(|line| run.stderr.contains(line)), "{run:?}");
    assert!(!run.stdout.contains("\"curve\"") && !run.stdout.contains("\"cube\""), "{run:?}");
}

/// Standard output has what the scene is, standard error what is wrong with it.
#[test]
fn a_fault_is_printed_once() {
    let bench = Bench::new();
    let run = bench.run(&["info", "absent.pbrt"]);
    assert_eq!((run.code, run.stdout.as_str()), (2, ""), "{run:?}");
    assert_eq!(run.stderr.matches("cannot read absent.pbrt").count(), 1, "{run:?}");
    bench.write("scene.pbrt", scene(LIGHT, &format!("{LIGHT} Shape \"cube\"")));
    let run = bench.run(&["info", "scene.pbrt"]);
    assert_eq!((run.code, run.stderr.matches("cube").count(), run.stderr.lines().count()), (2, 1, 1), "{run:?}");
    assert!(run.stdout.contains("\n  spheres: 1\n") && !run.stdout.contains("cube"), "{run:?}");
    bench.write("scene.pbrt", "WorldBegin\n");
    let run = bench.run(&["info", "scene.pbrt"]);
    assert!(run.code == 0 && run.stderr.lines().all(|line| line.starts_with("warning: ")), "{run:?}");
    assert_eq!(run.stderr.lines().count(), 3, "{run:?}");
}

/// Also after a missing file, a fault in the text, or a fault that shows at the end.
#[test]
fn everything_wrong_is_listed() {
    let bench = Bench::new();
    let faults = "Shape \"plymesh\" \"string filename\" \"none.ply\"
Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"none.png\"
Material \"diffuse\" \"texture reflectance\" \"t\" Shape \"disk\"
Include \"none.pbrt\"
Translate 1 2 x
NamedMaterial \"none\" Shape \"disk\"
Shape \"sphere\" \"float radius\" 1.2.3 \"float zmin\" 0
LightSource \"infinite\" \"string filename\" \"none.exr\"
Shape \"cube\" Shape \"curve\" Shape \"sphere\" \"float radius\" -1
ObjectInstance \"none\" Material \"measured\" \"string filename\" \"none.bsdf\"
LightSource \"point\" \"string name";
    bench.write("scene.pbrt", scene(LIGHT, &format!("{faults}\n{LIGHT}")));
    let info = info(&bench, 2);
    let list = |key: &str| -> Vec<String> { serde_json::from_value(info[key].clone()).unwrap() };
    let (errors, unsupported) = (list("errors"), list("unsupported"));
    for (line, what) in [
        (7, "none.ply"),
        (8, "none.png"),
        (10, "none.pbrt"),
        (11, "found `x`; expected 3 numbers"),
        (12, "unknown material \"none\""),
        (13, "`1.2.3` is not a number"),
        (14, "none.exr"),
        (15, "unknown Shape \"cube\""),
        (15, "\"float radius\" is -1"),
        (16, "unknown object \"none\""),
        (16, "none.bsdf"),
        (17, "unterminated string"),
    ] {
        let found = errors.iter().any(|it| it.starts_with(&format!("scene.pbrt:{line}:")) && it.contains(what));
        assert!(found, "{line} {what}: {errors:#?}");
    }
    assert_eq!((errors.len(), unsupported.len()), (12, 1), "{errors:#?} {unsupported:#?}");
    assert_eq!(info["scene"]["spheres"], 1);
    let text = bench.run(&["info", "scene.pbrt"]);
    assert!(text.code == 2 && text.stderr.contains("none.ply") && text.stderr.contains("none.exr"), "{text:?}");
    assert!(text.stderr.contains("scene.pbrt cannot be rendered as it is"), "{text:?}");
}

#[test]
fn scenes_of_nothing_are_described() {
    let bench = Bench::new();
    bench.write("scene.pbrt", "WorldBegin\n");
    let info = info(&bench, 0);
    assert_eq!((&info["bounds"], &info["errors"]), (&Value::Null, &serde_json::json!([])));
    assert_eq!(info["warnings"].as_array().unwrap().len(), 3);
}

/// The estimate counts what a renderer allocates. Layers take what the guide says of them.
#[test]
fn memory_is_about_what_a_render_takes() {
    const PIXELS: f64 = 512.0 * 512.0;
    let bench = Bench::new();
    let size = "xresolution\" 512 \"integer yresolution\" 512";
    let plain = scene("xresolution\" 16 \"integer yresolution\" 12", size);
    let device =
        std::sync::Arc::new(open_device(&DeviceOptions { validation: true, ..DeviceOptions::default() }).unwrap());
    let taken = |scene: &goblet::scene::Scene, layers: Groups| {
        let before = device.allocated_bytes();
        let options = Options { layers, ..Options::default() };
        let _renderer = Renderer::new(device.clone(), scene, &options).unwrap();
        (device.allocated_bytes() - before) as f64
    };
    let mut without = 0.0;
    for (film, of_layers) in [("\"rgb\"", 0.0), ("\"gbuffer\"", 480.0)] {
        bench.write("scene.pbrt", plain.replace("\"rgb\"", film));
        let memory = &info(&bench, 0)["memory"];
        let estimate = memory["scene"].as_f64().unwrap() + memory["buffers"].as_f64().unwrap();
        let scene = goblet::scene::Scene::load(bench.path("scene.pbrt")).unwrap();
        let found = taken(&scene, Groups::default());
        assert!((estimate / found - 1.0).abs() < 0.15, "{film}: {estimate} {found}");
        without = if of_layers == 0.0 { found } else { without };
        assert!((found - without - of_layers * PIXELS).abs() < 0.02 * of_layers * PIXELS + 1.0, "{film}: {found}");
        let all = taken(&scene, Groups::of(&Group::ALL));
        assert!((all - without - 668.0 * PIXELS).abs() < 0.02 * 668.0 * PIXELS, "{film}: {all}");
    }
}

/// Scenes that have everything that is counted, between them.
fn scenes_of_everything(bench: &Bench) -> Vec<String> {
    file::write(&bench.path("i.png"), &Image::from_pixels(1, 1, vec![[0.5; 3]]).unwrap(), &[]).unwrap();
    let world = r#"LightSource "point" LightSource "spot" LightSource "distant" LightSource "infinite"
LightSource "infinite" "string filename" "i.png" LightSource "goniometric" "string filename" "i.png"
LightSource "projection" "string filename" "i.png"
AttributeBegin AreaLightSource "diffuse" Shape "disk" AttributeEnd
Material "conductor" Shape "sphere" Material "thindielectric" Shape "sphere"
Material "diffusetransmission" Shape "sphere" Material "coateddiffuse" Shape "sphere"
Material "coatedconductor" Shape "sphere" MakeNamedMaterial "a" "string type" "diffuse"
MakeNamedMaterial "b" "string type" "conductor"
Material "mix" "string materials" [ "a" "b" ] Shape "revolution" "point2 P" [ 0 0 .5 0 .6 .4 .6 1 ]
Material "diffuse" ObjectBegin "o" Shape "sphere" ObjectEnd ObjectInstance "o""#;
    let film = "Film \"rgb\" \"float whitebalance\" 5000";
    let filters = ["gaussian", "mitchell", "sinc", "box"];
    let text = scene(LIGHT, world).replace("Film \"rgb\"", film);
    filters.map(|filter| text.replace("Camera", &format!("PixelFilter \"{filter}\" Camera"))).into()
}

#[test]
fn the_schema_is_the_documented_one() {
    let bench = Bench::new();
    let mut schema = Schema::with_open(&["specialization"]);
    for text in scenes_of_everything(&bench) {
        bench.write("scene.pbrt", text);
        schema.add(&info(&bench, 0));
    }
    bench.write("scene.pbrt", scene("\"float radius\" 0.5", "").replace(LIGHT, "Shape \"curve\" Shape \"cube\""));
    schema.add(&info(&bench, 2));
    schema.assert_is(include_str!("schemas/info-1.txt"), "info-1.txt");
    schema.assert_documented("goblet info --json");
}

#[test]
fn the_schema_of_devices_is_the_documented_one() {
    let bench = Bench::new();
    let run = bench.run(&["devices", "--json"]);
    assert_eq!((run.code, run.stderr.as_str()), (0, ""), "{run:?}");
    let json: Value = serde_json::from_str(&run.stdout).unwrap();
    let text = bench.run(&["devices"]).stdout;
    let first = &json["devices"][0];
    for part in ["name", "driver", "kind"] {
        assert!(text.contains(first[part].as_str().unwrap()), "{part} in {text}");
    }
    assert!(first["memory"]["total"].as_u64() >= first["memory"]["free"].as_u64(), "{json:#}");
    let mut schema = Schema::default();
    schema.add(&json);
    schema.assert_documented("goblet devices --json");
}

#[test]
fn the_schema_of_statistics_is_the_documented_one() {
    let bench = Bench::new();
    let mut schema = Schema::with_open(&["scene", "passes", "cut", "non_finite", "saturated"]);
    for options in [&["--guide", "on", "--photons", "auto"][..], &["--guide", "off"]] {
        bench.rendered(&[&["--iterations", "16", "-o", "x.exr", "--stats", "x.json"], options].concat());
        schema.add(&bench.json("x.json"));
    }
    schema.assert_is(include_str!("schemas/stats-1.txt"), "stats-1.txt");
    schema.assert_documented("goblet render --stats");
}

/// Where no scene says how large discs are, `info` says it of the centre of the bounds.
#[test]
fn the_automatic_radius_is_three_pixels_at_a_distance() {
    let bench = Bench::new();
    bench.write("scene.pbrt", scene("\"float radius\" 0.5", ""));
    let integrator = &info(&bench, 0)["integrator"];
    let automatic = |key: &str| integrator["automatic_radius"][key].as_f64().unwrap();
    assert_eq!(integrator["radius"], Value::Null);
    // The bounds reach from (-2, -1, -2) to (2, 2, 2), the camera is at (0, 0, -3); 60 degrees are 12 pixels.
    let distance = (0.5_f64.powi(2) + 3.0 * 3.0).sqrt();
    let pixel = 2.0 * 30.0_f64.to_radians().tan() / 12.0 * distance;
    assert!((automatic("distance") / distance - 1.0).abs() < 1e-6, "{integrator:#}");
    assert!((automatic("at_distance") / (automatic("pixels") * pixel) - 1.0).abs() < 1e-6, "{integrator:#}");
    let text = bench.run(&["info", "scene.pbrt"]).stdout;
    assert!(text.contains("\n  first radius: 3 pixels: ") && text.contains(" at a distance of 3.041"), "{text}");
}

#[test]
fn people_read_units_and_few_digits() {
    let bench = Bench::new();
    let mut texts = scenes_of_everything(&bench);
    texts.push(scene("16 \"integer yresolution\" 12", "1600 \"integer yresolution\" 1200"));
    texts.push(scene("\"perspective\" \"float fov\" 60", "\"orthographic\" \"float lensradius\" .1234567"));
    for text in texts {
        bench.write("scene.pbrt", text.replace("\"integer photonsperiteration\" 500", ""));
        let run = bench.run(&["info", "scene.pbrt"]);
        assert_eq!(run.code, 0, "{run:?}");
        for debug in ["Some", "None", "{", "}", "[", "::", "true", "null", "_"] {
            assert!(!run.stdout.contains(debug), "`{debug}` in {}", run.stdout);
        }
        let digits = |word: &str| word.chars().filter(char::is_ascii_digit).count();
        let is_long = |word: &&str| word.contains('.') && word.parse::<f64>().is_ok() && digits(word) > 6;
        let long: Vec<&str> = run.stdout.split_whitespace().filter(is_long).collect();
        assert!(long.is_empty(), "{long:?} in {}", run.stdout);
        for unit in [" W\n", " pixels\n", " scene units\n", "iB\n", " segments\n"] {
            assert!(run.stdout.contains(unit), "{unit:?} in {}", run.stdout);
        }
    }
    let text = scene("\"integer photonsperiteration\" 500", "\"integer photonsperiteration\" 1234567");
    bench.write("scene.pbrt", text.replace("Film \"rgb\"", "Film \"rgb\" \"float whitebalance\" 5000"));
    let run = bench.run(&["info", "scene.pbrt"]);
    for line in [
        "\n  point: 62.83 W\n",
        "\n  photons per iteration: 1,234,567\n",
        "\n  projection: perspective\n  field of view: 60 degrees\n",
        "\n  position: 0 0 -3\n",
        "\n  resolution: 16 x 12 pixels\n",
        "\n  first radius: 0.5 scene units\n",
        "\n  exposure: 1\n  white balance: 5000 K\n",
        "\n  filter: gaussian, sigma 0.5, radius 1.5 x 1.5 pixels\n",
    ] {
        assert!(run.stdout.contains(line), "{line:?} in {}", run.stdout);
    }
}
